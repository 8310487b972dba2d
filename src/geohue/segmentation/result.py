"""What `segment` returns."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue._version import __version__
from geohue.merge.levels import Detail, Levels
from geohue.merge.shares import BorderShares
from geohue.weight.search import Curve

SUMMARY_DETAILS = (-2.0, -1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0)
"""Degrees of detail whose numbers of segments the summary states."""

Progress = Callable[[str], None]
"""Called with the name of each stage as it begins."""


@dataclass(frozen=True, slots=True, eq=False)
class Segmentation:
    """The segments of a scene, and how they were found.

    Attributes
    ----------
    labels : (H, W) or (N,) int32
        Segment of each pixel or point, 0 (the largest) to k - 1; -1 where there is none.
    k : int
        Number of segments.
    weight : float
        The paper's lambda that was used; after a consensus or a merging, that of the voter whose
        maps are most like the result. 0 for colour alone, infinity for geometry alone, NaN where
        there is none.
    quality : float or None
        Q of eq. 17 for `labels`; None with fewer than two segments or without geometry.
    weight_curve : list of (float, float)
        Each weight tried and its Q on the draft, in increasing order; empty if none was searched.
    method, preset, cues, seed
        As given; the preset is "custom" for settings of one's own.
    timings : dict of str to float
        Seconds for each stage and in all (``total``).
    warnings : tuple of str
        What the user should know of the input or the result.
    levels : Levels or None
        Nested segmentations, finer and coarser than `labels`, where regions were merged; None for
        the paper's cut and the compared systems.
    detail : float, str or None
        How fine the level is that `labels` are; None without levels, and where `k` was given.
    shares : BorderShares or None
        The share of the votes along each border of `levels`' regions, where cuts voted.
    """

    labels: NDArray[np.int32]
    k: int
    weight: float
    quality: float | None
    weight_curve: Curve
    method: str
    preset: str
    cues: str
    seed: int
    timings: dict[str, float]
    warnings: tuple[str, ...] = ()
    levels: Levels | None = None
    detail: Detail | None = None
    shares: BorderShares | None = None

    @property
    def n_points(self) -> int:
        """Number of pixels or points of the scene."""
        return int(self.labels.size)

    @property
    def n_labelled(self) -> int:
        """Number of pixels or points with a label."""
        return int((self.labels >= 0).sum())

    def summary(self) -> dict[str, Any]:
        """Return everything but the labels, ready for JSON (a weight not finite becomes None)."""
        return {
            "version": __version__,
            "method": self.method,
            "preset": self.preset,
            "cues": self.cues,
            "seed": self.seed,
            "k": self.k,
            "weight": self.weight if math.isfinite(self.weight) else None,
            "quality": self.quality,
            "weight_curve": [[float(w), float(q)] for w, q in self.weight_curve],
            "detail": self.detail if self.detail is None else _plain(self.detail),
            "levels": None if self.levels is None else _levels(self.levels),
            "n_points": self.n_points,
            "n_labelled": self.n_labelled,
            "timings_s": {stage: round(s, 4) for stage, s in self.timings.items()},
            "warnings": list(self.warnings),
        }


def _plain(detail: Detail) -> float | str:
    return detail if isinstance(detail, str) else float(detail)


def _levels(levels: Levels) -> dict[str, Any]:
    """Return the number of levels, and of the segments at some degrees of detail."""
    segments = [[detail, levels.count(detail)] for detail in SUMMARY_DETAILS]
    return {"n": len(levels), "segments": segments}


@dataclass(slots=True)
class StageClock:
    """Times the stages of a run and tells of each as it begins."""

    progress: Progress | None = None
    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time what happens inside as the stage `name`."""
        if self.progress is not None:
            self.progress(name)
        start = perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + perf_counter() - start

    def timings(self) -> dict[str, float]:
        """Return the seconds of each stage and their sum."""
        return self.seconds | {"total": sum(self.seconds.values())}
