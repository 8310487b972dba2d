"""The signed score that decides which regions belong together, and where its constants come from.

score = w . cues + bias, with the cues of `geohue.merge.cues`. Below 0 the two regions belong
together. The constants are a logistic regression of the question whether merging a pair lowers the
variation of information, by the method of ``benchmarks/merge_fit.py`` on 120 frames of NYU Depth V2
and 22 of mOSD (the fit part of ``benchmarks/splits.json``). Those of `GEOMETRY` were fitted on
other frames of these two sets. They transfer between data sets (docs/merging.md), and a user has
nothing to fit.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from geohue.merge.cues import NAMES

Floats = NDArray[np.float64]

Cues = Literal["fusion", "color", "geometry"]
"""Which of the two take part."""

FUSION = {
    "offset": 0.274,
    "color_step": 0.729,
    "depth_step": 0.234,
    "texture": 1.711,
    "convexity": 1.445,
    "one_plane": 0.620,
    "whole_votes": 2.137,
    "length": -0.467,
    "gap": 0.331,
    "contrast": 0.401,
    "straightness": 0.235,
    "perimeter": 0.241,
    "smaller": 0.278,
    "larger": 0.233,
    "region_convexity": 0.704,
    "bias": -3.423,
}
"""For colour and geometry together."""

GEOMETRY = {
    "offset": 0.530,
    "depth_step": 0.310,
    "convexity": 1.740,
    "one_plane": 0.910,
    "whole_votes": 4.340,
    "length": -0.390,
    "gap": 0.530,
    "bias": -4.660,
}
"""For geometry alone: what the other cues would say of a constant colour is no information."""

COLOR = {
    "color_step": 1.221,
    "texture": 2.310,
    "whole_votes": 2.007,
    "length": -0.489,
    "contrast": 0.293,
    "straightness": -0.423,
    "perimeter": -0.089,
    "smaller": 0.336,
    "larger": 0.369,
    "bias": -2.793,
}
"""For colour alone."""

COLOR_SPREAD = 15.0
"""Lab units between regions at which colour and no colour count the same."""


def weights_of(table: dict[str, float]) -> Floats:
    """Return constants in the order of the cues, the bias last; 0 where there is none."""
    return np.array([table.get(name, 0.0) for name in (*NAMES, "bias")])


def constants(share: float, cues: Cues) -> Floats:
    """Return the constants for a scene in which colour says something to a degree of `share`.

    Parameters
    ----------
    share : float
        0 to 1 (`color_share`).
    cues : {"fusion", "color", "geometry"}
        The cues in use.

    Returns
    -------
    (16,) float64
        share times those with colour, and the rest those without.
    """
    if cues == "color":
        return weights_of(COLOR)
    return share * weights_of(FUSION) + (1 - share) * weights_of(GEOMETRY)


def color_share(lab: Floats, labels: NDArray[np.int32]) -> float:
    """Return how much colour says: c^2 / (c^2 + 15^2), c^2 the variance of Lab between regions.

    A scene of one colour would otherwise look like one thing: no step of colour is strong evidence
    of sameness only where there are other colours.

    Examples
    --------
    >>> color_share(np.zeros((4, 3)), np.int32([0, 0, 1, 1]))
    0.0
    """
    n = np.maximum(np.bincount(labels), 1)
    between = 0.0
    for channel in lab.T:
        mean = np.bincount(labels, channel) / n
        between += float((n * (mean - channel.mean()) ** 2).sum()) / len(lab)
    return between / (between + COLOR_SPREAD**2)
