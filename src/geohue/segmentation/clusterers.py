"""One face for the paper's cut and for every system it is compared with."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from geohue.baselines import BASELINES, Baseline
from geohue.compute.parallel import Workers
from geohue.errors import GeohueError
from geohue.features import check_cues
from geohue.ncut.cutter import Cutter
from geohue.prepared import PreparedScene
from geohue.settings import PAPER_METHOD


def known_methods() -> tuple[str, ...]:
    """Return what ``method=`` takes: the paper's normalized cut, and the compared systems.

    Examples
    --------
    >>> known_methods()[:2]
    ('nncsc', 'kmeans')
    """
    return (PAPER_METHOD, *BASELINES)


class Clusterer(Protocol):
    """What splits a scene, for a weight and a number of segments."""

    @property
    def uses_weight(self) -> bool:
        """Whether the weight of geometry against colour counts."""

    @property
    def uses_k(self) -> bool:
        """Whether the number of segments is given to it."""

    @property
    def prunes(self) -> bool:
        """Whether it has a rule of its own for small regions."""

    def draft_labels(self, weight: float, k: int) -> NDArray[np.int32]:
        """Split the draft on which the weight is chosen."""

    def labels(self, weight: float, k: int) -> NDArray[np.int32]:
        """Split the scene."""


class BaselineClusterer:
    """A compared system, on the same vectors and the same draft as the paper's cut."""

    def __init__(self, baseline: Baseline, prepared: PreparedScene) -> None:
        self._baseline = baseline
        self._prepared = prepared

    @property
    def uses_weight(self) -> bool:
        """Whether the weight of geometry against colour counts."""
        return self._baseline.uses_weight

    @property
    def uses_k(self) -> bool:
        """Whether the number of segments is given to it."""
        return self._baseline.uses_k

    @property
    def prunes(self) -> bool:
        """Whether it has a rule of its own for small regions."""
        return self._baseline.prunes

    def draft_labels(self, weight: float, k: int) -> NDArray[np.int32]:
        """Split the draft on which the weight is chosen."""
        own, seed = self._prepared, self._prepared.seed
        return self._baseline.run(own.draft, own.draft_features, weight, k, seed, Workers(None))

    def labels(self, weight: float, k: int) -> NDArray[np.int32]:
        """Split the scene."""
        own, seed = self._prepared, self._prepared.seed
        return self._baseline.run(own.scene, own.features, weight, k, seed, own.workers)


def make_clusterer(method: str, cutter: Cutter, prepared: PreparedScene) -> Clusterer:
    """Return the clusterer of a method; the cutter itself for the paper's."""
    if method == PAPER_METHOD:
        return cutter
    return BaselineClusterer(BASELINES[method], prepared)


def check_method(method: str, cues: str, is_grid: bool) -> None:
    """Raise `GeohueError` unless the method exists and is defined for these cues and this scene."""
    if method != PAPER_METHOD and method not in BASELINES:
        raise GeohueError(f"method {method!r}: choose one of {', '.join(known_methods())}")
    check_cues(cues)
    if method == PAPER_METHOD:
        return
    baseline = BASELINES[method]
    if not baseline.works_on(cues):
        raise GeohueError(
            f"method {method!r} is not defined for cues {cues!r}: "
            f"choose {' or '.join(map(repr, baseline.cues))}"
        )
    if baseline.needs_grid and not is_grid:
        raise GeohueError(f"method {method!r} needs a grid of pixels: this scene is a cloud")
