"""A part of the points that stands for all of them, and weights of one spread."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.features import Features
from geohue.scene import Scene


def mixed_vectors(features: Features, weight: float) -> NDArray[np.float32]:
    """Return p^f of eq. 5, with the spread of its parts kept the same for every lambda.

    With one cue alone lambda has nothing to balance: the vectors are that cue, whatever lambda.
    """
    if features.cues == "color":
        return features.color
    if features.cues == "geometry":
        return features.geometry
    return features.mixed(weight)


def thinned(scene: Scene, features: Features, most: int, seed: int) -> Features:
    """Keep at most about `most` points: every n-th row and column of a grid, or random ones.

    All points are kept, in an order that does not depend on a cloud's file, if they are no more,
    or if the regular choice would miss most of those that have the cues.
    """
    if len(features) <= most:
        return features.at(scene.thinning(scene.size, np.random.default_rng(seed)))
    few = features.at(scene.thinning(most, np.random.default_rng(seed)))
    return few if 10 * len(few) >= min(most, len(features)) else features
