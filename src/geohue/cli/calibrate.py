"""``geohue calibrate``: two cameras from pictures of a checkerboard."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from geohue.cli.console import print_json, warn
from geohue.cli.options import AsJson
from geohue.errors import GeohueError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


_SIDES = ("left", "right")


def calibrate(
    images: Annotated[
        list[Path],
        typer.Argument(
            metavar="LEFT... RIGHT...", help="All left pictures, then all right ones, in one order."
        ),
    ],
    pattern: Annotated[
        str, typer.Option(metavar="COLSxROWS", help="Inner corners of the board.")
    ] = "9x6",
    rig: Annotated[
        bool,
        typer.Option("--rig", help="The left camera is the infrared one of a depth sensor."),
    ] = False,
    square: Annotated[
        float, typer.Option(metavar="METRES", help="Side of a square; the unit of the baseline.")
    ] = 1.0,
    out: Annotated[
        Path, typer.Option("-o", "--out", metavar="DIR", help="Where results go.")
    ] = Path("geohue-calibration"),
    as_json: AsJson = False,
) -> None:
    """Calibrate a stereo pair, or a depth sensor and a camera, from pictures of a checkerboard.

    Writes stereo.yml (OpenCV: K1 D1 K2 D2 R T) for --calib, and rectified.png, the first pair
    rectified with level lines that must meet the same points in both views. With --rig writes
    calibration.json for geohue register and --camera; --square must then be in metres.
    """
    from geohue.read import read_color
    from geohue.results import write_png
    from geohue.results.stereo_calibration import write_stereo_calibration
    from geohue.stereo import calibrate_stereo, epipolar_preview

    _check_sides(images)
    half = len(images) // 2
    pairs = [(read_color(a), read_color(b)) for a, b in zip(images[:half], images[half:])]  # noqa: B905
    names = [path.name for path in images[:half]]
    if rig:
        _calibrate_rig(pairs, names, _pattern(pattern), square, out, as_json)
        return
    found = calibrate_stereo(pairs, _pattern(pattern), square, names=names)
    errors = {
        "reprojection_error_px": found.error,
        "left_error_px": found.left_error,
        "right_error_px": found.right_error,
    }
    write_stereo_calibration(out / "stereo.yml", found.rig, errors)
    first = pairs[found.used[0]]
    write_png(out / "rectified.png", epipolar_preview(*first, found.rig))
    warn(found.warnings)
    views = [
        {"left": names[i], "left_error_px": float(a), "right_error_px": float(b)}
        for i, (a, b) in zip(found.used, found.view_errors, strict=True)
    ]
    left, right = found.rig.left, found.rig.right
    report = {
        **errors,
        "left_fx_fy_cx_cy": [left.fx, left.fy, left.cx, left.cy],
        "right_fx_fy_cx_cy": [right.fx, right.fy, right.cx, right.cy],
        "baseline": found.rig.baseline,
        "views": views,
        "warnings": list(found.warnings),
    }
    if as_json:
        print_json(report)
        return
    for view in views:
        typer.echo(f"{view['left']:24} {view['left_error_px']:.3f} {view['right_error_px']:.3f} px")
    typer.echo(f"reprojection error {found.error:.3f} px over {len(views)} pairs")
    typer.echo(f"{out}: stereo.yml, rectified.png")


def _check_sides(images: list[Path]) -> None:
    """Raise an error unless there are as many right pictures as left ones, by their names."""
    named = [_side(path) for path in images]
    counts = [named.count(side) for side in ("left", "right")]
    even = len(images) % 2 == 0
    half = len(images) // 2
    if None not in named and not (even and named == ["left"] * half + ["right"] * half):
        lefts, rights = (_counted(n, side) for n, side in zip(counts, _SIDES, strict=True))
        if counts[0] != counts[1]:
            mend = "give a right one for every left one, and no other"
        else:
            mend = "give all left ones first, then all right ones in the same order"
        raise GeohueError(f"{lefts} and {rights}: {mend}")
    if not even:
        raise GeohueError(f"{len(images)} pictures: give as many right ones as left ones")


def _side(path: Path) -> str | None:
    """Return which camera a picture's name or folder names, None if neither or both."""
    for text in (path.stem.lower(), path.parent.name.lower()):
        found = [side for side in _SIDES if side in text]
        if len(found) == 1:
            return found[0]
    return None


def _counted(n: int, side: str) -> str:
    return f"{n} {side} picture{'' if n == 1 else 's'}"


def _calibrate_rig(
    pairs: list[tuple[NDArray[np.uint8], NDArray[np.uint8]]],
    names: list[str],
    pattern: tuple[int, int],
    square: float,
    out: Path,
    as_json: bool,
) -> None:
    from geohue.results.rig import write_rig
    from geohue.sensors.calibration import calibrate_rig

    found = calibrate_rig([a for a, _ in pairs], [b for _, b in pairs], pattern, square)
    write_rig(out / "calibration.json", found.rig)
    warn(found.rig.warnings)
    report = {
        "depth_error_px": found.rms[0],
        "color_error_px": found.rms[1],
        "reprojection_error_px": found.rms[2],
        "used": [names[i] for i in found.used],
    }
    if as_json:
        print_json(report)
        return
    typer.echo(f"reprojection error {found.rms[2]:.3f} px over {len(found.used)} pairs")
    typer.echo(f"{out}: calibration.json")


def _pattern(text: str) -> tuple[int, int]:
    try:
        columns, rows = (int(part) for part in text.lower().split("x"))
    except ValueError:
        raise GeohueError(f"--pattern {text}: expected inner corners, such as 9x6") from None
    return columns, rows
