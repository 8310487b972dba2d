"""Connected pieces of a label image, and the removal of the small ones (end of Sec. III)."""

from __future__ import annotations

from math import isqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.compute.labels import check_labels
from geohue.errors import GeohueError
from geohue.regions.votes import most_votes


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


def _pieces(
    labels: NDArray[np.int32], corners: bool = False
) -> tuple[NDArray[np.int32], NDArray[np.int64], NDArray[np.int32]]:
    """Return the piece of each pixel, and the size and the label of each piece."""
    from geohue.regions.pieces import number_pieces  # compiled code takes a moment to load

    pieces = np.empty(labels.shape, np.int32)
    parent, label_of = np.empty(labels.size, np.int32), np.empty(labels.size, np.int32)
    sizes = np.empty(labels.size, np.int64)
    n = number_pieces(np.ascontiguousarray(labels), pieces, parent, sizes, label_of, corners)
    return pieces, sizes[:n], label_of[:n]


def _take_from_adjacent(
    pieces: NDArray[np.int32], label_of: NDArray[np.int32], kept: NDArray[np.bool_]
) -> NDArray[np.int32]:
    """Return the labels with those of the small pieces next to kept ones, which become kept."""
    from geohue.regions.pieces import count_borders, list_borders, take_from_adjacent

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
    from scipy.ndimage import distance_transform_edt

    source = (pieces >= 0) & kept[pieces]
    y, x = np.nonzero((pieces >= 0) & ~source)
    piece = pieces[y, x]
    nearest = distance_transform_edt(~source, return_distances=False, return_indices=True)
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
    label_of[islands] = most_votes(voter, choice, np.ones_like(voter))


def _offsets_at(squared: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the whole dy and dx with dy^2 + dx^2 = squared."""
    reach = isqrt(squared)
    dy = np.arange(-reach, reach + 1, dtype=np.int64)
    dx = np.rint(np.sqrt(squared - dy * dy)).astype(np.int64)
    exact = dy * dy + dx * dx == squared
    dy, dx = dy[exact], dx[exact]
    other_side = dx > 0
    return np.concatenate((dy, dy[other_side])), np.concatenate((dx, -dx[other_side]))
