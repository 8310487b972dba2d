"""Where the labels of the last frame lie in the next one."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics

Labels = NDArray[np.int32]
Values = TypeVar("Values", bound=np.generic)
Pose = NDArray[np.float64]

NEARER = 0.95
"""Depths of which the lesser is at least so much of the greater are of one surface."""


def resized(values: NDArray[Values], shape: tuple[int, ...]) -> NDArray[Values]:
    """Return a map in another size, each pixel with the nearest value.

    Examples
    --------
    >>> resized(np.array([[1, 2]], np.int32), (2, 4)).tolist()
    [[1, 1, 2, 2], [1, 1, 2, 2]]
    """
    if values.shape == shape:
        return values
    y, x = (np.arange(n) * old // n for n, old in zip(shape, values.shape, strict=True))
    return np.asarray(values[y[:, None], x])


def reprojected(
    labels: Labels,
    points: NDArray[np.floating],
    way: Pose,
    camera: Intrinsics,
    positions: NDArray[np.int64],
    size: tuple[int, ...],
) -> tuple[Labels, NDArray[np.float64]]:
    """Carry the labels of a draft along the motion of the camera.

    Parameters
    ----------
    labels : (h, w) int32
        Labels of the last draft.
    points : (h, w, 3) float
        Its positions in the camera of the last frame; NaN where there is none.
    way : (4, 4) float64
        From the last camera to this one.
    camera : Intrinsics
        This camera, for pictures of `size`.
    positions : (h2, w2) int64
        The places of this draft in the picture.
    size : tuple of int
        Height and width of the picture.

    Returns
    -------
    labels : (h2, w2) int32
        -1 where no point falls.
    depth : (h2, w2) float64
        How far from this camera the points lie, NaN where none falls.
    """
    rows, columns = positions[:, 0] // size[1], positions[0] % size[1]
    shape = len(rows), len(columns)
    out, far = np.full(shape, -1, np.int32), np.full(shape, np.nan)
    flat, names = points.reshape(-1, 3), labels.reshape(-1)
    there = np.isfinite(flat[:, 2]) & (names >= 0)
    xyz, names = flat[there] @ way[:3, :3].T + way[:3, 3], names[there]
    front = xyz[:, 2] > 1e-9
    xyz, names = xyz[front], names[front]
    u = camera.fx * xyz[:, 0] / xyz[:, 2] + camera.cx
    v = camera.fy * xyz[:, 1] / xyz[:, 2] + camera.cy
    step_y = rows[1] - rows[0] if len(rows) > 1 else size[0]
    step_x = columns[1] - columns[0] if len(columns) > 1 else size[1]
    i = np.rint(np.clip((v - rows[0]) / step_y, -9, 2 * len(rows))).astype(np.int64)
    j = np.rint(np.clip((u - columns[0]) / step_x, -9, 2 * len(columns))).astype(np.int64)
    inside = (i >= 0) & (j >= 0) & (i < shape[0]) & (j < shape[1])
    i, j, depth, names = i[inside], j[inside], xyz[inside, 2], names[inside]
    order = np.argsort(-depth, kind="stable")  # the nearest is written last
    out[i[order], j[order]], far[i[order], j[order]] = names[order], depth[order]
    return out, far


def agreeing(labels: Labels, expected: NDArray[np.floating], depth: NDArray[np.floating]) -> Labels:
    """Leave out labels where depth is not what it should be, by more than `NEARER` allows.

    What moved away or came into view there is not what had the label.

    Parameters
    ----------
    labels : (h, w) int32
    expected, depth : (h, w) float
        Depth of what has the label, and of this frame; NaN where it is not known, which keeps the
        label.

    Examples
    --------
    >>> agreeing(np.int32([[0, 0]]), np.array([[1.0, 1.0]]), np.array([[1.0, 3.0]])).tolist()
    [[0, -1]]
    """
    with np.errstate(invalid="ignore"):
        changed = np.minimum(expected, depth) < NEARER * np.maximum(expected, depth)
    return np.where(changed, np.int32(-1), labels)
