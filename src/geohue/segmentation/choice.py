"""Sec. III and IV: the number of segments and the weight, chosen on the draft."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.consensus import Consensus, find_consensus, make_voters
from geohue.errors import GeohueError
from geohue.ncut.cutter import Cutter
from geohue.prepared import PreparedScene
from geohue.regions.images import merge_small_regions
from geohue.scene import Scene
from geohue.segmentation.arguments import Count, Weight
from geohue.segmentation.clusterers import Clusterer
from geohue.settings import WeightSettings
from geohue.weight.agreement import weight_by_agreement
from geohue.weight.quality import QualityMetric
from geohue.weight.search import Curve, search_weight


@dataclass(frozen=True, slots=True, eq=False)
class Chooser:
    """Chooses the number of segments and the weight, where they are not given.

    Attributes
    ----------
    prepared : PreparedScene
        The scene and its draft.
    splitter : Clusterer
        The method whose weight is chosen.
    cutter : Cutter
        The paper's cut, which chooses the number of segments for every method.
    """

    prepared: PreparedScene
    splitter: Clusterer
    cutter: Cutter

    def k(self, k: Count, weight: Weight) -> int:
        """Return the number of segments (Sec. III)."""
        if k != "auto":
            return k
        fixed = self._fixed(weight)
        return self.cutter.choose_k(1.0 if fixed is None or math.isnan(fixed) else fixed)

    def consensus(self, k: Count, weight: Weight, found: int) -> Consensus | None:
        """Return what the voters agree on, None where K or the weight is given or chosen instead.

        `found` is the answer of `k`: 1 says that there is nothing to split.
        """
        if self._rule(weight) != "consensus" or k != "auto" or found == 1:
            return None
        if self.splitter is not self.cutter or not self.prepared.features.is_fused:
            return None
        # Not measured on clouds: there on request only.
        if weight == "auto" and not self.prepared.scene.is_grid:
            return None
        return find_consensus(make_voters(self.prepared, self.cutter), self.prepared)

    def weight(self, weight: Weight, k: int) -> tuple[float, Curve]:
        """Return the weight for `k` segments, and the curve of Q if it was searched (eq. 6-17)."""
        fixed = self._fixed(weight)
        if fixed is not None:
            return fixed, []
        if k == 1 and self.splitter.uses_k:
            return 1.0, []
        draft, team, settings = self.prepared.draft, self.prepared.workers, self._settings
        metric = QualityMetric(draft)

        def split(weight: float) -> NDArray[np.int32]:
            return self.tidied(self.splitter.draft_labels(weight, k), draft)

        def score(labels: NDArray[np.int32]) -> float | None:
            quality = metric(labels)
            return quality.total if quality else None

        if self._rule(weight) == "quality":
            steps = settings.weights, settings.refinements
            return search_weight(lambda weight: score(split(weight)), team, *steps)
        compared = settings.compared  # also for "consensus" where K is given
        best, maps = weight_by_agreement(split, draft, team, compared)
        values = zip(compared, team.map(score, maps), strict=True)
        return best, [(weight, value) for weight, value in values if value is not None]

    def tidied(self, labels: NDArray[np.int32], scene: Scene) -> NDArray[np.int32]:
        """Let small regions of a grid join their neighbours, unless the method has its own rule."""
        if self.splitter.prunes or not scene.is_grid:
            return labels
        return merge_small_regions(
            labels, max(1, round(self.prepared.settings.min_region * scene.size))
        )

    @property
    def _settings(self) -> WeightSettings:
        return self.prepared.settings.weight

    def _rule(self, weight: Weight) -> object:
        return self._settings.rule if weight == "auto" else weight

    def _fixed(self, weight: Weight) -> float | None:
        """Return the weight if it need not be searched, NaN if the method has none."""
        features = self.prepared.features
        if not features.is_fused:
            return math.inf if features.uses("geometry") else 0.0
        if not self.splitter.uses_weight:
            return math.nan
        return None if isinstance(weight, str) else float(weight)


def check_count(n_points: int, k: Count) -> None:
    """Raise `GeohueError` if there are fewer points than segments."""
    if k != "auto" and n_points < k:
        raise GeohueError(f"{n_points} usable point(s) cannot form {k} segments: lower k")


def shortfalls(found: int, wanted: int, components: bool) -> list[str]:
    """Return what the user should know where there are fewer segments than wanted."""
    if wanted == 1:
        return ["one segment: nothing to split, and no weight to choose; k=2 or more splits it"]
    if found < wanted and not components:
        return [f"{found} segment(s) instead of {wanted}: the others were empty or too small"]
    return []
