"""Semi-global matching on pairs whose disparity is known, and what it must leave out."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

from geohue.errors import GeohueError
from geohue.stereo import estimate_range, match

Image = NDArray[np.uint8]


def texture(height: int, width: int, seed: int = 0) -> Image:
    noise = np.random.default_rng(seed).normal(size=(height, width, 3))
    smooth = ndimage.gaussian_filter(noise, (1.0, 1.0, 0))
    return np.asarray(np.clip(128 + 60 * smooth / smooth.std(), 0, 255), np.uint8)


def shifted(by: int, height: int = 80, width: int = 120) -> tuple[Image, Image]:
    scene = texture(height, width + abs(by))
    if by < 0:
        right, left = shifted(-by, height, width)
        return left, right
    return scene[:, :width], scene[:, by : by + width]


@pytest.fixture(scope="module")
def box() -> tuple[Image, Image, NDArray[np.float64]]:
    """A square 12 px nearer in front of a background at 4 px."""
    background, front = texture(100, 200, 1), texture(40, 60, 2)
    left, right = background[:, 4:164].copy(), background[:, 8:168].copy()
    left[30:70, 60:100] = front[:, :40]
    right[30:70, 44:84] = front[:, :40]
    truth = np.full(left.shape[:2], 4.0)
    truth[30:70, 60:100] = 16
    return left, right, truth


@pytest.mark.parametrize("by", [0, 3, 17, -9])
def test_a_shift_is_found_in_both_views(by: int) -> None:
    left, right = shifted(by)
    found = match(left, right, (min(by, 0) - 8, max(by, 0) + 8))
    assert found.density > 0.6
    for side in (found.left, found.right):
        np.testing.assert_allclose(side[np.isfinite(side)], by, atol=0.5)


def test_a_half_pixel_is_found() -> None:
    scene = texture(80, 300).astype(np.float64)
    left = scene[:, 20:280:2]
    right = scene[:, 25:285:2]  # 5 pixels at twice the size
    found = match(left.astype(np.uint8), right.astype(np.uint8), (0, 16))
    assert np.nanmedian(found.left) == pytest.approx(2.5, abs=0.2)


def test_box_is_found_and_what_it_hides_is_left_out(
    box: tuple[Image, Image, NDArray[np.float64]],
) -> None:
    left, right, truth = box
    found = match(left, right, (0, 24))
    known = np.isfinite(found.left)
    assert (np.abs(found.left - truth)[known] > 1).mean() < 0.02
    hidden = np.zeros(truth.shape, bool)
    hidden[32:68, 49:59] = True  # left of the box, 12 px wide
    assert known[hidden].mean() < 0.15
    assert known[~hidden].mean() > 0.85


def test_left_border_is_matched_as_far_as_the_other_view_shows_it(
    box: tuple[Image, Image, NDArray[np.float64]],
) -> None:
    left, right, _ = box
    found = match(left, right, (0, 40))
    assert np.isfinite(found.left[:, 6:30]).mean() > 0.8
    assert not np.isfinite(found.left[:, :3]).any()


@pytest.mark.parametrize("by", [2, 12, 40, -6])
def test_range_holds_the_disparity(by: int) -> None:
    low, high = estimate_range(*shifted(by, 120, 200))
    assert low <= by <= high
    assert high - low < 60


def test_range_of_a_large_pair_is_in_its_own_pixels() -> None:
    left, right = shifted(30, 200, 960)
    smooth = [ndimage.uniform_filter(view, (5, 5, 0)) for view in (left, right)]
    low, high = estimate_range(*smooth)
    assert low <= 30 <= high


def test_without_a_range_the_pair_gives_it(box: tuple[Image, Image, NDArray[np.float64]]) -> None:
    left, right, truth = box
    found = match(left, right)
    low, high = found.range
    assert low <= 4 < 16 <= high
    known = np.isfinite(found.left)
    assert (np.abs(found.left - truth)[known] > 1).mean() < 0.03


def test_matching_does_not_depend_on_chance() -> None:
    left, right = shifted(5)
    np.testing.assert_array_equal(match(left, right).left, match(left, right).left)


def test_grey_images() -> None:
    left, right = (view[..., 0] for view in shifted(6))
    assert np.nanmedian(match(left, right, (0, 16)).left) == 6


def test_speckles_can_be_kept(box: tuple[Image, Image, NDArray[np.float64]]) -> None:
    left, right, _ = box
    assert match(left, right, (0, 24), speckle=0).density >= match(left, right, (0, 24)).density


def test_blank_images_are_refused() -> None:
    scene = texture(60, 80)
    blank = np.full_like(scene, 7)
    with pytest.raises(GeohueError, match=r"right image is blank \(values 7 to 7"):
        match(scene, blank)
    with pytest.raises(GeohueError, match="left image is blank"):
        match(blank, scene)


def test_two_scenes_are_refused() -> None:
    with pytest.raises(GeohueError, match="do not match: only"):
        match(texture(120, 160, 3), texture(120, 160, 4))


@pytest.mark.parametrize("given", [(5, 5), (10, 2), (0, 500), (-300, -200)])
def test_impossible_ranges_are_refused(given: tuple[int, int]) -> None:
    left, right = shifted(3)
    with pytest.raises(GeohueError, match="disparity range"):
        match(left, right, given)


def test_sizes_that_differ_are_refused() -> None:
    with pytest.raises(GeohueError, match="differ in size"):
        match(texture(40, 60), texture(40, 61))
