"""Disparities of a rectified pair by semi-global matching, with what cannot be trusted left out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.stereo.warping import check_pair, consistent

BLANK = 2.0
"""An image whose grey values deviate by less than this has nothing to match."""

_STEPS = 16  # OpenCV's fixed point: sixteenths of a pixel
_COARSE = 320  # columns of the small pair that the range is taken from
_MEMORY = 600 << 20  # bytes that the eight-path aggregation may take


@dataclass(frozen=True, slots=True, eq=False)
class StereoMatch:
    """The disparities of both views.

    Attributes
    ----------
    left, right : (H, W) float32
        Disparity of each pixel in sixteenths of a pixel, NaN where there is none that both views
        agree on. Both are positive where a point is nearer than infinity (with doffs = 0): a
        pixel x of the right image lies at ``x + d`` in the left one.
    range : (int, int)
        Smallest and largest disparity that was looked for.
    """

    left: NDArray[np.float32]
    right: NDArray[np.float32]
    range: tuple[int, int]

    @property
    def density(self) -> float:
        """Share of the pixels of the left image that have a disparity."""
        return float(np.isfinite(self.left).mean())


def match(
    left: NDArray[np.uint8],
    right: NDArray[np.uint8],
    disparity_range: tuple[int, int] | None = None,
    *,
    at_infinity: float | None = None,
    uniqueness: int = 10,
    speckle: int = 60,
) -> StereoMatch:
    """Find the disparity of each pixel of a rectified pair.

    OpenCV's semi-global matcher on 3 x 3 blocks along eight paths, once for each view. A
    disparity stays if the best cost is clear of the second by `uniqueness` percent, the two views
    agree within one pixel, and its patch of similar disparities is no speckle. Nothing is filled
    in: what is left out is NaN.

    Parameters
    ----------
    left, right : (H, W, 3) or (H, W) uint8
        The rectified images.
    disparity_range : (int, int), optional
        Smallest and largest disparity. None: `estimate_range`.
    at_infinity : float, optional
        Disparity of a point at infinity (``-doffs``), where it is known: an estimated range goes
        no lower.
    uniqueness : int
        Percent, 0 to 100.
    speckle : int
        Patches with fewer pixels are left out, for an image of 160,000 pixels; other sizes in
        proportion. 0 keeps all.

    Returns
    -------
    StereoMatch

    Raises
    ------
    GeohueError
        If the sizes differ, an image is blank, or the range is empty or as wide as the image.

    References
    ----------
    Hirschmueller, "Stereo processing by semiglobal matching and mutual information", IEEE Trans.
    PAMI 30(2), 2008.

    Examples
    --------
    >>> noise = np.random.default_rng(0).integers(0, 256, (60, 90, 3)).astype(np.uint8)
    >>> found = match(noise[:, :-8], noise[:, 8:], (0, 16))
    >>> float(np.nanmedian(found.left))
    8.0
    """
    check_pair(left, right)
    check_texture(left, "left")
    check_texture(right, "right")
    given = _checked_range(disparity_range, left.shape[1])
    low, high = given or estimate_range(left, right)
    if given is None and at_infinity is not None and at_infinity < high - 1:
        low = max(low, int(np.floor(at_infinity)))
    first = _one_way(left, right, low, high, uniqueness)
    second = _one_way(_flip(right), _flip(left), low, high, uniqueness)[:, ::-1]
    # Seen in a mirror a disparity has the same sign and lies on the other side.
    kept_first = np.where(consistent(first, second), first, np.nan)
    kept_second = np.where(_flip(consistent(_flip(second), _flip(first))), second, np.nan)
    least = round(speckle * left.shape[0] * left.shape[1] / 160_000)
    return StereoMatch(
        _without_speckles(kept_first, least), _without_speckles(kept_second, least), (low, high)
    )


def estimate_range(left: NDArray[np.uint8], right: NDArray[np.uint8]) -> tuple[int, int]:
    """Estimate the smallest and the largest disparity of a rectified pair.

    The pair is matched at a width of 320 pixels over a quarter of it to the one side and half of
    it to the other. The range goes from the 0.5th to the 99.9th percentile of the disparities that
    both views agree on, with a tenth of that added below, a fifth above, and two coarse pixels.

    Parameters
    ----------
    left, right : (H, W, 3) or (H, W) uint8
        The rectified images.

    Returns
    -------
    (int, int)

    Raises
    ------
    GeohueError
        If so little agrees that the pair cannot be of one scene.
    """
    import cv2

    height, width = left.shape[:2]
    step = max(1.0, width / _COARSE)
    size = (max(8, round(width / step)), max(8, round(height / step)))
    small = [
        np.asarray(cv2.resize(i, size, interpolation=cv2.INTER_AREA), np.uint8)
        for i in (left, right)
    ]
    low, high = -(size[0] // 4), size[0] // 2
    first = _one_way(small[0], small[1], low, high, 15, quick=True)
    second = _one_way(_flip(small[1]), _flip(small[0]), low, high, 15, quick=True)[:, ::-1]
    agreed = _without_speckles(np.where(consistent(first, second), first, np.nan), 40)
    found = agreed[np.isfinite(agreed)]
    if found.size < 0.02 * agreed.size:
        raise GeohueError(
            f"left and right do not match: only {100 * found.size / agreed.size:.1f} % of the "
            "pixels agree on a disparity; check that both are of one scene and rectified"
        )
    low_end, high_end = np.percentile(found, [0.5, 99.9])
    span = high_end - low_end
    top = high_end + 0.2 * span + 2  # near things are small and easily missed
    return int(np.floor((low_end - 0.1 * span - 2) * step)), int(np.ceil(top * step))


def check_texture(image: NDArray[np.uint8], name: str) -> None:
    """Raise GeohueError if an image is blank."""
    if is_blank(image):
        raise GeohueError(
            f"the {name} image is blank (values {image.min()} to {image.max()}, deviation "
            f"{float(image.std()):.1f}): there is nothing to match; check the file and the lens cap"
        )


def is_blank(image: NDArray[np.uint8]) -> bool:
    """Whether an image has hardly any contrast."""
    return float(image.mean(axis=-1).std() if image.ndim == 3 else image.std()) < BLANK


def _checked_range(given: tuple[int, int] | None, width: int) -> tuple[int, int] | None:
    if given is None:
        return None
    low, high = given
    if not low < high or high - low > width or abs(low) > width or abs(high) > width:
        raise GeohueError(
            f"disparity range {low} to {high}: the first must be smaller, and both within the "
            f"image's width of {width} pixels"
        )
    return int(low), int(high)


def _one_way(
    left: NDArray[np.uint8],
    right: NDArray[np.uint8],
    low: int,
    high: int,
    uniqueness: int,
    *,
    quick: bool = False,
) -> NDArray[np.float32]:
    """Match the left image; NaN where the best cost is unclear or the match is out of frame.

    The matcher skips the columns from which the largest disparity leads out of the image. With a
    margin it looks at them too, since smaller disparities may still be found there.
    """
    import cv2

    create: Any = cv2.StereoSGBM.create  # its type stub names no arguments
    count = -(-(high - low + 1) // _STEPS) * _STEPS
    before, after = max(0, low + count), max(0, -low)
    padded = [
        cv2.copyMakeBorder(i, 0, 0, before, after, cv2.BORDER_REPLICATE) for i in (left, right)
    ]
    channels = left.shape[2] if left.ndim == 3 else 1
    three_paths = quick or padded[0].shape[0] * padded[0].shape[1] * count * 4 > _MEMORY
    matcher = create(
        minDisparity=low,
        numDisparities=count,
        blockSize=3,
        P1=8 * channels * 9,
        P2=32 * channels * 9,
        preFilterCap=31,
        uniquenessRatio=uniqueness,
        disp12MaxDiff=-1,  # done here, with both views
        mode=cv2.STEREO_SGBM_MODE_SGBM_3WAY if three_paths else cv2.STEREO_SGBM_MODE_HH,
    )
    width = left.shape[1]
    found = np.asarray(matcher.compute(*padded))[:, before : before + width]
    disparity = found.astype(np.float32) / _STEPS
    x = np.arange(width) - disparity
    disparity[(disparity < low) | (disparity > high) | (x < 0) | (x > width - 1)] = np.nan
    return disparity.astype(np.float32, copy=False)


def _without_speckles(disparity: NDArray[np.floating[Any]], least: int) -> NDArray[np.float32]:
    import cv2

    if least < 1:
        return disparity.astype(np.float32)
    missing = -(1 << 15)
    fixed = np.where(np.isfinite(disparity), np.rint(np.nan_to_num(disparity) * _STEPS), missing)
    patches = np.ascontiguousarray(fixed.astype(np.int16))
    cv2.filterSpeckles(patches, missing, least, _STEPS)
    return np.where(patches == missing, np.nan, disparity).astype(np.float32)


def _flip(array: NDArray[Any]) -> NDArray[Any]:
    return np.ascontiguousarray(array[:, ::-1])
