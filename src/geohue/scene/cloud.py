"""Points with or without colours, checked, with what is odd about them counted."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geohue.compute.checks import centered, check_cloud_colors, check_normals, is_real
from geohue.errors import GeohueError
from geohue.scene.given import Notes, Picture, is_path, read

_FAR = 1e4  # times the median distance from the middle: no part of what was scanned
_GREY = 128


@dataclass(frozen=True, slots=True, eq=False)
class Cloud:
    """What `cloud_given` returns, all of one leading shape."""

    points: NDArray[np.float32]
    colors: NDArray[np.uint8]
    normals: NDArray[np.float32] | None
    has_colors: bool
    offset: tuple[float, float, float]
    source: Path | None
    notes: Notes


def cloud_given(points: Picture, colors: ArrayLike | None, normals: ArrayLike | None) -> Cloud:
    """Check a cloud that is given as arrays or as a file."""
    notes: list[str] = []
    taken, source = np.zeros(3), None
    if is_path(points):
        if colors is not None or normals is not None:
            raise GeohueError(f"{points} has its own colours and normals: leave out the others")
        data, said = read("cloud", Path(points))
        notes += said
        points, colors, normals = data.points, data.colors, data.normals
        notes += _place_note(data.source, data.offset)
        taken, source = data.offset, data.source
    xyz = np.asarray(points)
    if xyz.ndim not in (2, 3) or xyz.shape[-1] != 3 or not is_real(xyz):
        raise GeohueError(
            f"points have shape {xyz.shape} and type {xyz.dtype}: "
            "expected (N, 3) or (H, W, 3) numbers"
        )
    if colors is None:
        rgb = np.full(xyz.shape, _GREY, np.uint8)
        notes.append("no colours: the geometry alone tells the parts apart")
    else:
        rgb = check_cloud_colors(np.asarray(colors), xyz.shape)
    cast, near = centered(xyz)
    x, y, z = (taken + np.asarray(near)).tolist()
    notes += oddities(cast)
    unit = check_normals(normals, xyz.shape)
    return Cloud(cast, rgb, unit, colors is not None, (x, y, z), source, tuple(notes))


def _place_note(source: object, offset: NDArray[np.float64]) -> list[str]:
    if not offset.any():
        return []
    place = ", ".join(f"{value:.10g}" for value in offset)
    return [f"{source}: coordinates are relative to ({place})"]


def without_place(missing: int, n_points: int) -> list[str]:
    """Say how many points of a cloud have no place; nothing if all have one.

    Examples
    --------
    >>> without_place(2, 9)
    ['2 of 9 points have no finite coordinates and are left out']
    """
    verb = (
        "has no finite coordinates and is" if missing == 1 else "have no finite coordinates and are"
    )
    return [f"{missing} of {n_points} points {verb} left out"] if missing else []


def oddities(points: NDArray[np.float32]) -> list[str]:
    """Count the points without a place, and those absurdly far from all others.

    Parameters
    ----------
    points : (N, 3) or (H, W, 3) float32
        NaN where missing. On a grid, gaps are what a sensor did not see, and are not counted.

    Examples
    --------
    >>> cloud = np.random.default_rng(0).normal(size=(9, 3)).astype(np.float32)
    >>> cloud[0], cloud[1] = np.nan, 1e9
    >>> for note in oddities(cloud):
    ...     print(note)
    1 of 9 points has no finite coordinates and is left out
    1 of 9 points lies over 10000 times farther out than most: remove what is garbage, ...
    """
    flat = points.reshape(-1, 3)
    known = np.isfinite(flat).all(axis=1)
    notes = []
    if points.ndim == 2:
        notes += without_place(len(flat) - int(known.sum()), len(flat))
    away = flat[known].astype(np.float64)
    if not len(away):
        return notes
    distance = np.linalg.norm(away - np.median(away, axis=0), axis=1)
    middle = float(np.median(distance))
    absurd = int((distance > _FAR * middle).sum()) if middle > 0 else 0
    if absurd:
        verb = "lies" if absurd == 1 else "lie"
        notes.append(
            f"{absurd} of {len(flat)} points {verb} over {_FAR:.0f} times farther out than most: "
            "remove what is garbage, since the extent of the scene counts"
        )
    return notes
