"""Nested segmentations of a scene from one run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from geohue.compute.labels import relabel
from geohue.errors import GeohueError
from geohue.merge.tree import MergeTree

Detail = float | Literal["auto", "coarse", "fine"]

DETAILS = {"coarse": -1.5, "auto": 0.0, "fine": 1.5}
"""The named degrees of detail."""

Labels = NDArray[np.int32]


def threshold_of(detail: Detail) -> float:
    """Return the score below which regions are merged, for a degree of detail.

    Parameters
    ----------
    detail : float, "coarse", "auto" or "fine"
        0 ("auto") keeps apart what more likely than not are two things. The unit is that of the
        score, a logarithm of odds: at 1 regions are merged only where one thing is e times as
        likely as two, at -1 they stay apart only where two things are e times as likely as one.

    Returns
    -------
    float

    Raises
    ------
    GeohueError
        For another word, or a number that is not finite.

    Examples
    --------
    >>> threshold_of("auto"), threshold_of(2)
    (0.0, -2.0)
    """
    if isinstance(detail, str):
        if detail not in DETAILS:
            raise GeohueError(f"detail is {detail!r}: expected {', '.join(DETAILS)} or a number")
        return -DETAILS[detail] + 0.0
    if isinstance(detail, bool) or not isinstance(detail, int | float | np.number):
        raise GeohueError(f"detail is {detail!r}: expected {', '.join(DETAILS)} or a number")
    if not np.isfinite(detail):
        raise GeohueError(f"detail is {detail}: expected a finite number")
    return -float(detail) + 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Levels:
    """Segmentations of one scene, each nested in the next, from fine regions to one segment.

    Attributes
    ----------
    regions : (H, W) or (N,) int32
        The finest region of each pixel or point, -1 = none.
    tree : MergeTree
        In which order they merge.
    """

    regions: Labels
    tree: MergeTree

    def __len__(self) -> int:
        """Return the number of levels."""
        return len(self.tree.merges) + 1

    def at(self, detail: Detail = "auto") -> Labels:
        """Return the segmentation at a degree of detail (`threshold_of`).

        Returns
        -------
        int32, shape of the scene
            Segments 0..K-1, the largest first; -1 = none.
        """
        return self._labels(self.tree.at(threshold_of(detail)))

    def with_segments(self, k: int) -> Labels:
        """Return the segmentation with `k` segments, or as near to it as the levels come."""
        return self._labels(self.tree.with_segments(k))

    def _labels(self, segment_of: Labels) -> Labels:
        return relabel(np.append(segment_of, np.int32(-1))[self.regions])[0]

    def count(self, detail: Detail = "auto") -> int:
        """Return how many segments the segmentation at a degree of detail has.

        Examples
        --------
        >>> tree = MergeTree(3, np.array([[0, 2], [1, 0]]), np.array([-1.0, 2.0]))
        >>> levels = Levels(np.array([[0, 1, 2]], np.int32), tree)
        >>> levels.count("auto"), levels.count(3), levels.count(-3)
        (2, 3, 1)
        """
        return self.counts([detail])[0]

    def counts(self, details: Sequence[Detail]) -> list[int]:
        """Return how many segments there are at each of some degrees of detail."""
        there = np.zeros(self.tree.n_regions + 1, bool)
        there[self.regions] = True  # the last one, too, where there is no region
        found = (self.tree.at(threshold_of(detail)) for detail in details)
        return [len(np.unique(segments[there[:-1]])) for segments in found]

    def border_strength(self) -> NDArray[np.float64]:
        """Return, for regions i and j, the score at which they become one segment, (R, R).

        An ultrametric: of three regions the two largest strengths are equal. Infinite for regions
        that never merge, minus infinity on the diagonal.
        """
        n = self.tree.n_regions
        strength = np.full((n, n), np.inf)
        np.fill_diagonal(strength, -np.inf)
        members = [[region] for region in range(n)]
        for (kept, gone), height in zip(self.tree.merges, self.tree.heights, strict=True):
            one, other = members[kept], members[gone]
            strength[np.ix_(one, other)] = strength[np.ix_(other, one)] = height
            one += other
        return strength
