"""Connected pieces of a cloud, and small ones given to what lies around them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.regions.votes import most_votes


def connected_groups(
    labels: NDArray[np.int32], one: NDArray[np.int64], other: NDArray[np.int64]
) -> NDArray[np.int32]:
    """Number the pieces of equal label of a cloud, as `connected_components` does those of a grid.

    Parameters
    ----------
    labels : (N,) int32
        Labels; those of -1 are pieces as well.
    one, other : (E,) int64
        Pairs of neighbours (`adjacent_points`).

    Returns
    -------
    (N,) int32

    Examples
    --------
    >>> import numpy as np
    >>> connected_groups(np.int32([4, 4, 4]), np.array([0]), np.array([1])).tolist()
    [0, 0, 1]
    """
    alike = labels[one] == labels[other]
    return join_pairs(one[alike], other[alike], len(labels))


def join_pairs(one: NDArray[np.int64], other: NDArray[np.int64], n: int) -> NDArray[np.int32]:
    """Number the sets that pairs make of 0..n-1.

    Examples
    --------
    >>> import numpy as np
    >>> join_pairs(np.array([0, 3]), np.array([2, 3]), 4).tolist()
    [0, 1, 0, 2]
    """
    from scipy.sparse import coo_array, csgraph  # not what every cut should wait for

    graph = coo_array((np.ones(len(one), bool), (one, other)), shape=(n, n))
    return np.asarray(csgraph.connected_components(graph, directed=False)[1], np.int32)


def merge_small_groups(
    labels: NDArray[np.int32],
    one: NDArray[np.int64],
    other: NDArray[np.int64],
    points: NDArray[np.float32],
    min_size: int,
) -> NDArray[np.int32]:
    """Give the points of small pieces of a cloud the label that is most common next to them.

    This is `merge_small_regions` for points: a piece is a set of points of one label that pairs of
    neighbours connect, and every pair of a small and a kept piece votes once, in the same rounds.
    Points of pieces that no kept one reaches take the label of the nearest kept point.

    Parameters
    ----------
    labels : (N,) int32
        Labels, -1 = none.
    one, other : (E,) int64
        Pairs of neighbours (`adjacent_points`), all with a label.
    points : (N, 3) float32
        Positions, finite where there is a label.
    min_size : int
        Points that a piece needs to be kept.

    Returns
    -------
    (N,) int32
        The labels themselves if no piece, or every one, is large enough.

    Examples
    --------
    >>> import numpy as np
    >>> x = np.float32([[0, 0, 0], [1, 0, 0], [2, 0, 0], [8, 0, 0], [9, 0, 0]])
    >>> pairs = np.array([0, 1, 3]), np.array([1, 2, 4])
    >>> merge_small_groups(np.int32([0, 0, 1, 2, 2]), *pairs, x, min_size=2).tolist()
    [0, 0, 0, 2, 2]
    """
    piece = connected_groups(labels, one, other)
    sizes = np.bincount(piece)
    label_of = np.empty(len(sizes), np.int32)
    label_of[piece] = labels
    kept = sizes >= min_size
    if kept[label_of >= 0].all() or not kept[label_of >= 0].any():
        return labels
    kept |= label_of < 0  # nothing to give, and nothing to take
    apart = piece[one] != piece[other]
    a, b = piece[one[apart]], piece[other[apart]]
    asking, asked = np.concatenate([a, b]), np.concatenate([b, a])
    while True:
        heard = ~kept[asking] & kept[asked]
        if not heard.any():
            break
        places, voter = np.unique(asking[heard], return_inverse=True)
        label_of[places] = most_votes(voter, label_of[asked[heard]], np.ones(len(voter), np.int64))
        kept[places] = True
    merged = label_of[piece]
    left = ~kept[piece]
    if left.any():
        from scipy.spatial import cKDTree

        sure = ~left & (labels >= 0)
        _, nearest = cKDTree(points[sure]).query(points[left])
        merged[left] = merged[sure][nearest]
    return merged
