"""Borders that enough segmentations draw: evidence accumulation over neighbours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.regions.groups import join_pairs

Labels = NDArray[np.int32]


def count_votes(
    maps: Sequence[Labels], one: NDArray[np.int64], other: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Return the share of segmentations that put each two points into different segments.

    Parameters
    ----------
    maps : sequence of int32 arrays
        Segmentations of the same points.
    one, other : (E,) int64
        Flat positions of the points.

    Returns
    -------
    (E,) float64
        0 to 1.

    Examples
    --------
    >>> maps = [np.int32([0, 0, 1]), np.int32([0, 1, 1])]
    >>> count_votes(maps, np.array([0, 0]), np.array([1, 2])).tolist()
    [0.5, 1.0]
    """
    votes = np.zeros(len(one), np.int32)
    for labels in maps:
        flat = labels.reshape(-1)
        votes += flat[one] != flat[other]
    return votes / max(len(maps), 1)


def join_by_votes(
    one: NDArray[np.int64],
    other: NDArray[np.int64],
    share: NDArray[np.float64],
    n: int,
    least: float,
) -> Labels:
    r"""Join neighbours until every border that is left has enough votes.

    The votes of a border are the mean over the pairs of points along it. Of all borders the one
    with the fewest votes goes first (average linkage among neighbours), as long as it has fewer
    than `least`. Since the mean of two borders is never below the lower one, regions that are each
    other's nearest can be joined side by side and give, but for ties, the same hierarchy.

    Parameters
    ----------
    one, other : (E,) int64
        Pairs of neighbours among the points 0..n-1.
    share : (E,) float64
        `count_votes` of each pair.
    n : int
        Number of points.
    least : float
        Share of the votes with which a border stays.

    Returns
    -------
    (n,) int32
        Regions 0..R-1, in the order of their first points.

    References
    ----------
    A. Fred, A. K. Jain, "Combining multiple clusterings using evidence accumulation", PAMI 27(6),
    2005. A. Strehl, J. Ghosh, "Cluster ensembles", JMLR 3, 2002.

    Examples
    --------
    >>> one, other = np.array([0, 1, 2]), np.array([1, 2, 3])
    >>> join_by_votes(one, other, np.array([0.1, 0.9, 0.2]), 4, least=0.25).tolist()
    [0, 0, 1, 1]
    """
    # What no vote parts is one from the start: nine tenths of the pairs.
    whole = share <= 0
    labels = join_pairs(one[whole], other[whole], n)
    borders = _Borders.between(labels, one, other, share)
    while True:
        weakest = borders.mutual(least)
        if not weakest.any():
            return _in_order(labels)
        n = int(labels.max(initial=-1)) + 1
        new = join_pairs(borders.low[weakest], borders.high[weakest], n)
        labels = new[labels]
        borders = borders.among(new)


@dataclass(frozen=True, slots=True, eq=False)
class _Borders:
    """The borders between regions, each once: the two regions, its length and its votes."""

    low: NDArray[np.int64]
    high: NDArray[np.int64]
    length: NDArray[np.float64]
    votes: NDArray[np.float64]

    @classmethod
    def between(
        cls,
        labels: Labels,
        one: NDArray[np.int64],
        other: NDArray[np.int64],
        share: NDArray[np.float64],
    ) -> _Borders:
        """The borders of regions of points."""
        return cls(one, other, np.ones(len(one)), share).among(labels)

    def among(self, labels: Labels) -> _Borders:
        """The borders that are left when each region becomes part of a larger one."""
        a, b = labels[self.low].astype(np.int64), labels[self.high].astype(np.int64)
        apart = np.flatnonzero(a != b)
        low, high = np.minimum(a, b)[apart], np.maximum(a, b)[apart]
        n = int(labels.max(initial=-1)) + 1
        pairs, place = np.unique(low * n + high, return_inverse=True)
        length, votes = (
            np.bincount(place, values[apart], len(pairs)).astype(np.float64)
            for values in (self.length, self.votes)
        )
        return _Borders(pairs // max(n, 1), pairs % max(n, 1), length, votes)

    def mutual(self, least: float) -> NDArray[np.bool_]:
        """Which borders are the weakest of both their regions, and weaker than `least`."""
        share = self.votes / self.length
        order = np.argsort(share, kind="stable")[::-1]
        n = int(self.high.max(initial=-1)) + 1
        rank = np.empty(len(share), np.int64)
        rank[order[::-1]] = np.arange(len(share))
        first = np.full(n, len(share))
        for side in (self.low, self.high):
            best = np.full(n, len(share))
            best[side[order]] = rank[order]  # the last one written is the weakest
            first = np.minimum(first, best)
        mutual = (first[self.low] == rank) & (first[self.high] == rank)
        return np.asarray(mutual & (share < least))


def _in_order(labels: Labels) -> Labels:
    """Renumber by first appearance."""
    _, first, inverse = np.unique(labels, return_index=True, return_inverse=True)
    rank = np.empty(len(first), np.int32)
    rank[np.argsort(first)] = np.arange(len(first), dtype=np.int32)
    return rank[inverse.reshape(-1)]
