"""Calibration of a depth (infrared) and a colour camera from pictures of a checkerboard (VI-C)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics
from geohue.errors import GeohueError
from geohue.sensors.lens import Lens
from geohue.sensors.rig import PosedCamera, Rig
from geohue.stereo.calibrate import board_points, find_corners

_FEWEST = 3
_POOR = 1.0  # pixels of reprojection error that say that something is wrong

Image = NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """A calibrated rig and how well it fits.

    Attributes
    ----------
    rig : Rig
        The first camera as the depth camera, the second as the colour camera.
    rms : (float, float, float)
        Root mean square reprojection error in pixels: first camera, second camera, both together.
    used : tuple of int
        The pairs in which both cameras see the whole board.
    """

    rig: Rig
    rms: tuple[float, float, float]
    used: tuple[int, ...]


def calibrate_rig(
    depth_images: Sequence[Image],
    color_images: Sequence[Image],
    pattern: tuple[int, int],
    square: float,
) -> Calibration:
    """Calibrate two cameras from simultaneous pictures of a checkerboard.

    As the paper does with OpenCV: the amplitude or infrared pictures of the depth camera (its
    projector covered, so that the board is visible) and the colour camera's pictures give both
    cameras' intrinsics, then R and T between them.

    Parameters
    ----------
    depth_images, color_images : sequence of (H, W) or (H, W, 3) uint8
        Pairs in the same order, at least three with the board in different poses; more are better.
    pattern : (int, int)
        Inner corners a row and a column.
    square : float
        Side of a square in metres.

    Returns
    -------
    Calibration

    Raises
    ------
    GeohueError
        If the numbers differ, or fewer than three pairs show the whole board.
    """
    cv2: Any = import_module("cv2")
    if len(depth_images) != len(color_images):
        raise GeohueError(
            f"{len(depth_images)} depth and {len(color_images)} colour pictures: pairs are needed"
        )
    if not (min(pattern) >= 2 and 0 < square < np.inf):
        raise GeohueError(f"pattern {pattern} of squares of {square} m: no checkerboard")
    corners = [
        (find_corners(a, pattern), find_corners(b, pattern))
        for a, b in zip(depth_images, color_images, strict=True)
    ]
    used = tuple(i for i, (a, b) in enumerate(corners) if a is not None and b is not None)
    if len(used) < _FEWEST:
        raise GeohueError(
            f"{len(used)} of {len(corners)} pairs show all {pattern[0]} x {pattern[1]} inner "
            f"corners in both pictures: at least {_FEWEST} are needed; check the pattern"
        )
    board = [board_points(pattern, square)] * len(used)
    sides = [[corners[i][side] for i in used] for side in (0, 1)]
    sizes = [(im[used[0]].shape[1], im[used[0]].shape[0]) for im in (depth_images, color_images)]
    single = [
        cv2.calibrateCamera(board, points, size, None, None)
        for points, size in zip(sides, sizes, strict=True)
    ]
    (rms1, K1, D1, *_), (rms2, K2, D2, *_) = single
    rms, _, _, _, _, R, T, _, _ = cv2.stereoCalibrate(
        *(board, sides[0], sides[1], K1, D1, K2, D2, sizes[0]), flags=cv2.CALIB_FIX_INTRINSIC
    )
    lenses = [_lens(K, D, size) for K, D, size in zip((K1, K2), (D1, D2), sizes, strict=True)]
    errors = (float(rms1), float(rms2), float(rms))
    doubts = tuple(
        f"reprojection error {error:.2f} px ({name}): more than {_POOR} px is poor"
        for name, error in zip(("depth", "colour", "both"), errors, strict=True)
        if error > _POOR
    )
    camera = PosedCamera(lenses[1], np.asarray(R, np.float64), np.asarray(T, np.float64).ravel())
    return Calibration(Rig((camera,), lenses[0], warnings=doubts), errors, used)


def _lens(K: NDArray[np.float64], D: NDArray[np.float64], size: tuple[int, int]) -> Lens:
    camera = Intrinsics(
        float(K[0, 0]), float(K[1, 1]), float(K[0, 2]), float(K[1, 2]), size[0], size[1]
    )
    return Lens(camera, tuple(float(d) for d in np.ravel(D)[:5]))
