"""`Scene.from_stereo`: what it holds, the roles swapped, and every kind of bad pair."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from geohue import Intrinsics, Scene, segment
from geohue.errors import GeohueError
from geohue.stereo import StereoPair, StereoRig, match, view_agreement

from .conftest import Pair, texture


def rig_of(pair: Pair, doffs: float = 0.0) -> StereoRig:
    height, width = pair.disparity.shape
    camera = Intrinsics(200.0, 200.0, (width - 1) / 2, (height - 1) / 2, width, height)
    return StereoRig(camera, camera, 0.06, doffs)


def test_given_disparity_becomes_depth_and_second_view(box_pair: Pair) -> None:
    scene = Scene.from_stereo(box_pair.left, box_pair.right, rig_of(box_pair), box_pair.disparity)
    assert scene.warnings == ()
    assert scene.depth is not None
    np.testing.assert_allclose(scene.depth[0, 0], 200 * 0.06 / 6)
    np.testing.assert_allclose(scene.depth[80, 150], 200 * 0.06 / 18)
    assert scene.second_colors is not None
    np.testing.assert_array_equal(scene.second_colors, box_pair.left)


def test_without_disparity_it_is_matched(box_pair: Pair) -> None:
    scene = Scene.from_stereo(box_pair.left, box_pair.right, rig_of(box_pair))
    assert scene.depth is not None
    known = np.isfinite(scene.depth)
    assert known.mean() > 0.75
    truth = 12.0 / box_pair.disparity
    assert (np.abs(scene.depth - truth)[known] < 0.1).mean() > 0.97


def test_one_view_has_no_second_colours(box_pair: Pair) -> None:
    scene = Scene.from_stereo(*box_pair[:2], rig_of(box_pair), box_pair.disparity, views=1)
    assert scene.second_colors is None
    with pytest.raises(GeohueError, match="views is 3"):
        Scene.from_stereo(*box_pair[:2], rig_of(box_pair), box_pair.disparity, views=3)  # type: ignore[arg-type]


def test_segments_are_the_box_and_the_background(box_pair: Pair) -> None:
    scene = Scene.from_stereo(*box_pair[:2], rig_of(box_pair), box_pair.disparity)
    labels = segment(scene, k=2, cues="geometry").labels
    expected = (box_pair.disparity > 10).astype(int)
    assert (labels == expected).mean() > 0.98


def test_without_a_rig_it_says_so(box_pair: Pair) -> None:
    scene = Scene.from_stereo(*box_pair[:2], disparity=box_pair.disparity)
    assert len(scene.warnings) == 1
    assert "no stereo calibration" in scene.warnings[0]


def test_missing_disparities_copy_the_left_view(box_pair: Pair) -> None:
    holes = box_pair.disparity.copy()
    holes[:40] = np.nan
    holes[0, 0] = np.inf
    scene = Scene.from_stereo(*box_pair[:2], rig_of(box_pair), holes)
    assert not scene.valid[:40].any()
    assert scene.second_colors is not None
    np.testing.assert_array_equal(scene.second_colors[:40], box_pair.left[:40])


def test_grey_images_become_three_equal_channels(box_pair: Pair) -> None:
    left, right = (view[..., 1] for view in box_pair[:2])
    scene = Scene.from_stereo(left, right, rig_of(box_pair), box_pair.disparity)
    assert scene.colors.shape == (*box_pair.disparity.shape, 3)


def test_rig_for_another_size_is_scaled(box_pair: Pair) -> None:
    height, width = box_pair.disparity.shape
    camera = Intrinsics(400.0, 400.0, width - 0.5, height - 0.5, 2 * width, 2 * height)
    rig = StereoRig(camera, camera, 0.06)
    scene = Scene.from_stereo(*box_pair[:2], rig, box_pair.disparity)
    assert scene.depth is not None
    np.testing.assert_allclose(scene.depth[0, 0], 2.0)
    assert f"scaled to the images' {width} x {height}" in scene.warnings[0]
    camera = Intrinsics(400.0, 400.0, 9, 9, 2 * width, 3 * height)
    tall = StereoRig(camera, camera, 0.06)
    scene = Scene.from_stereo(*box_pair[:2], tall, box_pair.disparity)
    assert "other proportions" in scene.warnings[0]


# --- the roles of the views ----------------------------------------------------------------------


def test_swapping_twice_is_identity(box_pair: Pair) -> None:
    pair = StereoPair.prepare(*box_pair[:2], rig_of(box_pair))
    back = pair.swapped().swapped()
    assert pair.right_disparity is not None
    assert back.right_disparity is not None
    np.testing.assert_array_equal(back.left, pair.left)
    np.testing.assert_array_equal(back.right, pair.right)
    np.testing.assert_array_equal(back.disparity, pair.disparity)
    np.testing.assert_array_equal(back.right_disparity, pair.right_disparity)
    assert back.rig.left == pair.rig.left


def test_swapped_pair_is_the_right_view_in_a_mirror(box_pair: Pair) -> None:
    pair = StereoPair.prepare(*box_pair[:2], rig_of(box_pair))
    swapped = pair.swapped()
    again = StereoPair.prepare(swapped.left, swapped.right, swapped.rig, swapped.disparity)
    assert again.warnings == ()
    error = swapped.warp().error
    assert error is not None
    assert error <= 2


def test_both_views_agree(box_pair: Pair) -> None:
    pair = StereoPair.prepare(*box_pair[:2], rig_of(box_pair))
    left = segment(Scene.from_pair(pair), k=2, cues="geometry").labels
    right = segment(Scene.from_pair(pair.swapped()), k=2, cues="geometry").labels[:, ::-1]
    share = view_agreement(left, right, pair.disparity).share
    assert share is not None
    assert share > 0.97


def test_without_a_right_disparity_roles_cannot_be_swapped(box_pair: Pair) -> None:
    pair = StereoPair.prepare(*box_pair[:2], rig_of(box_pair), box_pair.disparity)
    with pytest.raises(GeohueError, match="no disparity"):
        pair.swapped()


# --- raw pairs -----------------------------------------------------------------------------------


def raw_pair(pair: Pair) -> tuple[NDArray[np.uint8], NDArray[np.uint8], StereoRig]:
    """Turn the right camera by two degrees about its axis: its image turns the other way."""
    angle = np.deg2rad(2.0)
    rig = rig_of(pair)
    c, s = np.cos(angle), np.sin(angle)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    camera = rig.left
    K = np.array([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]])
    size = (pair.left.shape[1], pair.left.shape[0])
    turned = cv2.warpPerspective(pair.right, K @ R @ np.linalg.inv(K), size)
    raw = StereoRig(camera, camera, rotation=R, translation=R @ np.array([-0.06, 0.0, 0.0]))
    return pair.left, np.asarray(turned, np.uint8), raw


def test_a_raw_pair_is_rectified(box_pair: Pair) -> None:
    pair = StereoPair.prepare(*raw_pair(box_pair))
    assert pair.rig.is_rectified
    assert pair.warnings == ()
    assert np.isfinite(pair.disparity).mean() > 0.7
    error = pair.warp().error
    assert error is not None
    assert error < 6


def test_a_raw_pair_given_as_rectified_is_noticed(box_pair: Pair) -> None:
    left, right, _ = raw_pair(box_pair)
    tilted = np.roll(right, 4, axis=0)
    pair = StereoPair.prepare(left, tilted, rig_of(box_pair), disparity_range=(0, 32))
    found = [note for note in pair.warnings if "does not look rectified" in note]
    assert len(found) == 1
    assert "px apart vertically" in found[0]
    assert "matched features" in found[0]


def test_a_rectified_pair_with_a_raw_calibration_is_used_as_it_is(box_pair: Pair) -> None:
    angle = np.deg2rad(3.0)
    c, s = np.cos(angle), np.sin(angle)
    camera = rig_of(box_pair).left
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    rig = StereoRig(camera, camera, rotation=R, translation=np.array([-0.06, 0.0, 0.0]))
    pair = StereoPair.prepare(*box_pair[:2], rig)
    assert len(pair.warnings) == 1
    assert "rectified already" in pair.warnings[0]
    np.testing.assert_array_equal(pair.left, box_pair.left)


# --- bad pairs -----------------------------------------------------------------------------------


def test_different_sizes(box_pair: Pair) -> None:
    with pytest.raises(GeohueError, match="left and right image differ in size: 240 x 160"):
        Scene.from_stereo(box_pair.left, box_pair.right[:-1])
    with pytest.raises(GeohueError, match="image and disparity differ in size"):
        Scene.from_stereo(*box_pair[:2], disparity=box_pair.disparity[:-1])


def test_exchanged_images_are_refused_with_evidence(box_pair: Pair) -> None:
    with pytest.raises(GeohueError, match=r"look exchanged: \d+ % of \d+ matched features"):
        Scene.from_stereo(box_pair.right, box_pair.left)


def test_negative_disparities_are_right_where_doffs_say_so(box_pair: Pair) -> None:
    """Cut 20 columns off the left side of the left image: all disparities are negative."""
    left, right = box_pair.left[:, 20:], box_pair.right[:, :-20]
    camera = Intrinsics(200.0, 200.0, 100.0, 80.0)
    narrow = StereoRig(camera, camera, 0.06, 20.0)
    pair = StereoPair.prepare(left, right, narrow)
    assert pair.warnings == ()
    assert np.nanmedian(pair.disparity) == pytest.approx(-14, abs=0.2)
    assert np.nanmedian(pair.depth) == pytest.approx(2.0, abs=0.05)


def test_wrong_sign_is_refused_with_evidence(box_pair: Pair) -> None:
    with pytest.raises(GeohueError, match=r"100 % of the disparities.*with the other sign"):
        Scene.from_stereo(*box_pair[:2], rig_of(box_pair), -box_pair.disparity)


@pytest.mark.parametrize(
    ("factor", "reading"), [(3.0, "divided by 3"), (0.25, "times 4"), (256.0, "divided by 256")]
)
def test_wrong_scale_is_warned_of_with_evidence(
    box_pair: Pair, factor: float, reading: str
) -> None:
    scene = Scene.from_stereo(*box_pair[:2], rig_of(box_pair), box_pair.disparity * factor)
    assert len(scene.warnings) == 1
    assert "does not fit the images" in scene.warnings[0]
    assert reading in scene.warnings[0]


def test_disparity_of_the_right_image_is_not_called_wrong_scale(box_pair: Pair) -> None:
    scene = Scene.from_stereo(*box_pair[:2], rig_of(box_pair), box_pair.disparity)
    assert scene.warnings == ()


def test_blank_images(box_pair: Pair) -> None:
    blank = np.zeros_like(box_pair.left)
    with pytest.raises(GeohueError, match="right image is blank"):
        Scene.from_stereo(box_pair.left, blank)
    scene = Scene.from_stereo(box_pair.left, blank, rig_of(box_pair), box_pair.disparity)
    assert scene.warnings == ("the right image is blank: its colours say nothing",)


def test_two_scenes(box_pair: Pair) -> None:
    with pytest.raises(GeohueError, match="do not match"):
        Scene.from_stereo(box_pair.left, texture(160, 240, 9))


def test_what_may_lie_at_infinity_has_no_depth(box_pair: Pair) -> None:
    """Half a pixel is the least that counts: 0.4 px could be 30 m or no end."""
    far = box_pair.disparity.copy()
    far[:10], far[10:20] = 0.4, 0.5
    scene = Scene.from_stereo(*box_pair[:2], rig_of(box_pair), far)
    assert scene.depth is not None
    assert np.isnan(scene.depth[:10]).all()
    np.testing.assert_allclose(scene.depth[10:20], 24.0)


def test_nothing_is_looked_for_beyond_infinity(box_pair: Pair) -> None:
    pair = StereoPair.prepare(*box_pair[:2], rig_of(box_pair))
    assert np.nanmin(pair.disparity) >= 0
    low, _ = match(*box_pair[:2], at_infinity=-3.5).range
    assert low >= -4


def test_nearly_no_disparity_is_warned_of(box_pair: Pair) -> None:
    sparse = np.full_like(box_pair.disparity, np.nan)
    sparse[::10, ::10] = box_pair.disparity[::10, ::10]
    scene = Scene.from_stereo(*box_pair[:2], rig_of(box_pair), sparse)
    assert scene.warnings == ("only 1.0 % of the pixels have a depth: the labels rest on little",)


def test_disparity_must_be_numbers_in_two_dimensions(box_pair: Pair) -> None:
    with pytest.raises(GeohueError, match=r"expected \(H, W\) numbers in pixels"):
        Scene.from_stereo(*box_pair[:2], disparity=box_pair.left)


def test_a_different_exposure_is_no_wrong_scale(box_pair: Pair) -> None:
    brighter = np.clip(box_pair.right.astype(int) + 25, 0, 255).astype(np.uint8)
    scene = Scene.from_stereo(box_pair.left, brighter, rig_of(box_pair), box_pair.disparity)
    assert scene.warnings == ()
