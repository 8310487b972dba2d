"""What `segment_file` returns."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geohue._version import __version__
from geohue.segmentation.words import weight_in_words
from geohue.settings import PAPER_METHOD
from geohue.weight.search import Curve


@dataclass(frozen=True, slots=True)
class FileSegmentation:
    """The segments of a cloud on disk, and how they were found.

    Attributes
    ----------
    labels_file : Path
        NPY, (N,) int32: the segment of each point, -1 for those without coordinates. Open it with
        ``numpy.load(labels_file, mmap_mode="r")``.
    k : int
        Number of segments.
    sizes : tuple of int
        Points of each segment. Segments are numbered by their size in the sample.
    weight : float
        The paper's lambda that was used.
    quality : float or None
        Q of eq. 17 on the sample.
    weight_curve : list of (float, float)
        Each weight tried and its Q on the draft.
    preset, cues, seed
        As given; the preset is "custom" for settings of one's own.
    n_points, n_sample : int
        Points in the file, and in the sample on which k, weight and cut were found.
    timings : dict of str to float
        Seconds for each stage and in all, in the last run if there were several.
    warnings : tuple of str
        What the user should know of the input or the result.
    """

    labels_file: Path
    k: int
    sizes: tuple[int, ...]
    weight: float
    quality: float | None
    weight_curve: Curve
    preset: str
    cues: str
    seed: int
    n_points: int
    n_sample: int
    timings: dict[str, float]
    warnings: tuple[str, ...] = ()

    def summary(self) -> dict[str, Any]:
        """Return all of it, ready for JSON (a weight not finite becomes None)."""
        return {
            "version": __version__,
            "method": PAPER_METHOD,
            "preset": self.preset,
            "cues": self.cues,
            "seed": self.seed,
            "k": self.k,
            "weight": self.weight if math.isfinite(self.weight) else None,
            "weight_in_words": weight_in_words(self.weight),
            "quality": self.quality,
            "weight_curve": [[float(w), float(q)] for w, q in self.weight_curve],
            "n_points": self.n_points,
            "n_labelled": sum(self.sizes),
            "sizes": list(self.sizes),
            "n_sample": self.n_sample,
            "timings_s": {stage: round(s, 4) for stage, s in self.timings.items()},
            "warnings": list(self.warnings),
        }
