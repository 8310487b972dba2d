"""Pictures that a camera stored turned, with the mark (EXIF orientation) that says how."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics

Kind = TypeVar("Kind", bound=np.generic)

_TURNS = {
    1: (0, False),
    2: (0, True),
    3: (2, False),
    4: (2, True),
    5: (-1, True),
    6: (-1, False),
    7: (1, True),
    8: (1, False),
}
"""Quarter turns to the left, and whether the result is mirrored, for each mark of EXIF."""


def swaps_sides(orientation: int) -> bool:
    """Whether the mark exchanges width and height."""
    return orientation >= 5


def upright(array: NDArray[Kind], orientation: int) -> NDArray[Kind]:
    """Turn an array of pixels as its mark says.

    Parameters
    ----------
    array : (H, W) or (H, W, C)
        As it is stored.
    orientation : int
        EXIF's mark, 1 to 8; 1 for a picture that is stored as it is seen.

    Returns
    -------
    (H, W, ...) or (W, H, ...)

    Examples
    --------
    >>> upright(np.array([[1, 2], [3, 4]]), 6).tolist()
    [[3, 1], [4, 2]]
    """
    turns, mirrored = _TURNS[orientation]
    turned = np.rot90(array, turns)
    return np.ascontiguousarray(turned[:, ::-1] if mirrored else turned)


def upright_camera(camera: Intrinsics, orientation: int, width: int, height: int) -> Intrinsics:
    """Turn a camera together with its picture.

    Parameters
    ----------
    camera : Intrinsics
        Of the picture as it is stored.
    orientation : int
        EXIF's mark, 1 to 8.
    width, height : int
        Size of the stored picture.

    Returns
    -------
    Intrinsics
        Of the picture as it is seen.

    Examples
    --------
    >>> turned = upright_camera(Intrinsics(9.0, 8.0, 1.0, 2.0), 6, 10, 6)
    >>> turned.fx, turned.fy, turned.cx, turned.cy
    (8.0, 9.0, 3.0, 1.0)
    """
    camera = replace(camera, width=width, height=height)
    turns, mirrored = _TURNS[orientation]
    for _ in range(turns % 4):
        camera = _turned_left(camera)
    return _mirrored(camera) if mirrored else camera


def _turned_left(camera: Intrinsics) -> Intrinsics:
    """Turn by a quarter to the left: a pixel (x, y) comes to (y, W - 1 - x)."""
    wide = camera.width or 0
    return Intrinsics(
        camera.fy,
        camera.fx,
        camera.cy,
        wide - 1 - camera.cx,
        camera.height,
        camera.width,
        camera.depth_scale,
    )


def _mirrored(camera: Intrinsics) -> Intrinsics:
    return replace(camera, cx=(camera.width or 0) - 1 - camera.cx)
