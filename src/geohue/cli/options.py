"""Options that several commands share, and the scene they name."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from geohue.errors import GeohueError

if TYPE_CHECKING:
    from geohue.scene import Scene

_FRAME = "Depth and camera"
_STEREO = "Stereo"

Source = Annotated[
    Path | None,
    typer.Argument(metavar="[COLOR|CLOUD]", help="Colour image (the left one), or a cloud."),
]
Depth = Annotated[
    Path | None, typer.Argument(metavar="[DEPTH]", help="Depth map registered to the image.")
]
Sample = Annotated[
    str | None,
    typer.Option(help="A built-in scene: motorcycle, motorcycle-stereo or motorcycle-matched."),
]
Intrinsics = Annotated[
    str | None,
    typer.Option(
        metavar="FILE|fx,fy,cx,cy", help="Camera of the depth map.", rich_help_panel=_FRAME
    ),
]
DepthScale = Annotated[
    str | None,
    typer.Option(
        metavar="M_PER_UNIT",
        help="Metres per unit of the depth map, or a name: tum, redwood, ...",
        rich_help_panel=_FRAME,
    ),
]
Right = Annotated[
    Path | None, typer.Option(help="Right image of a stereo pair.", rich_help_panel=_STEREO)
]
Disparity = Annotated[
    Path | None,
    typer.Option(
        help="Disparity of the left image; matched if not given.", rich_help_panel=_STEREO
    ),
]
DisparityScale = Annotated[
    str | None,
    typer.Option(
        metavar="PX_PER_UNIT",
        help="Pixels per unit of the disparity map, such as 1/256.",
        rich_help_panel=_STEREO,
    ),
]
Calib = Annotated[
    str | None,
    typer.Option(
        metavar="FILE|f,baseline[,doffs]",
        help="Calibration of the stereo pair.",
        rich_help_panel=_STEREO,
    ),
]
Views = Annotated[
    int,
    typer.Option(
        min=1, max=2, help="Colours of one view or of both (eq. 19).", rich_help_panel=_STEREO
    ),
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON on standard output.")]


def load_scene(
    source: Path | None,
    depth: Path | None = None,
    sample: str | None = None,
    *,
    intrinsics: str | None = None,
    depth_scale: str | None = None,
    right: Path | None = None,
    disparity: Path | None = None,
    disparity_scale: str | None = None,
    calib: str | None = None,
    views: int = 2,
) -> Scene:
    """Read the scene that a command's arguments name.

    Raises
    ------
    GeohueError
        If nothing or too much is named, or a file cannot be used.
    """
    if sample is not None:
        if source is not None:
            raise GeohueError(f"both {source} and --sample {sample} given: choose one")
        from geohue.datasets import load_sample

        return load_sample(sample)
    if source is None:
        raise GeohueError("no scene: give COLOR DEPTH, a cloud, or --sample motorcycle")
    stereo: dict[str, Any] = {
        "--disparity": disparity,
        "--disparity-scale": disparity_scale,
        "--calib": calib,
    }
    if right is None:
        lost = [name for name, value in stereo.items() if value is not None]
        if lost:
            raise GeohueError(f"{lost[0]} is for stereo pairs: give the right image with --right")
        from geohue.io.scenes import read_scene

        return read_scene(source, depth, intrinsics, _scale(depth_scale))
    if depth is not None or intrinsics is not None or depth_scale is not None:
        raise GeohueError("--right is for stereo pairs: leave out DEPTH and its options")
    from geohue.io.stereo_scenes import read_stereo_scene

    return read_stereo_scene(source, right, disparity, disparity_scale, calib, views)


def _scale(text: str | None) -> float | str | None:
    if text is None:
        return None
    try:
        return float(text)
    except ValueError:
        return text
