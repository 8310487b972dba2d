"""Connected pieces of a label image, and the removal of the small ones (end of Sec. III)."""

from __future__ import annotations

from math import isqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from geohue.errors import GeohueError


def check_labels(labels: NDArray[np.integer[Any]], ndim: int | None = None) -> NDArray[np.int32]:
    """Return labels as int32, or say what is wrong with them.

    Parameters
    ----------
    labels : integer array
        Labels, -1 = none.
    ndim : int, optional
        Number of dimensions wanted; None means any.

    Returns
    -------
    int32 array of the same shape
        The same array where it is int32 already.

    Raises
    ------
    GeohueError
        If the labels are not whole numbers from -1 to 2^31 - 1, or not of ``ndim`` dimensions.

    Examples
    --------
    >>> import numpy as np
    >>> check_labels(np.array([0.5]))
    Traceback (most recent call last):
    geohue.errors.GeohueError: labels: float64 values; expected whole numbers, -1 = no label
    """
    if not np.issubdtype(labels.dtype, np.integer):
        raise GeohueError(f"labels: {labels.dtype} values; expected whole numbers, -1 = no label")
    if ndim is not None and labels.ndim != ndim:
        raise GeohueError(f"labels: shape {labels.shape}; expected {ndim} dimensions")
    if labels.size:
        lowest, highest = int(labels.min()), int(labels.max())
        if lowest < -1 or highest > np.iinfo(np.int32).max:
            raise GeohueError(
                f"labels: values from {lowest} to {highest}; expected -1 (no label) to 2147483647"
            )
    return labels.astype(np.int32, copy=False)


def connected_components(
    labels: NDArray[np.integer[Any]], connectivity: int = 4
) -> NDArray[np.int32]:
    """Give every connected piece of equal label its own number.

    Parameters
    ----------
    labels : (H, W) integer array
        Labels, -1 = none.
    connectivity : {4, 8}
        Whether pixels that touch at a corner only are connected (8) or not (4).

    Returns
    -------
    (H, W) int32 array
        Pieces 0..C-1 in the order of their first pixels, row by row; -1 where there is no label.

    Raises
    ------
    GeohueError
        If the labels are not a (H, W) array of whole numbers from -1, or connectivity is neither
        4 nor 8.

    Examples
    --------
    >>> import numpy as np
    >>> connected_components(np.array([[5, 5, 2, 5], [-1, 2, 2, 5]])).tolist()
    [[0, 0, 1, 2], [-1, 1, 1, 2]]
    """
    checked = check_labels(labels, ndim=2)
    if connectivity not in (4, 8):
        raise GeohueError(f"connectivity: {connectivity!r}; expected 4 or 8")
    return _pieces(checked, corners=connectivity == 8)[0]


def merge_small_regions(labels: NDArray[np.integer[Any]], min_size: int) -> NDArray[np.int32]:
    """Give the pixels of small regions the label that is most common next to them (Sec. III).

    A piece is a 4-connected set of pixels of one label; it is small with fewer than ``min_size``
    pixels and kept otherwise. A small piece takes the mode of the labels of the points closest to
    it: every pair of a pixel of the piece and a kept pixel at the least distance between the two
    sets votes once for the label of the kept pixel, and equal votes go to the lowest label. So a
    piece next to kept ones takes the label that it shares the longest border with.

    Pieces take their labels in rounds, all pieces of a round at once and from the labels at its
    start, so that no order among them matters: first the small pieces 4-adjacent to kept pixels,
    which then count as kept, then those adjacent to these, and so on. In a last round come the
    islands, pieces that unlabelled pixels cut off from every kept one: they take the mode over the
    pairs at the least Euclidean distance.

    Parameters
    ----------
    labels : (H, W) integer array
        Labels, -1 = none.
    min_size : int
        Pixels that a piece needs to be kept; 0 and 1 keep everything.

    Returns
    -------
    (H, W) int32 array
        The labels without small pieces, a new array. Pixels with -1 stay so. The labels are
        those of the input where no piece is large enough.

    Raises
    ------
    GeohueError
        If the labels are not a (H, W) array of whole numbers from -1, or ``min_size`` is not a
        whole number from 0.

    Notes
    -----
    Where at least one piece is kept, a piece smaller than ``min_size`` is left only if
    unlabelled pixels cut it off from all kept ones (an island changes its label, not its extent).
    A second run changes nothing. Labels that only small pieces had are gone afterwards: see
    `relabel`.

    References
    ----------
    Dal Mutto, Zanuttigh, Cortelazzo, "Fusion of geometry and color information for scene
    segmentation", IEEE J. Sel. Topics Signal Process. 6(5), 2012, Sec. III.

    Examples
    --------
    >>> import numpy as np
    >>> merge_small_regions(np.array([[0, 0, 0, 3], [0, 7, 3, 3]]), min_size=2).tolist()
    [[0, 0, 0, 3], [0, 0, 3, 3]]
    """
    checked = check_labels(labels, ndim=2)
    if isinstance(min_size, bool) or not isinstance(min_size, (int, np.integer)) or min_size < 0:
        raise GeohueError(f"min_size: {min_size!r}; expected a whole number of pixels, 0 or more")
    pieces, sizes, label_of = _pieces(checked)
    kept = sizes >= min_size
    if kept.all() or not kept.any():
        return checked.copy()
    label_of = _take_from_adjacent(pieces, label_of, kept)
    if not kept.all():
        _take_from_nearest(pieces, label_of, kept)
    return np.append(label_of, np.int32(-1)).take(pieces)  # the piece -1 is the last one


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
        label_of[places] = _modes(voter, label_of[asked[heard]], np.ones(len(voter), np.int64))
        kept[places] = True
    merged = label_of[piece]
    left = ~kept[piece]
    if left.any():
        from scipy.spatial import cKDTree

        sure = ~left & (labels >= 0)
        _, nearest = cKDTree(points[sure]).query(points[left])
        merged[left] = merged[sure][nearest]
    return merged


def relabel(labels: NDArray[np.integer[Any]]) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Renumber the labels 0..K-1, the largest segment first.

    Parameters
    ----------
    labels : (H, W) or (N,) integer array
        Labels, -1 = none.

    Returns
    -------
    labels : int32 array of the same shape
        Labels 0..K-1 by decreasing size, equal sizes by their first pixel; -1 stays -1.
    mapping : (K,) int32 array
        The old label of each new one: ``mapping[new] == old``.

    Raises
    ------
    GeohueError
        If the labels are not whole numbers from -1.

    Examples
    --------
    >>> import numpy as np
    >>> new, mapping = relabel(np.array([[7, 3, 3], [-1, 5, 3]]))
    >>> new.tolist(), mapping.tolist()
    ([[1, 0, 0], [-1, 2, 0]], [3, 7, 5])
    """
    checked = check_labels(labels)
    old, first, compact, sizes = np.unique(
        checked, return_index=True, return_inverse=True, return_counts=True
    )
    real = np.flatnonzero(old >= 0)
    order = real[np.lexsort((first[real], -sizes[real]))]
    new_of = np.full(old.size, -1, dtype=np.int32)
    new_of[order] = np.arange(order.size, dtype=np.int32)
    return new_of[compact.reshape(checked.shape)], old[order]


def _pieces(
    labels: NDArray[np.int32], corners: bool = False
) -> tuple[NDArray[np.int32], NDArray[np.int64], NDArray[np.int32]]:
    """Return the piece of each pixel, and the size and the label of each piece."""
    from geohue.pieces import number_pieces  # compiled code takes a moment to load

    pieces = np.empty(labels.shape, np.int32)
    parent, label_of = np.empty(labels.size, np.int32), np.empty(labels.size, np.int32)
    sizes = np.empty(labels.size, np.int64)
    n = number_pieces(np.ascontiguousarray(labels), pieces, parent, sizes, label_of, corners)
    return pieces, sizes[:n], label_of[:n]


def _take_from_adjacent(
    pieces: NDArray[np.int32], label_of: NDArray[np.int32], kept: NDArray[np.bool_]
) -> NDArray[np.int32]:
    """Return the labels with those of the small pieces next to kept ones, which become kept."""
    from geohue.pieces import count_borders, list_borders, take_from_adjacent

    starts = np.zeros(kept.size + 1, np.int64)
    touching = np.empty(count_borders(pieces, kept, starts), np.int32)
    list_borders(pieces, kept, starts.copy(), touching)
    names, rank = np.unique(label_of, return_inverse=True)
    queue, votes = np.empty(kept.size, np.int32), np.zeros(names.size, np.int64)
    take_from_adjacent(starts, touching, rank, kept, queue, votes)
    return names[rank]


def _take_from_nearest(
    pieces: NDArray[np.int32], label_of: NDArray[np.int32], kept: NDArray[np.bool_]
) -> None:
    """Label the islands from the kept pixels at the least distance, in place."""
    source = (pieces >= 0) & kept[pieces]
    y, x = np.nonzero((pieces >= 0) & ~source)
    piece = pieces[y, x]
    nearest = ndimage.distance_transform_edt(~source, return_distances=False, return_indices=True)
    nearest_y, nearest_x = nearest[:, y, x].astype(np.int64)
    squared = (nearest_y - y) ** 2 + (nearest_x - x) ** 2
    least = np.full(kept.size, np.iinfo(np.int64).max)
    np.minimum.at(least, piece, squared)

    # The transform names one nearest pixel; all at that distance vote.
    voters, choices = [], []
    closest = squared == least[piece]
    y, x, piece, squared = y[closest], x[closest], piece[closest], squared[closest]
    for distance in np.unique(squared):
        at = squared == distance
        dy, dx = _offsets_at(int(distance))
        to_y, to_x = y[at, None] + dy, x[at, None] + dx
        inside = (to_y >= 0) & (to_y < source.shape[0]) & (to_x >= 0) & (to_x < source.shape[1])
        voter = np.broadcast_to(piece[at, None], inside.shape)[inside]
        to_y, to_x = to_y[inside], to_x[inside]
        hit = source[to_y, to_x]
        voters.append(voter[hit])
        choices.append(label_of[pieces[to_y[hit], to_x[hit]]])
    islands, voter = np.unique(np.concatenate(voters), return_inverse=True)
    choice = np.concatenate(choices)
    label_of[islands] = _modes(voter, choice, np.ones_like(voter))


def _offsets_at(squared: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the whole dy and dx with dy^2 + dx^2 = squared."""
    reach = isqrt(squared)
    dy = np.arange(-reach, reach + 1, dtype=np.int64)
    dx = np.rint(np.sqrt(squared - dy * dy)).astype(np.int64)
    exact = dy * dy + dx * dx == squared
    dy, dx = dy[exact], dx[exact]
    other_side = dx > 0
    return np.concatenate((dy, dy[other_side])), np.concatenate((dx, -dx[other_side]))


def _modes(
    voter: NDArray[np.integer[Any]],
    label: NDArray[np.int32],
    votes: NDArray[np.integer[Any]],
) -> NDArray[np.int32]:
    """Return for each voter 0..n-1 the label with most votes, the lowest of equals."""
    span = int(label.max()) + 1
    key, group = np.unique(voter.astype(np.int64) * span + label, return_inverse=True)
    total = np.bincount(group, weights=votes)
    voters, choices = np.divmod(key, span)
    order = np.lexsort((-total, voters))  # stable: among equals the lower label stays first
    first = np.flatnonzero(np.diff(voters[order], prepend=-1))
    winners: NDArray[np.int32] = choices[order][first].astype(np.int32)
    return winners
