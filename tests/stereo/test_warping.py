"""Eq. 18 against a slow twin, by hand, and by laws; occlusions are found, not smeared."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.stereo import find_occlusions, warp_right

Pair = tuple[NDArray[np.uint8], NDArray[np.uint8], NDArray[np.float64]]


def slow_occlusions(disparity: NDArray[Any]) -> NDArray[np.bool_]:
    """Compare each pixel with every other of its row."""
    height, width = disparity.shape
    hidden = np.zeros((height, width), bool)
    for y in range(height):
        ends: list[tuple[int, set[int]]] = []
        for x in range(width):
            d = disparity[y, x]
            if not math.isfinite(d):
                continue
            place = x - d
            if -1 < place < width:
                ends.append((x, {math.floor(place), math.ceil(place)}))
        for x, cells in ends:
            for other, others in ends:
                if cells & others and disparity[y, other] > disparity[y, x] + 1:
                    hidden[y, x] = True
    return hidden


def slow_warp(
    left: NDArray[np.uint8], right: NDArray[np.uint8], disparity: NDArray[Any]
) -> NDArray[np.uint8]:
    """Do eq. 18 pixel by pixel."""
    height, width = disparity.shape
    warped = left.copy()
    hidden = slow_occlusions(disparity)
    for y in range(height):
        for x in range(width):
            d = disparity[y, x]
            if not math.isfinite(d) or hidden[y, x] or not 0 <= x - d <= width - 1:
                continue
            low = math.floor(x - d)
            share = np.float32(x - d - low)
            after = right[y, min(low + 1, width - 1)]
            mixed = right[y, low] * (1 - share) + after * share
            warped[y, x] = np.clip(np.rint(mixed), 0, 255)
    return warped


@st.composite
def pairs(draw: st.DrawFn) -> Pair:
    height, width = draw(st.integers(1, 4)), draw(st.integers(1, 12))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    left, right = rng.integers(0, 256, (2, height, width, 3)).astype(np.uint8)
    steps = draw(st.sampled_from([1.0, 0.5, 0.125]))
    disparity = np.round(rng.uniform(-3, 6, (height, width)) / steps) * steps
    disparity[rng.random((height, width)) < 0.2] = np.nan
    return left, right, disparity


@settings(max_examples=150, deadline=None)
@given(pairs())
def test_warp_is_its_slow_twin(pair: Pair) -> None:
    left, right, disparity = pair
    np.testing.assert_array_equal(find_occlusions(disparity), slow_occlusions(disparity))
    np.testing.assert_array_equal(
        warp_right(left, right, disparity).colors, slow_warp(left, right, disparity)
    )


@settings(max_examples=50, deadline=None)
@given(pairs())
def test_zero_disparity_gives_the_right_image(pair: Pair) -> None:
    left, right, disparity = pair
    warp = warp_right(left, right, np.zeros(disparity.shape))
    np.testing.assert_array_equal(warp.colors, right)
    assert warp.seen.all()


@settings(max_examples=50, deadline=None)
@given(pairs())
def test_what_is_not_seen_is_the_left_image(pair: Pair) -> None:
    left, right, disparity = pair
    warp = warp_right(left, right, disparity)
    np.testing.assert_array_equal(warp.colors[~warp.seen], left[~warp.seen])
    assert not (warp.seen & ~np.isfinite(disparity)).any()
    assert not (warp.seen & warp.occluded).any()


def grey(values: list[int]) -> NDArray[np.uint8]:
    return np.array([values], np.uint8)[..., None].repeat(3, 2)


def test_warp_by_hand() -> None:
    """Pixel 2 lies at 1.25 in the right image: 200 * 0.75 + 40 * 0.25 = 160."""
    warp = warp_right(
        grey([1, 2, 3, 4]), grey([100, 200, 40, 60]), np.array([[0, 2, 0.75, np.nan]])
    )
    assert warp.colors[0, :, 0].tolist() == [100, 2, 160, 4]
    assert warp.seen[0].tolist() == [True, False, True, False]
    assert warp.error == pytest.approx((99 + 157) / 2)


def test_foreground_hides_what_lies_behind_it() -> None:
    """A box 3 px nearer covers three background pixels on its left in the right view."""
    disparity = np.zeros((1, 12))
    disparity[0, 6:9] = 3
    right = grey([0, 10, 20, 160, 170, 180, 99, 99, 99, 90, 100, 110])
    left = grey([0, 10, 20, 30, 40, 50, 160, 170, 180, 90, 100, 110])
    warp = warp_right(left, right, disparity)
    assert np.flatnonzero(warp.occluded[0]).tolist() == [3, 4, 5]
    np.testing.assert_array_equal(warp.colors, left)


def test_a_slant_hides_nothing() -> None:
    disparity = np.linspace(0, 6, 20)[None]
    assert not find_occlusions(disparity).any()


def test_the_other_disparity_finds_more_occlusions() -> None:
    """The foreground that hides the pixel is missing in the left disparity."""
    disparity = np.zeros((1, 6))
    other = np.zeros((1, 6))
    other[0, 2] = 4
    warp = warp_right(grey([1] * 6), grey([9] * 6), disparity, other)
    assert np.flatnonzero(warp.occluded[0]).tolist() == [2]


def test_nothing_seen_has_no_error() -> None:
    assert warp_right(grey([1, 2]), grey([1, 2]), np.full((1, 2), np.nan)).error is None


def test_sizes_that_differ_are_refused() -> None:
    with pytest.raises(GeohueError, match="left and right image differ in size: 2 x 1 and 3 x 1"):
        warp_right(grey([1, 2]), grey([1, 2, 3]), np.zeros((1, 2)))
    with pytest.raises(GeohueError, match="image and disparity differ in size: 2 x 1 and 3 x 1"):
        warp_right(grey([1, 2]), grey([1, 2]), np.zeros((1, 3)))
    with pytest.raises(GeohueError, match="disparities of the two views differ"):
        warp_right(grey([1, 2]), grey([1, 2]), np.zeros((1, 2)), np.zeros((1, 3)))
