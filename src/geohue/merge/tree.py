"""The tree of merges: nested segmentations, from the finest regions to one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError

Labels = NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class MergeTree:
    """In which order regions were merged, and how clearly they belonged together.

    Attributes
    ----------
    n_regions : int
        The finest regions, 0..R-1.
    merges : (M, 2) int64
        The two regions of each merge; the first one's name stays. M < R - 1 where some have no
        neighbours.
    scores : (M,) float64
        Score of each merge: below 0 where the two belong together.
    """

    n_regions: int
    merges: NDArray[np.int64]
    scores: NDArray[np.float64]

    @property
    def heights(self) -> NDArray[np.float64]:
        """The threshold from which on each merge takes place: the highest score so far."""
        return np.maximum.accumulate(self.scores) if len(self.scores) else self.scores

    def at(self, threshold: float = 0.0) -> Labels:
        """Return the segment of each finest region where merges below a threshold took place.

        Parameters
        ----------
        threshold : float
            0 keeps apart what does not belong together; lower is finer, higher coarser.

        Returns
        -------
        (R,) int32
            Segments 0..K-1, in the order of their first regions.
        """
        return self.after(int(np.searchsorted(self.heights, threshold, "left")))

    def with_segments(self, k: int) -> Labels:
        """Return the segment of each finest region in the level with `k` segments.

        Parameters
        ----------
        k : int
            At least 1. The finest or the coarsest level is taken where none has `k`.

        Raises
        ------
        GeohueError
            If `k` is below 1.
        """
        if k < 1:
            raise GeohueError(f"k is {k}: expected at least 1")
        return self.after(min(max(self.n_regions - k, 0), len(self.merges)))

    def among(self, kept: NDArray[np.bool_]) -> MergeTree:
        """Return the tree of some of the finest regions, numbered anew.

        Each level is that of the whole tree with the other regions left out.

        Parameters
        ----------
        kept : (R,) bool
            Which regions.

        Returns
        -------
        MergeTree
            Its scores are the `heights` of the whole tree.

        Examples
        --------
        >>> tree = MergeTree(3, np.array([[0, 2], [1, 0]]), np.array([-1.0, 2.0]))
        >>> tree.among(np.array([False, True, True])).merges.tolist()
        [[0, 1]]
        """
        name = np.where(kept, np.cumsum(kept) - 1, -1)
        merges, scores = [], []
        for (one, other), height in zip(self.merges.tolist(), self.heights, strict=True):
            if name[one] >= 0 and name[other] >= 0:
                merges.append((name[one], name[other]))
                scores.append(height)
            name[one] = name[one] if name[one] >= 0 else name[other]
        pairs = np.array(merges, np.int64).reshape(-1, 2)
        return MergeTree(int(kept.sum()), pairs, np.array(scores))

    def after(self, n_merges: int) -> Labels:
        """Return the segment of each finest region after the first merges.

        Examples
        --------
        >>> tree = MergeTree(3, np.array([[0, 2], [1, 0]]), np.array([-1.0, 2.0]))
        >>> tree.after(1).tolist(), tree.at(3.0).tolist()
        ([0, 1, 0], [0, 0, 0])
        """
        root = np.arange(self.n_regions)
        for kept, gone in self.merges[:n_merges][::-1].tolist():
            root[gone] = root[kept]
        # Later merges were followed first, so each name already leads to the last one.
        names, first = np.unique(root, return_index=True)
        rank = np.empty(self.n_regions, np.int32)
        rank[names[np.argsort(first)]] = np.arange(len(names), dtype=np.int32)
        return rank[root]
