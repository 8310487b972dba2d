"""The settings behind ``preset=``: the paper's method, a faster and a finer one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from geohue.errors import GeohueError
from geohue.features import Cues
from geohue.ncut.affinity import SCALE
from geohue.ncut.labels import Labelling
from geohue.ncut.landmarks import Choice
from geohue.ncut.selectors import K_MAX, Selector
from geohue.ncut.settings import Fit
from geohue.weight.search import (
    BALANCES,
    COARSE,
    HALF_OCTAVES,
    REFINEMENTS,
)

Fill = Literal["appendix", "watershed"]

WeightRule = Literal["quality", "agreement", "consensus", "merge"]
WEIGHT_RULES: tuple[WeightRule, ...] = get_args(WeightRule)

ONE_CUE = range(2, 47)
"""Numbers of segments of the cuts that vote where colour or geometry takes part alone."""


@dataclass(frozen=True, slots=True)
class Preset:
    """Every setting of the method; a user's own is as good as a named one.

    Attributes
    ----------
    landmarks : int
        Points that stand for all others in the Nystrom approximation.
    landmark_choice : {"random", "kmeans", "farthest"}
        How they are chosen (`choose_landmarks`).
    scale : float
        Width of the affinity in units of the spread of the data (`affinity`).
    labelling : {"kmeans", "rotation", "qr"}
        From eigenvectors to labels (`find_centers`).
    restarts : int
        Random starts of k-means beside its own.
    center_points : int
        Points of the draft that k-means and the selectors of K look at.
    selector : {"eigengap", "elongated", "rotation"}
        What chooses K (`choose_k`).
    k_max : int
        Most segments that it may choose, or that a cut of the consensus has.
    draft_points : int
        Points on which K and the weight are chosen.
    fit : {"all", "draft"}
        Points whose affinities make the eigenvectors, which are then read off everywhere. The
        draft is enough for the sums over all points, and saves two of the three passes.
    weight_rule : {"quality", "agreement", "consensus", "merge"}
        What chooses the weight: the highest Q (Sec. IV), or `weight_by_agreement`. Or nothing: what
        `find_consensus` says is taken, or regions are merged on all the evidence
        (`geohue.merge`).
    weights, refinements : tuple of float
        Weights tried first, and the steps around the best (`search_weight`).
    compared : tuple of float
        Weights whose segmentations are compared by `weight_by_agreement`, in increasing order.
    voters : tuple of float
        Weights whose cuts vote, 0 to infinity.
    counts : tuple of int
        Numbers of segments of the cuts that vote in the merging.
    min_region : float
        Smaller regions of a grid, as a share of its pixels, join what surrounds them; those of a
        cloud in the consensus.
    fill : {"appendix", "watershed"}
        What gives pixels without depth a label: `fill_labels`, or `flood_labels`.
    """

    landmarks: int = 100
    landmark_choice: Choice = "random"
    scale: float = SCALE
    labelling: Labelling = "kmeans"
    restarts: int = 4
    center_points: int = 5_000
    selector: Selector = "eigengap"
    k_max: int = K_MAX
    draft_points: int = 20_000
    fit: Fit = "all"
    weight_rule: WeightRule = "quality"
    weights: tuple[float, ...] = COARSE
    refinements: tuple[float, ...] = REFINEMENTS
    compared: tuple[float, ...] = HALF_OCTAVES
    voters: tuple[float, ...] = BALANCES
    counts: tuple[int, ...] = (2, 3, 4, 5, 6, 7, 8, 10, 12)
    min_region: float = 0.002
    fill: Fill = "appendix"

    def voted(self, cues: Cues) -> Sequence[int]:
        """Numbers of segments of the cuts that vote: more of them where one cue votes alone."""
        return self.counts if cues == "fusion" else ONE_CUE

    def most_voted(self, cues: Cues) -> int:
        """Most segments of a cut that votes."""
        return max(self.voted(cues))


PRESETS: dict[str, Preset] = {
    "paper": Preset(),
    "fast": Preset(
        landmarks=64,
        draft_points=6_000,
        fit="draft",
        restarts=2,
        center_points=2_000,
        weight_rule="merge",
        counts=(4, 8, 12),
        compared=COARSE,
        fill="watershed",
    ),
    "best": Preset(landmarks=128, weight_rule="merge", fill="watershed"),
}


def preset_named(preset: str | Preset) -> Preset:
    """Return a preset by its name, or as it is.

    Raises
    ------
    GeohueError
        For an unknown name.

    Examples
    --------
    >>> preset_named("paper").landmark_choice
    'random'
    """
    if isinstance(preset, Preset):
        return preset
    if preset not in PRESETS:
        raise GeohueError(f"preset {preset!r}: choose one of {', '.join(PRESETS)}")
    return PRESETS[preset]
