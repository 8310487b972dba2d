"""What splitting a scene gives, before gaps are filled and segments are renumbered."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.consensus import Consensus
from geohue.merge.levels import Levels
from geohue.merge.shares import BorderShares
from geohue.merge.tree import MergeTree
from geohue.weight.search import Curve

Labels = NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """The segments of a scene, by a cut or by merging.

    Attributes
    ----------
    regions : (H, W) or (N,) int32
        The finest pieces that are known, -1 = none: the segments themselves for a cut.
    weight : float
        The paper's lambda, as in `Segmentation`.
    curve : list of (float, float)
        Q of each weight that was tried.
    wanted : int or None
        How many segments were asked for or chosen, None where nobody did.
    segment_of : (R,) int32 or None
        The segment of each piece; None where the pieces are the segments.
    tree : MergeTree or None
        How the pieces merge.
    consensus : Consensus or None
        What the voters agreed on, where they did.
    shares : BorderShares or None
        The votes along the borders of the pieces, where cuts voted.
    """

    regions: Labels
    weight: float
    curve: Curve
    wanted: int | None
    segment_of: Labels | None = None
    tree: MergeTree | None = None
    consensus: Consensus | None = None
    shares: BorderShares | None = None

    @property
    def labels(self) -> Labels:
        """The segment of each point, -1 = none."""
        if self.segment_of is None:
            return self.regions
        return np.append(self.segment_of, np.int32(-1))[self.regions]

    @property
    def levels(self) -> Levels | None:
        """Finer and coarser segmentations, where regions were merged."""
        return None if self.tree is None else Levels(self.regions, self.tree)

    def border_votes(
        self, labels: Labels, draft: NDArray[np.int64]
    ) -> list[tuple[int, int, float]]:
        """Return the share of votes along each border of the final labels, empty if nobody voted.

        `draft` has the flat positions of the draft's points.
        """
        return [] if self.consensus is None else self.consensus.along_borders(labels.ravel()[draft])
