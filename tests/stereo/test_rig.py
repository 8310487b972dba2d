"""Disparity and depth, the fallback, rectification, and the rig in a mirror."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geohue.camera import Intrinsics
from geohue.errors import GeohueError
from geohue.stereo import StereoRig

CAMERA = Intrinsics(100.0, 100.0, 31.5, 23.5, 64, 48)


def test_depth_by_hand() -> None:
    """f b = 100 * 0.2 = 20: 5 px are 4 m, 10 px are 2 m."""
    depth = StereoRig(CAMERA, CAMERA, 0.2).depth(np.array([[5.0, 10.0, 0.0, -1.0, np.nan]]))
    np.testing.assert_array_equal(depth, np.array([[4.0, 2.0, np.nan, np.nan, np.nan]]))


def test_depth_with_doffs_by_hand() -> None:
    """With doffs = 5 a disparity of -1 is in front of the cameras: 20 / 4 = 5 m."""
    depth = StereoRig(CAMERA, CAMERA, 0.2, 5.0).depth(np.array([[5.0, 0.0, -1.0, -5.0]]))
    np.testing.assert_allclose(depth, [[2.0, 4.0, 5.0, np.nan]])


def test_doffs_come_from_the_principal_points() -> None:
    right = Intrinsics(100.0, 100.0, 36.5, 23.5, 64, 48)
    assert StereoRig(CAMERA, right, 0.2).offset == 5.0
    assert StereoRig(CAMERA, right, 0.2, 1.0).offset == 1.0


def test_middlebury_2006_by_hand() -> None:
    """Z = 3740 * 160 / (value + dmin) mm, whatever the size of the copy."""
    camera = Intrinsics(3740.0, 3740.0, 0.0, 0.0, None, 1110)
    full = StereoRig(camera, camera, 0.160, 270.0, centre_known=False)
    third = full.scaled_to(427, 370)
    assert third.left.fx == pytest.approx(3740 / 3)
    assert third.offset == pytest.approx(90)
    assert (third.left.cx, third.left.cy) == (213.0, 184.5)
    expected = 3.740 * 160 / (90 + 270)
    assert third.depth(np.array([[90 / 3]]))[0, 0] == pytest.approx(expected)


@given(st.floats(0.1, 200), st.floats(-20, 50), st.floats(0.01, 3), st.integers(1, 4))
def test_scaling_images_and_disparities_keeps_depth(
    disparity: float, doffs: float, baseline: float, factor: int
) -> None:
    rig = StereoRig(CAMERA, CAMERA, baseline, doffs)
    larger = rig.scaled_to(64 * factor, 48 * factor)
    small = rig.depth(np.array([[disparity]]))
    large = larger.depth(np.array([[disparity * factor]]))
    np.testing.assert_allclose(large, small, rtol=1e-4)


@given(st.floats(0.5, 200), st.floats(-0.4, 50))
def test_disparity_is_the_inverse_of_depth(disparity: float, doffs: float) -> None:
    rig = StereoRig(CAMERA, CAMERA, 0.3, doffs)
    depth = rig.depth(np.array([[disparity]]))
    np.testing.assert_allclose(rig.disparity(depth)[0, 0], disparity, rtol=1e-4, atol=1e-3)


def test_unknown_baseline_is_one() -> None:
    values = np.array([[4.0, 8.0]])
    one = StereoRig(CAMERA, CAMERA, 1.0).depth(values)
    np.testing.assert_array_equal(StereoRig(CAMERA, CAMERA).depth(values), one)


def test_fallback_says_what_it_assumes() -> None:
    rig = StereoRig.guess(640, 480)
    assert rig.baseline is None
    assert rig.offset == 0
    assert "no stereo calibration" in rig.warnings[0]
    assert "525 px" in rig.warnings[0]


def test_mirroring_twice_is_identity_and_keeps_doffs() -> None:
    right = Intrinsics(100.0, 100.0, 36.5, 23.5, 64, 48)
    rig = StereoRig(CAMERA, right, 0.2)
    mirrored = rig.mirrored(64)
    assert mirrored.offset == rig.offset
    assert mirrored.left.cx == 63 - 36.5
    back = mirrored.mirrored(64)
    assert (back.left, back.right) == (rig.left, rig.right)


@pytest.mark.parametrize(("baseline", "doffs"), [(0.0, None), (-1.0, None), (1.0, np.nan)])
def test_impossible_numbers_are_refused(baseline: float, doffs: float | None) -> None:
    with pytest.raises(GeohueError, match="must be"):
        StereoRig(CAMERA, CAMERA, baseline, doffs)


def test_wrong_shapes_are_refused() -> None:
    with pytest.raises(GeohueError, match=r"rotation of shape \(2, 2\)"):
        StereoRig(CAMERA, CAMERA, rotation=np.eye(2))


# --- rectification -------------------------------------------------------------------------------


def turned(angle: float = 0.03, shift: tuple[float, float, float] = (-0.1, 0.0, 0.0)) -> StereoRig:
    c, s = np.cos(angle), np.sin(angle)
    R = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    camera = Intrinsics(300.0, 300.0, 159.5, 119.5, 320, 240)
    return StereoRig(camera, camera, rotation=R, translation=np.array(shift))


def test_a_straight_rig_is_rectified_and_leaves_the_images() -> None:
    rig = StereoRig(CAMERA, CAMERA, 0.1)
    image = np.zeros((48, 64, 3), np.uint8)
    assert rig.is_rectified
    assert rig.rectify(image, image)[0] is image
    straight = StereoRig(CAMERA, CAMERA, rotation=np.eye(3), translation=np.array([-0.1, 0, 0]))
    assert straight.is_rectified
    assert straight.baseline == pytest.approx(0.1)


def test_distortion_or_rotation_or_another_focal_length_is_not_rectified() -> None:
    assert not turned().is_rectified
    assert not StereoRig(CAMERA, CAMERA, 0.1, left_distortion=(0.1, 0, 0, 0, 0)).is_rectified
    assert not StereoRig(CAMERA, Intrinsics(101.0, 101.0, 31.5, 23.5), 0.1).is_rectified


def test_points_land_in_one_row() -> None:
    """Project points with the raw rig; the rectified images have them in one row."""
    rig = turned()
    left = np.zeros((240, 320), np.uint8)
    right = np.zeros((240, 320), np.uint8)
    assert rig.rotation is not None
    assert rig.translation is not None
    points = np.array([[-0.2, 0.1, 2.0], [0.3, -0.2, 2.5], [0.1, 0.2, 1.5]])
    for image, place in ((left, points), (right, points @ rig.rotation.T + rig.translation)):
        for x, y, z in place:
            u, v = round(300 * x / z + 159.5), round(300 * y / z + 119.5)
            image[v - 2 : v + 3, u - 2 : u + 3] = 255
    turned_left, turned_right, new = rig.rectify(left, right)
    assert new.is_rectified
    assert new.baseline == pytest.approx(0.1)
    for image in (turned_left, turned_right):
        assert image.shape == left.shape
    rows = [np.flatnonzero(image.max(axis=1) > 100) for image in (turned_left, turned_right)]
    assert abs(rows[0].min() - rows[1].min()) <= 1
    assert abs(rows[0].max() - rows[1].max()) <= 1


def test_rectified_rig_without_images() -> None:
    image = np.zeros((240, 320), np.uint8)
    assert turned().rectified(320, 240).left == turned().rectify(image, image)[2].left


def test_without_r_and_t_there_is_no_rectification() -> None:
    rig = StereoRig(CAMERA, CAMERA, 0.1, left_distortion=(0.1, 0, 0, 0, 0))
    image = np.zeros((48, 64), np.uint8)
    with pytest.raises(GeohueError, match="no R and T"):
        rig.rectify(image, image)


def test_cameras_above_one_another_or_exchanged_are_named() -> None:
    image = np.zeros((240, 320), np.uint8)
    with pytest.raises(GeohueError, match="one above the other"):
        turned(shift=(0.0, -0.1, 0.0)).rectify(image, image)
    with pytest.raises(GeohueError, match="to the left"):
        turned(shift=(0.1, 0.0, 0.0)).rectify(image, image)
