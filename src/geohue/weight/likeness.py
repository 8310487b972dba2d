"""How alike segmentations of the same points are, without a reference."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Labels = NDArray[np.int32]


def likeness(maps: Sequence[Labels]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Tell how like the others each of a row of segmentations is.

    Parameters
    ----------
    maps : sequence of int32 arrays
        Of the same points, -1 = none; those of neighbouring weights side by side.

    Returns
    -------
    consensus, stability : (len(maps),) float64
        Minus the mean variation of information, in bits, to all others and to the one or two
        beside it.

    Examples
    --------
    >>> one, other = np.int32([0, 0, 1, 1]), np.int32([0, 1, 2, 3])  # one bit apart
    >>> consensus, stability = likeness([one, one, other])
    >>> consensus.tolist(), stability.tolist()
    ([-0.5, -0.5, -1.0], [-0.0, -0.5, -1.0])
    """
    distance = distances(maps)
    n = len(maps)
    beside = np.abs(np.subtract.outer(np.arange(n), np.arange(n))) == 1
    near = (distance * beside).sum(axis=1) / np.maximum(beside.sum(axis=1), 1)
    return -distance.sum(axis=1) / max(n - 1, 1), -near


def distances(maps: Sequence[Labels]) -> NDArray[np.float64]:
    """Variation of information in bits between each two segmentations, over their common points.

    0 where there is no common point.
    """
    compared = _Compared(maps)
    distance = np.zeros((len(maps), len(maps)))
    for i in range(1, len(maps)):
        distance[i, :i] = distance[:i, i] = compared.row(i, range(i))
    return distance


def distances_from(labels: Labels, maps: Sequence[Labels]) -> NDArray[np.float64]:
    """Variation of information in bits between one segmentation and each of others (`distances`).

    Examples
    --------
    >>> one, other = np.int32([0, 0, 1, 1]), np.int32([0, 1, 2, 3])
    >>> distances_from(one, [one, other]).tolist()
    [0.0, 1.0]
    """
    return _Compared([labels, *maps]).row(0, range(1, len(maps) + 1))


class _Compared:
    """Segmentations as runs of points that none of them parts, each weighed by its length."""

    def __init__(self, maps: Sequence[Labels]) -> None:
        flat = np.stack([np.asarray(labels, np.int32).reshape(-1) for labels in maps])
        parted = (flat[:, 1:] != flat[:, :-1]).any(axis=0)
        first = np.flatnonzero(np.concatenate([[True], parted]))
        self._weight = np.diff(first, append=flat.shape[1])
        self._runs = np.ascontiguousarray(flat[:, first])
        self._room = np.zeros((2, int(self._runs.max()) + 1), np.int64)
        n = np.arange(flat.shape[1] + 1, dtype=np.float64)
        self._log = n * np.log2(np.maximum(n, 1))

    def row(self, i: int, others: Sequence[int]) -> NDArray[np.float64]:
        """The distances of one segmentation to some others."""
        from geohue.weight.passes import shared_information  # compiled code takes a moment to load

        one = self._runs[i]
        order = np.argsort(one, kind="stable")
        order = order[np.count_nonzero(one < 0) :]
        fixed, room = (self._weight, self._log), self._room
        return np.array(
            [shared_information(order, one, self._runs[j], *fixed, *room) for j in others],
            np.float64,
        )
