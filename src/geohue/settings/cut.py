"""Settings of Sec. III: landmarks, affinity, labels and K."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from geohue.settings.checks import check_choice, check_positive, check_whole

LandmarkChoice = Literal["random", "kmeans", "farthest"]
LANDMARK_CHOICES: tuple[LandmarkChoice, ...] = get_args(LandmarkChoice)

Labelling = Literal["kmeans", "rotation", "qr"]
LABELLINGS: tuple[Labelling, ...] = get_args(Labelling)

Selector = Literal["eigengap", "elongated", "rotation"]
SELECTORS: tuple[Selector, ...] = get_args(Selector)

Fit = Literal["all", "draft"]
FITS: tuple[Fit, ...] = get_args(Fit)

SCALE = 0.4
"""Width of the Gaussian in units of the spread of the data, see `geohue.ncut.affinity`."""

K_MAX = 10
"""Most segments that a selector proposes."""


@dataclass(frozen=True, slots=True)
class CutSettings:
    """How a normalized cut is made.

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
    fit : {"all", "draft"}
        Points whose affinities make the eigenvectors, which are then read off everywhere. The
        draft is enough for the sums over all points, and saves two of the three passes.

    Raises
    ------
    GeohueError
        For a value that no cut can be made with.

    Examples
    --------
    >>> CutSettings(landmarks=-1)
    Traceback (most recent call last):
    geohue.errors.GeohueError: landmarks is -1: expected a whole number of at least 1
    """

    landmarks: int = 100
    landmark_choice: LandmarkChoice = "random"
    scale: float = SCALE
    labelling: Labelling = "kmeans"
    restarts: int = 4
    center_points: int = 5_000
    selector: Selector = "eigengap"
    k_max: int = K_MAX
    fit: Fit = "all"

    def __post_init__(self) -> None:
        check_whole("landmarks", self.landmarks, 1)
        check_choice("landmark_choice", self.landmark_choice, LANDMARK_CHOICES)
        check_positive("scale", self.scale)
        check_choice("labelling", self.labelling, LABELLINGS)
        check_whole("restarts", self.restarts, 0)
        check_whole("center_points", self.center_points, 1)
        check_choice("selector", self.selector, SELECTORS)
        check_whole("k_max", self.k_max, 2)
        check_choice("fit", self.fit, FITS)
