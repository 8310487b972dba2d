"""Which points of a scene lie side by side."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.regions.groups import join_pairs
from geohue.scene import Scene

CLOUD_NEIGHBOURS = 5
"""Nearest points that a point of a cloud counts as beside it."""

FAR_NEIGHBOURS = 100
"""Nearest points among which a piece of a cloud looks for another piece."""


def adjacent_points(scene: Scene) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pair the points of a scene that lie side by side.

    Parameters
    ----------
    scene : Scene
        Points without geometry take no part.

    Returns
    -------
    one, other : (E,) int64
        Flat positions, no pair of a point with itself: each two pixels that share a side; each
        point of a cloud with its `CLOUD_NEIGHBOURS` nearest. Points in the same place count as
        one: the first of them is paired with others, the rest with it.

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
    index = np.flatnonzero(scene.valid)
    first, place = first_of_each(scene.points[index])
    pairs = first[_near_pairs(scene.points[index[first]], np.arange(len(first)), CLOUD_NEIGHBOURS)]
    copies = np.flatnonzero(first[place] != np.arange(len(index)))
    one = np.concatenate([pairs[:, 0], first[place[copies]]])
    other = np.concatenate([pairs[:, 1], copies])
    return index[one], index[other]


def link_pieces(
    scene: Scene, one: NDArray[np.int64], other: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pair points of a cloud that pairs of neighbours leave unconnected (scan lines, gaps).

    Parameters
    ----------
    scene : Scene
        A cloud.
    one, other : (E,) int64
        `adjacent_points`.

    Returns
    -------
    one, other : (F,) int64
        Pairs that connect all points with a position, none if they are connected.
    """
    index = np.flatnonzero(scene.valid)
    first, place = first_of_each(scene.points[index])
    places = np.zeros(scene.size, np.int64)
    places[index] = place
    pairs = np.stack([places[one], places[other]], axis=1)
    links = np.zeros((0, 2), np.int64)
    here = scene.points[index[first]]
    while True:
        all_pairs = np.concatenate([pairs, links])
        piece = join_pairs(all_pairs[:, 0], all_pairs[:, 1], len(first))
        if piece.max(initial=0) == 0:
            ends = index[first[links]]
            return ends[:, 0], ends[:, 1]
        links = np.concatenate([links, _links(here, piece)])


def first_of_each(points: NDArray[np.float32]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the first point in each place, and the place of each point.

    Examples
    --------
    >>> first, place = first_of_each(np.float32([[2, 0, 0], [1, 0, 0], [2, 0, 0]]))
    >>> first.tolist(), place.tolist()
    ([0, 1], [0, 1, 0])
    """
    _, first, place = np.unique(points, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty(len(first), np.int64)
    rank[order] = np.arange(len(first))
    return first[order].astype(np.int64), rank[place.reshape(-1)]


def _near_pairs(
    points: NDArray[np.float32], asking: NDArray[np.int64], k: int
) -> NDArray[np.int64]:
    """Pair some of the points, all in different places, with their k nearest others, (E, 2)."""
    from scipy.spatial import cKDTree

    k = min(k, len(points) - 1)
    if k < 1:
        return np.zeros((0, 2), np.int64)
    _, near = cKDTree(points).query(points[asking], k + 1)
    pairs = np.stack([np.repeat(asking, k + 1), np.asarray(near, np.int64).reshape(-1)], axis=1)
    return np.asarray(pairs[pairs[:, 0] != pairs[:, 1]])


def _links(points: NDArray[np.float32], piece: NDArray[np.int32]) -> NDArray[np.int64]:
    """Pair the points of each piece but the largest with the nearest one of another piece.

    Of a piece whose points all lie far from any other, the few nearest to the largest piece.
    """
    from scipy.spatial import cKDTree

    sizes = np.bincount(piece)
    largest = int(sizes.argmax())
    asking = np.flatnonzero(piece != largest)
    near = _near_pairs(points, asking, FAR_NEIGHBOURS)
    away = near[piece[near[:, 0]] != piece[near[:, 1]]]
    _, nearest = np.unique(away[:, 0], return_index=True)  # pairs come by distance
    links = away[nearest]
    lonely = asking[~np.isin(piece[asking], piece[links[:, 0]])]
    if len(lonely) == 0:
        return np.asarray(links)
    ground = np.flatnonzero(piece == largest)
    distance, there = cKDTree(points[ground]).query(points[lonely])
    order = np.lexsort((np.asarray(distance), piece[lonely]))
    lonely, there = lonely[order], np.asarray(there)[order]
    begins = np.concatenate([[True], piece[lonely[1:]] != piece[lonely[:-1]]])
    place = np.arange(len(lonely))
    few = place - np.maximum.accumulate(np.where(begins, place, 0)) < CLOUD_NEIGHBOURS
    return np.concatenate([links, np.stack([lonely[few], ground[there[few]]], axis=1)])


def adjacent_pixels(shape: tuple[int, ...]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pair the pixels of a grid that share a side; flat positions."""
    index = np.arange(shape[0] * shape[1]).reshape(shape)
    one = np.concatenate([index[:, :-1].ravel(), index[:-1].ravel()])
    other = np.concatenate([index[:, 1:].ravel(), index[1:].ravel()])
    return one, other


def nearest_known(known: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the flat position of the known pixel nearest to each, (H, W); one must be known.

    Of several the one in the first column, and there the upper one. For drafts: gaps are crossed
    a step at a time. `scipy.ndimage` does the same, but takes a fifth of a second to be imported.

    Examples
    --------
    >>> nearest_known(np.array([[True, False, False, True]])).tolist()
    [[0, 0, 3, 3]]
    """
    width = known.shape[1]
    row = _nearest_in_column(known)
    y, x = np.nonzero(~known)
    nearest, least = x.copy(), (row[y, x] - y) ** 2
    open_ = np.arange(len(y))
    for step in range(1, width):
        open_ = open_[step * step <= least[open_]]
        if len(open_) == 0:
            break
        for side in (-step, step):
            inside = open_[(x[open_] + side >= 0) & (x[open_] + side < width)]
            there = x[inside] + side
            squared = (row[y[inside], there] - y[inside]) ** 2 + step * step
            better = squared <= least[inside] if side < 0 else squared < least[inside]
            inside, there, squared = inside[better], there[better], squared[better]
            nearest[inside], least[inside] = there, squared
    index = np.arange(known.size).reshape(known.shape)
    index[y, x] = row[y, nearest] * width + nearest
    return index


def _nearest_in_column(known: NDArray[np.bool_]) -> NDArray[np.int64]:
    """The row of the known pixel nearest in the same column, above if equal; else far outside."""
    y = np.arange(len(known))[:, None]
    far = sum(known.shape)
    above = np.maximum.accumulate(np.where(known, y, -far), axis=0)
    below = np.minimum.accumulate(np.where(known, y, len(known) + far)[::-1], axis=0)[::-1]
    return np.where(y - above <= below - y, above, below)
