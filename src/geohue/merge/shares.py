"""How many of the cuts that voted draw each border between two of the finest regions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.consensus.votes import count_votes

Labels = NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class BorderShares:
    """The share of the votes along each border.

    Attributes
    ----------
    pairs : (P, 2) int64
        The two regions of each border, the smaller number first, in increasing order.
    share : (P,) float64
        Mean, over the pairs of neighbouring points of the draft along it, of the share of cuts
        that part the two: 0 (none) to 1 (all).
    """

    pairs: NDArray[np.int64]
    share: NDArray[np.float64]

    def among(self, kept: NDArray[np.bool_]) -> BorderShares:
        """Return the borders of some of the regions, numbered anew.

        Examples
        --------
        >>> shares = BorderShares(np.array([[0, 1], [1, 2]]), np.array([0.5, 1.0]))
        >>> shares.among(np.array([False, True, True])).pairs.tolist()
        [[0, 1]]
        """
        name = np.cumsum(kept) - 1
        here = kept[self.pairs].all(axis=1)
        return BorderShares(name[self.pairs[here]], self.share[here])


def border_shares(
    regions: Labels, maps: Sequence[Labels], one: NDArray[np.int64], other: NDArray[np.int64]
) -> BorderShares:
    """Return the share of the votes along each border of a draft.

    Parameters
    ----------
    regions : int32, shape of the draft
        Its finest regions, none missing.
    maps : sequence of int32 arrays
        The cuts that voted, of the same points.
    one, other : (E,) int64
        Pairs of neighbouring points, as flat positions.

    Returns
    -------
    BorderShares

    Examples
    --------
    >>> maps = [np.int32([0, 0, 1]), np.int32([0, 1, 1])]
    >>> found = border_shares(np.int32([0, 0, 1]), maps, np.array([0, 1]), np.array([1, 2]))
    >>> found.pairs.tolist(), found.share.tolist()
    ([[0, 1]], [0.5])
    """
    names = regions.reshape(-1)
    apart = names[one] != names[other]
    one, other = one[apart], other[apart]
    ends = np.sort(np.stack([names[one], names[other]], axis=1).astype(np.int64), axis=1)
    pairs, which = np.unique(ends, axis=0, return_inverse=True)
    votes = count_votes(maps, one, other)
    which = which.reshape(-1)
    total = np.bincount(which, votes, len(pairs))
    return BorderShares(pairs, total / np.maximum(np.bincount(which, minlength=len(pairs)), 1))
