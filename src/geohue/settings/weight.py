"""Settings of Sec. IV: what chooses the weight, and among which weights."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from geohue.settings.checks import check_choice, check_steps, check_weights

WeightRule = Literal["quality", "agreement", "consensus", "merge"]
WEIGHT_RULES: tuple[WeightRule, ...] = get_args(WeightRule)

COARSE: tuple[float, ...] = tuple(2.0**e for e in range(-4, 5))
"""The octaves from colour almost alone to geometry almost alone."""

REFINEMENTS = (0.5, 0.25)
"""Steps around the best weight so far, in octaves."""

HALF_OCTAVES: tuple[float, ...] = tuple(2.0 ** (e / 2) for e in range(-8, 9))
"""The weights that `geohue.weight.agreement` compares."""


@dataclass(frozen=True, slots=True)
class WeightSettings:
    """How the weight is chosen where it is not given.

    Attributes
    ----------
    rule : {"quality", "agreement", "consensus", "merge"}
        What chooses the weight: the highest Q (Sec. IV), or `weight_by_agreement`. Or nothing: with
        "consensus" what `find_consensus` says is taken where K is not given and the scene is a
        grid, with "merge" regions are merged on all the evidence (`geohue.merge`); elsewhere
        "agreement" serves, for the compared systems the highest Q as in the paper.
    weights, refinements : tuple of float
        Weights tried first, and the steps around the best (`search_weight`).
    compared : tuple of float
        Weights whose segmentations are compared by `weight_by_agreement`, in increasing order.

    Raises
    ------
    GeohueError
        For an unknown rule, or weights that are not positive and in increasing order.
    """

    rule: WeightRule = "quality"
    weights: tuple[float, ...] = COARSE
    refinements: tuple[float, ...] = REFINEMENTS
    compared: tuple[float, ...] = HALF_OCTAVES

    def __post_init__(self) -> None:
        check_choice("weight rule", self.rule, WEIGHT_RULES)
        check_weights("weights", self.weights)
        check_steps("refinements", self.refinements)
        check_weights("compared", self.compared)
