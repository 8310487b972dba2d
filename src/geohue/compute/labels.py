"""Arrays of labels: checked at the door, and renumbered."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

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
    if checked.size == 0:
        return checked.copy(), np.zeros(0, np.int32)
    old, place = compact(checked.reshape(-1))
    sizes, first = np.bincount(place), np.empty(old.size, np.int64)
    first[place[::-1]] = np.arange(place.size - 1, -1, -1)  # of several writes the last one counts
    real = np.flatnonzero(old >= 0)
    order = real[np.lexsort((first[real], -sizes[real]))]
    new_of = np.full(old.size, -1, dtype=np.int32)
    new_of[order] = np.arange(order.size, dtype=np.int32)
    return new_of[place].reshape(checked.shape), old[order].astype(np.int32)


def compact(values: NDArray[np.integer[Any]]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Distinct values, ascending, and the index of each value among them.

    The same as ``np.unique(values, return_inverse=True)``, without its sort where the range is
    small.
    """
    low, high = int(values.min()), int(values.max())
    if high - low > 4 * values.size + 1024:
        distinct, index = np.unique(values, return_inverse=True)
        return distinct.astype(np.int64), index.astype(np.int64)
    offset = values.astype(np.int64) - low
    present = np.bincount(offset) > 0
    position = np.cumsum(present) - 1
    return np.flatnonzero(present).astype(np.int64) + low, position[offset]
