"""Which points of a scene lie side by side."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.scene import Scene

CLOUD_NEIGHBOURS = 5
"""Nearest points that a point of a cloud counts as beside it."""


def adjacent_points(scene: Scene) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pair the points of a scene that lie side by side.

    Parameters
    ----------
    scene : Scene
        Points without geometry take no part.

    Returns
    -------
    one, other : (E,) int64
        Flat positions: each two pixels that share a side; each point of a cloud with its
        `CLOUD_NEIGHBOURS` nearest.

    Examples
    --------
    >>> scene = Scene.from_rgbd(np.zeros((2, 2, 3), np.uint8), np.ones((2, 2)))
    >>> one, other = adjacent_points(scene)
    >>> list(zip(one.tolist(), other.tolist()))
    [(0, 1), (2, 3), (0, 2), (1, 3)]
    """
    if scene.is_grid:
        one, other = adjacent_pixels(scene.shape)
        valid = scene.valid.reshape(-1)
        both = valid[one] & valid[other]
        return one[both], other[both]
    from scipy.spatial import cKDTree

    index = np.flatnonzero(scene.valid)
    points = scene.points[index]
    k = min(CLOUD_NEIGHBOURS + 1, len(points))
    _, near = cKDTree(points).query(points, k)
    near = np.asarray(near).reshape(len(points), -1)[:, 1:]
    return np.repeat(index, near.shape[1]), index[near.ravel()]


def adjacent_pixels(shape: tuple[int, ...]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pair the pixels of a grid that share a side; flat positions."""
    index = np.arange(shape[0] * shape[1]).reshape(shape)
    one = np.concatenate([index[:, :-1].ravel(), index[:-1].ravel()])
    other = np.concatenate([index[:, 1:].ravel(), index[1:].ravel()])
    return one, other


def nearest_known(known: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the flat position of the known pixel nearest to each, (H, W); one must be known.

    Examples
    --------
    >>> nearest_known(np.array([[True, False, False, True]])).tolist()
    [[0, 0, 3, 3]]
    """
    index = np.arange(known.size).reshape(known.shape)
    if known.all():
        return index
    from scipy.ndimage import distance_transform_edt

    y, x = distance_transform_edt(~known, return_distances=False, return_indices=True)
    return np.asarray(index[y, x])
