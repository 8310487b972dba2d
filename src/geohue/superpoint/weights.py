"""The constants of superpoints."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

FINE = 6.0
"""Fine regions that a superpoint has at least, on average."""

MOST = 6.0
"""Points that a fine region has at most."""

CRUMB, SHARE = 10.0, 0.25
"""A piece that lies apart counts to what is nearest if it has fewer points than this, or than this
share of a superpoint's on average."""


def step_weights() -> Floats:
    """Weights of colour, of the normal and of the gap between two neighbours (`pair_steps`)."""
    return np.array([0.0344, 0.6853, 0.3865])


def merging_weights(compactness: float = 1.0) -> Floats:
    """Weights of a union of two regions (`geohue.superpoint.ward.cost`)."""
    return np.array([0.0013, 2.8143, 0.0054, 1.612 * compactness, 0.0402, 1.0])
