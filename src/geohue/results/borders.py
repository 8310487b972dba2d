"""All borders of a scene at once, each as dark as it is certain."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from geohue.merge.levels import Levels
from geohue.scene import Scene
from geohue.segmentation.result import Segmentation

Ends = NDArray[np.int32]
"""The regions on one side of each border pixel."""

_INK = (120, 0, 60)
_FADED = 0.75  # of the way to white, so that lines stand out from the scene
_LINE = 300  # pixels of the shorter side for each pixel of a line's width


def border_picture(scene: Scene, seg: Segmentation) -> NDArray[np.uint8] | None:
    """Draw how certain each border of a segmentation is, if that is known.

    Parameters
    ----------
    scene : Scene
    seg : Segmentation
        Of the scene.

    Returns
    -------
    (H, W, 3) uint8 or None
        Where regions were merged, the borders of all levels (`paint_borders`); where cuts voted,
        those of the segments, as dark as the share of the cuts that draw them. None for a cloud,
        and where neither happened.
    """
    if not scene.is_grid:
        return None
    if seg.levels is not None:
        return paint_borders(scene.colors, seg.levels)
    if not seg.border_votes:
        return None
    return _paint(scene.colors, vote_map(seg.labels, seg.border_votes))


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
    return _paint(image, border_map(levels))


def _paint(image: NDArray[np.uint8], strength: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Draw borders by their strength, from 0 to 1, over the faded scene."""
    import cv2

    width = max(1, round(min(strength.shape) / _LINE))
    share = cv2.dilate(strength, np.ones((width, width), np.uint8))[..., None]
    faded = 255 * _FADED + (1 - _FADED) * image.astype(np.float32).mean(axis=2, keepdims=True)
    drawn = (1 - share) * faded + share * np.array(_INK, np.float32)
    return np.asarray(drawn.round(), np.uint8)


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
    with np.errstate(over="ignore"):
        chance = (1 / (1 + np.exp(-levels.border_strength()))).astype(np.float32)
    return _strongest(levels.regions, lambda one, other: chance[one, other])


def vote_map(
    labels: NDArray[np.int32], votes: Sequence[tuple[int, int, float]]
) -> NDArray[np.float32]:
    """Return the share of votes for the border that each pixel lies on.

    Parameters
    ----------
    labels : (H, W) int32
        Segments, -1 = none.
    votes : sequence of (int, int, float), not empty
        Two segments and the share, as `Segmentation.border_votes`. Two that touch in a few pixels
        only may be missing: such a border counts as the least certain one.

    Returns
    -------
    (H, W) float32
        As `border_map`.

    Examples
    --------
    >>> vote_map(np.array([[0, 0, 1, 2]], np.int32), [(0, 1, 0.75), (1, 2, 0.5)]).tolist()
    [[0.0, 0.75, 0.5, 0.0]]
    """
    known = np.array([vote[:2] for vote in votes], np.int64).reshape(-1, 2)
    value = np.array([vote[2] for vote in votes], np.float32)
    n = int(labels.max(initial=-1)) + 1
    key = known.min(axis=1) * n + known.max(axis=1)
    order = np.argsort(key)
    key, value = key[order], value[order]

    def share(one: Ends, other: Ends) -> NDArray[np.float32]:
        wanted = np.minimum(one, other).astype(np.int64) * n + np.maximum(one, other)
        at = np.minimum(np.searchsorted(key, wanted), len(key) - 1)
        return np.where(key[at] == wanted, value[at], value.min())

    return _strongest(labels, share)


def _strongest(
    regions: NDArray[np.int32], strength_of: Callable[[Ends, Ends], NDArray[np.float32]]
) -> NDArray[np.float32]:
    """Return the strongest border of each pixel with the next one in its row and column."""
    strength = np.zeros(regions.shape, np.float32)
    for one, other, here in (
        (regions[:, :-1], regions[:, 1:], strength[:, :-1]),
        (regions[:-1], regions[1:], strength[:-1]),
    ):
        at = np.nonzero((one != other) & (one >= 0) & (other >= 0))
        here[at] = np.maximum(here[at], strength_of(one[at], other[at]))
    return strength
