"""All borders of a scene at once, each as dark as it is certain: an ultrametric contour map."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.merge.levels import Levels

_INK = (120, 0, 60)
_FADED = 0.75  # of the way to white, so that lines stand out from the scene
_LINE = 300  # pixels of the shorter side for each pixel of a line's width


def paint_borders(image: NDArray[np.uint8], levels: Levels) -> NDArray[np.uint8]:
    """Draw the borders of the finest regions, each by the merge at which it vanishes.

    The score of a merge is a logarithm of odds (`geohue.merge.levels.threshold_of`), so a border
    that vanishes at the score s is drawn with the strength ``1 / (1 + exp(-s))``: how likely it is
    that it parts two things. At 1/2 or more it is a border of detail "auto".

    Parameters
    ----------
    image : (H, W, 3) uint8
        The scene, shown faded below the borders.
    levels : Levels
        Of a scene of this shape.

    Returns
    -------
    (H, W, 3) uint8
        Arbelaez (2006) calls such a picture an ultrametric contour map: cut at any strength, the
        borders that are left are closed.
    """
    import cv2

    strength = border_map(levels)
    width = max(1, round(min(strength.shape) / _LINE))
    share = cv2.dilate(strength, np.ones((width, width), np.uint8))[..., None]
    # Few pixels lie on a border, and there are few greys.
    total = image[..., 0].astype(np.uint16) + image[..., 1] + image[..., 2]
    faded = 255 * _FADED + (1 - _FADED) * (np.arange(3 * 255 + 1, dtype=np.float32) / 3)
    out = np.repeat(faded.round().astype(np.uint8).take(total)[..., None], 3, axis=2)
    at = share[..., 0] > 0
    drawn = (1 - share[at]) * faded[total[at]][:, None] + share[at] * np.array(_INK, np.float32)
    out[at] = drawn.round().astype(np.uint8)
    return out


def border_map(levels: Levels) -> NDArray[np.float32]:
    """Return how strong a border each pixel lies on.

    Parameters
    ----------
    levels : Levels
        Of a grid.

    Returns
    -------
    (H, W) float32
        0 inside a region and beside pixels of none, up to 1; of several borders the strongest.
        The pixels on the left and above a border carry it.

    Examples
    --------
    >>> from geohue.merge.tree import MergeTree
    >>> tree = MergeTree(3, np.array([[0, 1], [0, 2]]), np.array([0.0, 20.0]))
    >>> border_map(Levels(np.array([[0, 0, 1, 1, 2]], np.int32), tree)).round(2).tolist()
    [[0.0, 0.5, 0.0, 1.0, 0.0]]
    """
    regions = levels.regions
    with np.errstate(over="ignore"):
        chance = (1 / (1 + np.exp(-levels.border_strength()))).astype(np.float32)
    strength = np.zeros(regions.shape, np.float32)
    for one, other, here in (
        (regions[:, :-1], regions[:, 1:], strength[:, :-1]),
        (regions[:-1], regions[1:], strength[:-1]),
    ):
        at = np.nonzero((one != other) & (one >= 0) & (other >= 0))
        here[at] = np.maximum(here[at], chance[one[at], other[at]])
    return strength
