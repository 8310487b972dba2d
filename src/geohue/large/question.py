"""What is asked of a cloud in pieces."""

from __future__ import annotations

from dataclasses import dataclass

from geohue.merge.levels import Detail
from geohue.segmentation.choice import Count, Weight
from geohue.segmentation.driver import merges_regions
from geohue.settings import PAPER_METHOD, Preset


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
        return merges_regions(self.settings, self.weight, PAPER_METHOD)
