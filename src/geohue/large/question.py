"""What is asked of a cloud in pieces."""

from __future__ import annotations

from dataclasses import dataclass

from geohue.merge.levels import Detail
from geohue.segmentation.arguments import Count, SegmentArguments, Weight
from geohue.settings import Preset


@dataclass(frozen=True, slots=True)
class Question:
    """What is asked of a cloud: everything that its labels depend on.

    Attributes
    ----------
    k, weight, cues, seed, detail
        As for `geohue.segment`.
    settings : Preset
        The settings.
    """

    k: Count
    weight: Weight
    settings: Preset
    cues: str
    seed: int
    detail: Detail = "auto"

    @property
    def merges(self) -> bool:
        """Whether regions are merged, in place of the paper's cut."""
        return self.arguments().merges

    def arguments(self) -> SegmentArguments:
        """Return these as `geohue.segment` checks them; raises `GeohueError` for a mistake."""
        return SegmentArguments(
            k=self.k,
            weight=self.weight,
            preset=self.settings,
            cues=self.cues,
            seed=self.seed,
            detail=self.detail,
        )
