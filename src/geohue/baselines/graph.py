"""Graphs over pixels or points, and their merging after Felzenszwalb and Huttenlocher."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.baselines.kernels import compiled, find_root, join_roots

NEIGHBOURS = 8
"""Nearest neighbours of a point of a cloud: as many as a pixel has."""


def grid_edges(rows: NDArray[np.int32]) -> NDArray[np.int32]:
    """Pair the 8-connected pixels of a grid.

    Parameters
    ----------
    rows : (H, W) int32
        Row of each pixel in the feature arrays, -1 where it takes no part.

    Returns
    -------
    (E, 2) int32
        Pairs of rows.

    Examples
    --------
    >>> grid_edges(np.array([[0, 1], [-1, 2]], np.int32)).tolist()
    [[0, 1], [1, 2], [0, 2]]
    """
    pairs = []
    for one, other in (
        (rows[:, :-1], rows[:, 1:]),
        (rows[:-1], rows[1:]),
        (rows[:-1, :-1], rows[1:, 1:]),
        (rows[1:, :-1], rows[:-1, 1:]),
    ):
        both = (one >= 0) & (other >= 0)
        pairs.append(np.stack([one[both], other[both]], axis=1))
    return np.concatenate(pairs).astype(np.int32)


def cloud_edges(points: NDArray[np.float32], neighbours: int = NEIGHBOURS) -> NDArray[np.int32]:
    """Pair each point of a cloud with its nearest neighbours in space.

    Parameters
    ----------
    points : (M, 3) float
    neighbours : int

    Returns
    -------
    (E, 2) int32
        Pairs of rows, each once, the lower row first.

    Examples
    --------
    >>> cloud_edges(np.array([[0, 0, 0], [1, 0, 0], [3, 0, 0]], np.float32), 1).tolist()
    [[0, 1], [1, 2]]
    """
    from scipy.spatial import cKDTree

    n = len(points)
    reach = min(neighbours, n - 1)
    if reach < 1:
        return np.zeros((0, 2), np.int32)
    _, nearest = cKDTree(points).query(points, k=reach + 1)
    pairs = np.stack([np.repeat(np.arange(n), reach + 1), nearest.reshape(-1)], axis=1)
    pairs = np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1)
    return np.unique(pairs, axis=0).astype(np.int32)


def edge_lengths(vectors: NDArray[np.float32], edges: NDArray[np.int32]) -> NDArray[np.float32]:
    """Return the Euclidean distance of the vectors at the two ends of each edge."""
    squared = np.zeros(len(edges), np.float32)
    for channel in vectors.T:
        squared += (channel[edges[:, 0]] - channel[edges[:, 1]]) ** 2
    return np.sqrt(squared)


def merge_graph(
    n: int, edges: NDArray[np.int32], lengths: NDArray[np.float32], k: float, min_size: int
) -> NDArray[np.int32]:
    """Merge nodes along edges, the shortest first.

    Two components merge if the edge between them is no longer than
    ``min(Int(C1) + k / |C1|, Int(C2) + k / |C2|)``, where Int(C) is the longest edge that C was
    merged along. Afterwards components with fewer than `min_size` nodes merge along the
    shortest edges, whatever their length. Edges of equal length come in the given order.

    Parameters
    ----------
    n : int
        Number of nodes.
    edges : (E, 2) int32
    lengths : (E,) float32
        Not negative.
    k : float
        In the unit of the lengths: larger for larger components.
    min_size : int

    Returns
    -------
    (n,) int32
        Components 0..C-1 in the order of their first nodes.

    Examples
    --------
    >>> edges = np.array([[0, 1], [1, 2], [2, 3]], np.int32)
    >>> lengths = np.array([1, 9, 1], np.float32)
    >>> merge_graph(4, edges, lengths, k=2.0, min_size=1).tolist()
    [0, 0, 1, 1]
    """
    order = np.argsort(lengths, kind="stable")
    parent, size = np.arange(n, dtype=np.int32), np.ones(n, np.int64)
    limit = np.full(n, k, np.float64)
    _merge(edges[order], lengths[order], k, min_size, parent, size, limit)
    is_root = parent == np.arange(n)  # the lowest node, so that the others come after it
    return (np.cumsum(is_root, dtype=np.int32) - np.int32(1))[parent]


@compiled
def _merge(
    edges: NDArray[np.int32],
    lengths: NDArray[np.float32],
    k: float,
    min_size: int,
    parent: NDArray[np.int32],
    size: NDArray[np.int64],
    limit: NDArray[np.float64],
) -> None:
    """Leave the root of each node in `parent`; `limit` is Int(C) + k / |C| for each root."""
    for e in range(len(edges)):
        one, other = find_root(parent, edges[e, 0]), find_root(parent, edges[e, 1])
        if one != other and lengths[e] <= min(limit[one], limit[other]):
            total = size[one] + size[other]
            root = join_roots(parent, one, other)
            size[root] = total
            limit[root] = lengths[e] + k / total
    for e in range(len(edges)):
        one, other = find_root(parent, edges[e, 0]), find_root(parent, edges[e, 1])
        if one != other and min(size[one], size[other]) < min_size:
            total = size[one] + size[other]
            size[join_roots(parent, one, other)] = total
    for node in range(len(parent)):
        parent[node] = find_root(parent, node)
