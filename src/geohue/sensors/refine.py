"""A calibration that is a little off: T between depth and colour camera from the edges."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.sensors.alignment import edge_agreement
from geohue.sensors.registration import register_depth
from geohue.sensors.rig import Rig

_WIDTH = 240  # of the pictures that are compared
_STEPS = 5  # tried on either side in each round
_ROUNDS = 2
_GAIN = 1.1  # by which the edges must agree better for a change to count

Pair = tuple[NDArray[np.uint8], NDArray[np.floating[Any]]]


def refine_translation(
    frames: Sequence[Pair], rig: Rig, reach: float = 0.04, camera: int = 0
) -> tuple[Rig, float, float]:
    """Move a colour camera sideways and up or down until the edges of depth and colour agree.

    For calibrations of another device of the same make, or of one that took a knock: their T is
    off by millimetres to centimetres, which the paper saw at the edges of Kinect scenes (Sec.
    VI-C). R, the lenses and the distance along the axis stay.

    Parameters
    ----------
    frames : sequence of (picture, depth)
        One or more pairs; several with objects at different distances tell more.
    rig : Rig
        The calibration to start from.
    reach : float
        Most metres that each coordinate of T may change.
    camera : int
        Which of the rig's colour cameras.

    Returns
    -------
    rig : Rig
        With the new T and a warning that tells it; as given where nothing agrees 10 % better.
    before, after : float
        Mean edge agreement with the old and the new T, at a quarter of the pixels or less.

    Raises
    ------
    GeohueError
        If there are no frames, or no edges to go by.
    """
    if not frames or not 0 < reach < np.inf:
        raise GeohueError("refining needs at least one frame and a positive reach")
    small = [_small(rgb, depth) for rgb, depth in frames]

    def score(shift: NDArray[np.float64]) -> float:
        moved = _moved(rig, shift, camera)
        values = [
            edge_agreement(rgb, register_depth(depth, moved, rgb.shape[1::-1], camera))
            for rgb, depth in small
        ]
        return float(np.mean(values))

    start = np.zeros(3)
    before = score(start)
    if not np.isfinite(before):
        raise GeohueError("the frames have no edges of depth to go by: give others")
    best, after = _climb(score, before, reach)
    if after < _GAIN * before:
        return rig, before, before
    new = _moved(rig, best, camera)
    T = new.cameras[camera].translation
    gain = after / before
    note = f"T was changed to {T.round(4).tolist()} m: the edges agree {gain:.2f} times better"
    return replace(new, warnings=(*rig.warnings, note)), before, after


def _climb(
    score: Callable[[NDArray[np.float64]], float], before: float, reach: float
) -> tuple[NDArray[np.float64], float]:
    """Search x, then y, in ever smaller steps."""
    best, top = np.zeros(3), before
    step = reach / _STEPS
    for _ in range(_ROUNDS):
        for axis in (0, 1):
            centre = best.copy()
            for k in (*range(-_STEPS, 0), *range(1, _STEPS + 1)):
                tried = centre.copy()
                tried[axis] += k * step
                if abs(tried[axis]) > reach * 1.0001:
                    continue
                value = score(tried)
                if value > top:
                    best, top = tried, value
        step /= _STEPS
    return best, top


def _moved(rig: Rig, shift: NDArray[np.float64], camera: int) -> Rig:
    cameras = list(rig.cameras)
    old = cameras[camera]
    cameras[camera] = replace(old, translation=old.translation + shift)
    return replace(rig, cameras=tuple(cameras))


def _small(rgb: NDArray[np.uint8], depth: NDArray[np.floating[Any]]) -> Pair:
    import cv2

    height, width = rgb.shape[:2]
    if width > _WIDTH:
        size = (_WIDTH, max(1, round(height * _WIDTH / width)))
        rgb = np.asarray(cv2.resize(rgb, size, interpolation=cv2.INTER_AREA), np.uint8)
    # A whole step keeps measured depths; it moves them by half a pixel at most.
    step = max(1, round(depth.shape[1] / _WIDTH))
    rows, columns = (n // step * step for n in depth.shape)
    return rgb, depth[step // 2 : rows : step, step // 2 : columns : step]
