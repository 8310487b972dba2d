"""Depth maps of another resolution than their picture, both in one view."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

SAME_SHAPE = 0.02
"""Relative difference of the proportions up to which two pictures may show the same view."""

_SMOOTH = 0.05  # relative difference of depth up to which neighbours lie on one surface


def same_shape(one: tuple[int, ...], other: tuple[int, ...]) -> bool:
    """Whether two sizes, (H, W), have the same proportions.

    Examples
    --------
    >>> same_shape((192, 256), (1440, 1920)), same_shape((424, 512), (1080, 1920))
    (True, False)
    """
    return abs(one[0] * other[1] / (one[1] * other[0]) - 1) <= SAME_SHAPE


def scale_depth(depth: NDArray[np.floating[Any]], shape: tuple[int, int]) -> NDArray[np.float32]:
    """Bring a depth map to the size of its picture; no two surfaces are averaged.

    Between four depth pixels that lie on one surface (within 5 %), 1/Z is interpolated, which is
    exact for planes. Across an edge, and beside missing values, the nearest pixel counts.

    Parameters
    ----------
    depth : (h, w) float
        NaN where missing.
    shape : (int, int)
        Rows and columns of the picture.

    Returns
    -------
    shape, float32
        NaN where the nearest depth pixel is missing.

    Examples
    --------
    >>> scale_depth(np.array([[1.0, 3.0]]), (1, 4)).tolist()
    [[1.0, 1.0, 3.0, 3.0]]
    """
    inverse = 1 / np.asarray(depth, np.float32)
    rows, columns = (_places(n, m) for n, m in zip(shape, depth.shape, strict=True))
    found = np.empty(shape, np.float32)
    for y, (low, high, share) in enumerate(zip(*rows, strict=True)):
        found[y] = _row(inverse[low], inverse[high], share, columns)
    return np.asarray(1 / found, np.float32)


def sample_nearest(values: NDArray[Any], shape: tuple[int, int]) -> NDArray[Any]:
    """Bring a map to another size, each pixel from the nearest one.

    Examples
    --------
    >>> sample_nearest(np.array([[1, 2]]), (1, 4)).tolist()
    [[1, 1, 2, 2]]
    """
    rows, columns = (
        np.minimum((np.arange(n) * 2 + 1) * m // (2 * n), m - 1)
        for n, m in zip(shape, values.shape[:2], strict=True)
    )
    return np.asarray(values[rows[:, None], columns])


def _places(n: int, m: int) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float32]]:
    """Return the two of m pixels that each of n lies between, and how far it is to the second."""
    place = np.clip((np.arange(n) + 0.5) * m / n - 0.5, 0, m - 1)
    low = np.floor(place).astype(np.int64)
    return low, np.minimum(low + 1, m - 1), (place - low).astype(np.float32)


def _row(
    above: NDArray[np.float32],
    below: NDArray[np.float32],
    share: np.float32,
    columns: tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float32]],
) -> NDArray[np.float32]:
    """Return 1/Z of one row of the picture, between two rows of the depth map."""
    left, right, across = columns
    corners = np.stack([above[left], above[right], below[left], below[right]])
    top = corners[0] + across * (corners[1] - corners[0])
    bottom = corners[2] + across * (corners[3] - corners[2])
    nearest = np.where(across < 0.5, corners[0], corners[1])
    if share >= 0.5:
        nearest = np.where(across < 0.5, corners[2], corners[3])
    # NaN in any corner makes this comparison false.
    smooth = corners.max(axis=0) <= (1 + _SMOOTH) * corners.min(axis=0)
    return np.asarray(np.where(smooth, top + share * (bottom - top), nearest), np.float32)
