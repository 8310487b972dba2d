"""The same colour for the same part in every cell, so that a plate can be compared by eye."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

COLORS = 45
"""Colours that `geohue.results.picture.palette` tells apart before they repeat."""


def match_labels(labels: NDArray[np.int32], reference: NDArray[np.int32]) -> NDArray[np.int32]:
    """Number segments like those of a reference that they overlap.

    Each segment of the reference lends its number to at most one segment, such that as many points
    as possible have the number they have in the reference. The other segments, from the largest to
    the smallest, take the numbers that follow; past `COLORS` these repeat, without those of the
    reference.

    Parameters
    ----------
    labels, reference : integer, of one shape
        0 and up; -1 for none.

    Returns
    -------
    int32, of the same shape
        For `geohue.results.picture.paint`; no longer a number a segment if there are very many.

    Examples
    --------
    >>> first = np.array([0, 0, 0, 1, 1, 2], np.int32)
    >>> match_labels(np.array([1, 1, 1, 2, 0, 0], np.int32), first).tolist()
    [0, 0, 0, 1, 2, 2]
    >>> match_labels(np.array([0, 0, 0, 0, 1, -1], np.int32), first).tolist()
    [0, 0, 0, 0, 1, -1]
    """
    from scipy.optimize import linear_sum_assignment

    n, n_known = (int(array.max(initial=-1)) + 1 for array in (labels, reference))
    if n == 0 or n_known == 0:
        return labels
    both = (labels >= 0) & (reference >= 0)
    overlap = np.zeros((n, n_known), np.int64)
    np.add.at(overlap, (labels[both], reference[both]), 1)
    rows, columns = linear_sum_assignment(overlap, maximize=True)
    meet = overlap[rows, columns] > 0
    number = np.full(n + 1, -1, np.int64)  # the last is that of label -1
    number[rows[meet]] = columns[meet]
    rest = np.flatnonzero(number[:n] < 0)
    sizes = np.bincount(labels[labels >= 0], minlength=n)
    rest = rest[np.argsort(-sizes[rest], kind="stable")]
    free = max(1, COLORS - n_known)
    number[rest] = n_known + np.arange(len(rest)) % free
    return np.asarray(number[labels], np.int32)
