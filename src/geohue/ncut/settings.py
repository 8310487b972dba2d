"""What a cut asks of its settings."""

from __future__ import annotations

from typing import Literal, Protocol

from geohue.ncut.labels import Labelling
from geohue.ncut.landmarks import Choice
from geohue.ncut.selectors import Selector

Fit = Literal["all", "draft"]


class CutSettings(Protocol):
    """The settings of `Cutter`, described at `geohue.Preset`."""

    @property
    def landmarks(self) -> int:
        """Points that stand for all others."""

    @property
    def landmark_choice(self) -> Choice:
        """How they are chosen."""

    @property
    def scale(self) -> float:
        """Width of the affinity."""

    @property
    def labelling(self) -> Labelling:
        """From eigenvectors to labels."""

    @property
    def restarts(self) -> int:
        """Random starts of k-means."""

    @property
    def center_points(self) -> int:
        """Points that k-means looks at."""

    @property
    def selector(self) -> Selector:
        """What chooses K."""

    @property
    def k_max(self) -> int:
        """Most segments."""

    @property
    def fit(self) -> Fit:
        """Points whose affinities make the eigenvectors."""
