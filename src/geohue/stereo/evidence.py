"""What the images themselves say for or against a pair, its calibration and its disparity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.stereo.warping import warp_right

FEWEST = 20
"""Matched features below which nothing is said."""

_VERTICAL = 1.5  # px, median vertical offset of a pair that is not rectified
_FEATURE_WIDTH = 800  # columns of the pair in which features are looked for
_SCALES = (2.0, 3.0, 4.0, 16.0, 256.0)
_BETTER = 0.6  # another reading of a disparity must have at most this share of the error
_ENOUGH = 30_000  # pixels that a disparity is judged by
_NOTABLE = 6.0  # 8-bit steps; a smaller warping error is nothing to warn of


@dataclass(frozen=True, slots=True, eq=False)
class FeatureMatches:
    """Features found in both images.

    Attributes
    ----------
    points : (M, 2) float64
        x and y in the left image.
    offsets : (M, 2) float64
        Left minus right: the disparity, and the vertical offset.
    """

    points: NDArray[np.float64]
    offsets: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.points)

    @property
    def vertical(self) -> float | None:
        """Median absolute vertical offset in pixels; None with fewer than 20 matches."""
        return float(np.median(np.abs(self.offsets[:, 1]))) if len(self) >= FEWEST else None


def match_features(left: NDArray[np.uint8], right: NDArray[np.uint8]) -> FeatureMatches:
    """Match SIFT features of the two images, anywhere, not only along rows.

    A match must be mutual and clear of the second best, and must fit one epipolar geometry with
    the others.

    Parameters
    ----------
    left, right : (H, W, 3) or (H, W) uint8
        The images, rectified or not.

    Returns
    -------
    FeatureMatches
        Empty if the images show nothing in common.
    """
    import cv2

    step = max(1.0, left.shape[1] / _FEATURE_WIDTH)
    found = [_features(image, step) for image in (left, right)]
    if any(len(points) < FEWEST for points, _ in found):
        return FeatureMatches(np.zeros((0, 2)), np.zeros((0, 2)))
    (first, words), (second, other_words) = found
    pairs = _mutual(words, other_words)
    a, b = first[pairs[:, 0]], second[pairs[:, 1]]
    if len(a) >= FEWEST:
        cv2.setRNGSeed(0)
        _, fits = cv2.findFundamentalMat(a, b, cv2.FM_RANSAC, 1.5, 0.999, 2000)
        if fits is not None:
            a, b = a[fits.ravel() == 1], b[fits.ravel() == 1]
    return FeatureMatches(a * step, (a - b) * step)


def _features(image: NDArray[np.uint8], step: float) -> tuple[NDArray[Any], NDArray[Any]]:
    import cv2

    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY) if image.ndim == 3 else image
    if step > 1:
        size = (round(grey.shape[1] / step), round(grey.shape[0] / step))
        grey = cv2.resize(grey, size, interpolation=cv2.INTER_AREA)
    sift: Any = cv2.SIFT.create(nfeatures=1000)
    points, words = sift.detectAndCompute(grey, None)
    if words is None:
        return np.zeros((0, 2)), np.zeros((0, 128), np.float32)
    return np.array([point.pt for point in points], np.float64), words


def _mutual(words: NDArray[Any], other: NDArray[Any]) -> NDArray[np.int64]:
    """Return the pairs of descriptors that are each other's best, clear of the second."""
    products = words @ other.T
    lengths = (words**2).sum(axis=1)[:, None] + (other**2).sum(axis=1)
    distance = np.sqrt(np.maximum(lengths - 2 * products, 0))
    best = distance.argmin(axis=1)
    rows = np.arange(len(words))
    nearest = distance[rows, best]
    second = np.partition(distance, 1, axis=1)[:, 1]
    good = (distance.argmin(axis=0)[best] == rows) & (nearest < 0.75 * second)
    return np.stack([rows[good], best[good]], axis=1)


def looks_unrectified(matches: FeatureMatches) -> str | None:
    """Return the evidence that corresponding points do not lie in one row, None without."""
    vertical = matches.vertical
    if vertical is None or vertical <= _VERTICAL:
        return None
    return (
        f"the pair does not look rectified: {len(matches)} matched features lie "
        f"{vertical:.1f} px apart vertically (median; 0 in a rectified pair); give the "
        "calibration with R and T (rig=...), or the rectified images"
    )


def looks_swapped(matches: FeatureMatches, doffs: float) -> str | None:
    """Return the evidence that left and right are exchanged, None without.

    What lies in front of the cameras has ``d + doffs > 0``.
    """
    if len(matches) < FEWEST:
        return None
    behind = float((matches.offsets[:, 0] + doffs < -1).mean())
    if behind < 0.75:
        return None
    shift = -float(np.median(matches.offsets[:, 0]))
    return (
        f"left and right look exchanged: {100 * behind:.0f} % of {len(matches)} matched features "
        f"lie further right in the right image (median {shift:.1f} px), as if behind the cameras; "
        "exchange the two images"
    )


def doubt_disparity(
    left: NDArray[np.uint8],
    right: NDArray[np.uint8],
    disparity: NDArray[np.floating[Any]],
    scales: tuple[float, ...] = _SCALES,
) -> str | None:
    """Return the evidence that a disparity has the wrong sign, scale or order, None without.

    The right image is warped with the disparity as given and with each other reading: the other
    sign, a fraction or a multiple, and the two images exchanged. Another reading that fits much
    better is named.

    Parameters
    ----------
    left, right : (H, W, 3) uint8
        The rectified pair.
    disparity : (H, W) float
        Of the left image, NaN where missing.
    scales : tuple of float
        The factors that are tried, each both ways.

    Returns
    -------
    str or None
    """
    step = max(1, round(disparity.size / _ENOUGH))
    rows = slice(step // 2, None, step)  # whole rows, which warping does one by one
    left, right, disparity = left[rows], right[rows], disparity[rows]
    given = _misfit(left, right, disparity)
    others = {
        "with the other sign": _misfit(left, right, -disparity),
        "with the two images exchanged": _misfit(right, left, disparity),
    }
    for scale in scales:
        others[f"divided by {scale:g}"] = _misfit(left, right, disparity / scale)
        others[f"times {scale:g}"] = _misfit(left, right, disparity * scale)
    name = min(others, key=lambda key: others[key])
    if given <= _NOTABLE or others[name] > _BETTER * given:
        return None
    return (
        f"the disparity does not fit the images: they differ by {given:.0f} (median, of 255) when "
        f"warped with it, and by {others[name]:.0f} with it {name}; "
        "check disparity_scale, its sign and the order of the images"
    )


def _misfit(
    left: NDArray[np.uint8], right: NDArray[np.uint8], disparity: NDArray[np.floating[Any]]
) -> float:
    """Return the warping error, 255 where too little is seen to judge.

    A level difference of the two cameras is taken out, so that exposure does not count.
    """
    warp = warp_right(left, right, disparity)
    known = int(np.isfinite(disparity).sum())
    if known == 0 or warp.seen.sum() < 0.3 * known:
        return 255.0
    difference = left[warp.seen].astype(np.int16) - warp.colors[warp.seen]
    return float(np.median(np.abs(difference - np.median(difference, axis=0))))
