"""Unit normals of a grid and of a cloud, robust on quantised and noisy positions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.compute.blur import gaussian_blur
from geohue.compute.compiled import compiled

Floats = NDArray[np.float64]

BLUR = 1.5
"""Pixels of the draft that positions are blurred by before they are differentiated."""

NEIGHBOURS = 16
"""Points of a cloud that a tangent plane is fitted to."""


def grid_normals(points: Floats, sigma: float = BLUR) -> Floats:
    """Return the normals of points on a grid, which point away from the camera.

    The points are blurred, since a step of a quantised depth map would turn the normal by tens of
    degrees; the normal is the cross product of the differences along rows and columns.

    Parameters
    ----------
    points : (H, W, 3) float64
        Positions, all finite; x to the right, y down, z forward.
    sigma : float
        Standard deviation of the blur in pixels.

    Returns
    -------
    (H, W, 3) float64
        Of unit length; zeros where the points do not span a plane.

    Examples
    --------
    >>> y, x = np.mgrid[:4, :5].astype(float)
    >>> grid_normals(np.stack([x, y, 2 + 0 * x], axis=-1))[2, 2].tolist()
    [0.0, 0.0, 1.0]
    """
    if min(points.shape[:2]) < 2:
        return np.zeros_like(points)
    for axis in (0, 1):
        points = gaussian_blur(points, sigma, axis, truncate=3.0)
    right, down = np.gradient(points, axis=1), np.gradient(points, axis=0)
    return _unit(np.cross(right, down))


def cloud_normals(points: Floats, k: int = NEIGHBOURS) -> Floats:
    """Return the normals of the points of a cloud, of one consistent sign as far as possible.

    Each is the direction of least spread of the `k` nearest points. Signs are carried along the
    spanning tree of neighbours that turns least (Hoppe et al., 1992); the sign of each tree is the
    one with which most normals point inward, to the middle of the points.

    Parameters
    ----------
    points : (n, 3) float64
        Positions, all finite.
    k : int
        Neighbours, the point itself among them.

    Returns
    -------
    (n, 3) float64
        Of unit length.

    References
    ----------
    H. Hoppe, T. DeRose, T. Duchamp, J. McDonald, W. Stuetzle, "Surface reconstruction from
    unorganized points", SIGGRAPH 1992.

    Examples
    --------
    >>> x, y = np.mgrid[:5, :5].reshape(2, -1).astype(float)
    >>> np.abs(cloud_normals(np.stack([x, y, 0 * x], axis=1)))[7].round(6).tolist()
    [0.0, 0.0, 1.0]
    """
    from scipy.spatial import cKDTree

    n = len(points)
    if n < 3:
        return np.zeros((n, 3))
    near = np.asarray(cKDTree(points).query(points, min(k, n))[1], np.int64)
    around = points[near] - points[near].mean(axis=1, keepdims=True)
    _, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", around, around))
    return _oriented(points, vectors[:, :, 0], near)


def _oriented(points: Floats, normals: Floats, near: NDArray[np.int64]) -> Floats:
    """Carry signs from point to point along the tree that turns least."""
    n, k = near.shape
    pairs = np.stack([np.repeat(np.arange(n), k), near.reshape(-1)], axis=1)
    low, high = pairs.min(axis=1), pairs.max(axis=1)
    keys = np.unique((low * n + high)[low != high])
    return oriented_along(points, normals, keys // n, keys % n)


def oriented_along(
    points: Floats, normals: Floats, one: NDArray[np.int64], other: NDArray[np.int64]
) -> Floats:
    """Turn normals so that neighbours agree and most point inward.

    Parameters
    ----------
    points, normals : (n, 3) float64
        All finite.
    one, other : (E,) int64
        Pairs of neighbours, each once.

    Returns
    -------
    (n, 3) float64
        The normals, each with the sign that the tree of neighbours that turns least carries to it.
    """
    from scipy.sparse import coo_array, csgraph

    n = len(points)
    turn = 1.0 - np.abs((normals[one] * normals[other]).sum(axis=1))
    graph = coo_array((turn + 1e-6, (one, other)), shape=(n, n)).tocsr()  # 0 would be no pair
    tree = csgraph.minimum_spanning_tree(graph)
    trees, tree_of = csgraph.connected_components(tree, directed=False)
    sign = np.ones(n)
    for root in np.unique(tree_of, return_index=True)[1]:
        order, before = csgraph.breadth_first_order(tree, root, directed=False)
        _carry(normals, order.astype(np.int64), before.astype(np.int64), sign)
    normals = normals * sign[:, None]
    inward = (normals * (points.mean(axis=0) - points)).sum(axis=1)
    total = np.bincount(tree_of, inward, trees)
    return np.asarray(normals * np.where(total < 0, -1.0, 1.0)[tree_of][:, None])


@compiled
def _carry(
    normals: Floats, order: NDArray[np.int64], before: NDArray[np.int64], sign: Floats
) -> None:
    """Give each point in turn the sign with which its normal turns least from the one before."""
    for i in range(1, order.size):
        point, known = order[i], before[order[i]]
        turn = 0.0
        for axis in range(3):
            turn += normals[point, axis] * normals[known, axis]
        if sign[known] * turn < 0:
            sign[point] = -1.0


def _unit(vectors: Floats) -> Floats:
    length = np.sqrt((vectors**2).sum(axis=-1, keepdims=True))
    return np.asarray(vectors / np.where(length > 0, length, 1.0))
