"""The right view as the left camera would see it (eq. 18), and what only one view sees."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError

TOLERANCE = 1.0
"""Pixels by which one surface must be nearer to hide another."""


@dataclass(frozen=True, slots=True, eq=False)
class Warp:
    """The right view warped to the left one.

    Attributes
    ----------
    colors : (H, W, 3) uint8
        The right image at ``x - d``; the left image where nothing corresponds.
    seen : (H, W) bool
        Where the right image was used. Elsewhere `colors` is a copy of the left.
    occluded : (H, W) bool
        Where a disparity exists, but something nearer hides the point from the right camera.
    error : float or None
        Median absolute difference of left and warped right over the seen pixels and channels,
        in 8-bit steps: evidence for or against the disparity. None if nothing is seen.
    """

    colors: NDArray[np.uint8]
    seen: NDArray[np.bool_]
    occluded: NDArray[np.bool_]
    error: float | None


def warp_right(
    left: NDArray[np.uint8],
    right: NDArray[np.uint8],
    disparity: NDArray[np.floating[Any]],
    right_disparity: NDArray[np.floating[Any]] | None = None,
) -> Warp:
    """Warp the right image to the viewpoint of the left one (eq. 18).

    The right image is interpolated linearly between pixel centres along its rows. The left image
    is copied where there is no disparity, where ``x - d`` is outside the right image, and where
    something nearer is in front (`find_occlusions`): a smeared foreground would stand there.

    Parameters
    ----------
    left, right : (H, W, 3) uint8
        The rectified pair.
    disparity : (H, W) float
        Of the left image, in pixels; NaN where missing.
    right_disparity : (H, W) float, optional
        Of the right image. Where it is known and disagrees, the point is occluded too.

    Returns
    -------
    Warp

    Raises
    ------
    GeohueError
        If the sizes differ.

    References
    ----------
    Dal Mutto, Zanuttigh, Cortelazzo, "Fusion of geometry and color information for scene
    segmentation", IEEE J. Sel. Topics Signal Process. 6(5), 2012, Sec. V, eq. 18.

    Examples
    --------
    The right view lies one pixel and a half to the left; the first two pixels are out of frame:

    >>> left = np.array([[0, 10, 20, 30]], np.uint8)[..., None].repeat(3, 2)
    >>> right = np.array([[40, 60, 80, 90]], np.uint8)[..., None].repeat(3, 2)
    >>> warp_right(left, right, np.full((1, 4), 1.5)).colors[..., 0].tolist()
    [[0, 10, 50, 70]]
    """
    check_pair(left, right, disparity)
    height, width = disparity.shape
    known = np.isfinite(disparity)
    x = np.arange(width) - np.where(known, disparity, 0.0)
    inside = known & (x >= 0) & (x <= width - 1)
    occluded = find_occlusions(disparity)
    if right_disparity is not None:
        occluded |= inside & _disagrees(disparity, right_disparity)
    seen = inside & ~occluded
    low = np.clip(np.floor(x), 0, max(width - 2, 0)).astype(np.int64)
    share = (x - low)[..., None].astype(np.float32)
    rows = np.arange(height)[:, None]
    after = right[rows, np.minimum(low + 1, width - 1)]
    mixed = right[rows, low] * (1 - share) + after * share
    colors = np.where(seen[..., None], np.clip(np.rint(mixed), 0, 255).astype(np.uint8), left)
    return Warp(colors, seen, occluded, _error(left, colors, seen))


def find_occlusions(disparity: NDArray[np.floating[Any]]) -> NDArray[np.bool_]:
    """Mark the pixels of the left image that something nearer hides from the right camera.

    A depth buffer: every pixel enters its disparity at the two pixels of the right image between
    which it falls, where the largest wins. A pixel is hidden if one of its two holds a surface
    that is nearer by more than one pixel of disparity.

    Parameters
    ----------
    disparity : (H, W) float
        Of the left image; NaN where missing.

    Returns
    -------
    (H, W) bool

    Examples
    --------
    The last pixel is 3 px nearer and lands on the place of the second one:

    >>> find_occlusions(np.array([[0.0, 0, 0, 0, 3]])).tolist()
    [[False, True, False, False, False]]
    """
    height, width = disparity.shape
    known = np.isfinite(disparity)
    values = np.where(known, disparity, 0.0)
    x = np.arange(width) - values
    known &= (x > -1) & (x < width)
    row = np.broadcast_to(np.arange(height)[:, None], disparity.shape)
    nearest = np.full((height, width + 2), -np.inf)  # a column more on either side
    sides = [np.floor(x).astype(np.int64) + 1, np.ceil(x).astype(np.int64) + 1]
    for side in sides:
        np.maximum.at(nearest, (row[known], side[known]), values[known])
    hidden = np.zeros(disparity.shape, bool)
    for side in sides:
        hidden[known] |= nearest[row[known], side[known]] > values[known] + TOLERANCE
    return hidden


def consistent(
    disparity: NDArray[np.floating[Any]], other: NDArray[np.floating[Any]]
) -> NDArray[np.bool_]:
    """Mark where the other view's disparity at the corresponding pixel is the same within 1 px.

    False too where either is missing or the corresponding pixel is out of frame.
    """
    match, inside = _counterparts(disparity, other)
    with np.errstate(invalid="ignore"):
        return np.asarray(inside & (np.abs(match - disparity) <= TOLERANCE))


def _disagrees(
    disparity: NDArray[np.floating[Any]], other: NDArray[np.floating[Any]]
) -> NDArray[np.bool_]:
    match, inside = _counterparts(disparity, other)
    with np.errstate(invalid="ignore"):
        return np.asarray(inside & (np.abs(match - disparity) > TOLERANCE))


def _counterparts(
    disparity: NDArray[np.floating[Any]], other: NDArray[np.floating[Any]]
) -> tuple[NDArray[Any], NDArray[np.bool_]]:
    """Return the other view's disparity nearest to ``x - d``, and whether that is in frame."""
    if disparity.shape != other.shape:
        raise GeohueError(
            f"the disparities of the two views differ in size: {_size(disparity)} and "
            f"{_size(other)}; both must be those of the rectified images"
        )
    width = disparity.shape[1]
    known = np.isfinite(disparity)
    x = np.rint(np.arange(width) - np.where(known, disparity, 0.0))
    inside = known & (x >= 0) & (x <= width - 1)
    return np.take_along_axis(other, np.clip(x, 0, width - 1).astype(np.int64), axis=1), inside


def check_pair(
    left: NDArray[Any], right: NDArray[Any], disparity: NDArray[Any] | None = None
) -> None:
    """Raise GeohueError unless both images, and the disparity, have one size."""
    if left.shape[:2] != right.shape[:2]:
        raise GeohueError(
            f"left and right image differ in size: {_size(left)} and {_size(right)}; "
            "give the two images of one rectified or calibrated pair"
        )
    if disparity is not None and disparity.shape != left.shape[:2]:
        raise GeohueError(
            f"image and disparity differ in size: {_size(left)} and {_size(disparity)}; "
            "give the disparity of the left image at its own size"
        )


def _size(array: NDArray[Any]) -> str:
    return " x ".join(str(side) for side in array.shape[1::-1])


def _error(
    left: NDArray[np.uint8], warped: NDArray[np.uint8], seen: NDArray[np.bool_]
) -> float | None:
    if not seen.any():
        return None
    return float(np.median(np.abs(left[seen].astype(np.int16) - warped[seen])))
