"""Q by hand (eq. 6-17), and against a literal twin."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue import GeohueError, Scene
from geohue.weight.quality import QualityMetric, _window_deviation, _window_interior
from twins.quality import literal_quality, window_deviation, window_interior


def frame(rgb: NDArray[np.uint8], depth: NDArray[np.floating]) -> Scene:
    return Scene.from_rgbd(rgb, depth)


def test_two_flat_halves() -> None:
    """No deviation inside; colour means 1 apart in 3 channels, depth means 1 apart."""
    rgb = np.zeros((4, 6, 3), np.uint8)
    rgb[:, 3:] = 255
    depth = np.where(np.arange(6) < 3, 2.0, 5.0)[None].repeat(4, 0)
    quality = QualityMetric(frame(rgb, depth))((depth > 3).astype(np.int32))
    assert quality is not None
    assert (quality.color_inter, quality.color_intra) == (3, 0)  # eq. 10, 8
    assert (quality.geometry_inter, quality.geometry_intra) == (1, 0)  # eq. 15, 13
    assert quality.total == 3 / 2 + 3 * 1 / 2  # eq. 17 with n_f = 3


def test_deviation_and_texture_of_one_pixel_dots() -> None:
    """One red dot in a 5 x 5 black square, beside a 5 x 5 black square: eq. 6 and 7 by hand."""
    rgb = np.zeros((5, 10, 3), np.uint8)
    rgb[2, 2, 0] = 255
    depth = np.ones((5, 10))
    depth[:, 5:] = 2
    labels = (depth > 1).astype(np.int32)
    quality = QualityMetric(frame(rgb, depth))(labels)
    assert quality is not None
    sigma = np.sqrt(1 / 25 - 1 / 25**2)  # red over the segment
    window = np.sqrt(1 / 9 - 1 / 81)  # red in any 3 x 3 window that holds the dot
    # All 9 interior pixels of the left square see the dot.
    assert quality.color_intra == pytest.approx(max(sigma - window, 0) / 2, abs=1e-6)
    without = QualityMetric(frame(rgb, depth), texture="off")(labels)
    assert without is not None
    assert without.color_intra == pytest.approx(sigma / 2, abs=1e-6)
    assert without.color_inter == pytest.approx(1 / 25, abs=1e-6)


def test_a_cloud_weighs_geometry_once_and_scales_by_the_longest_side() -> None:
    points = np.array([[0, 0, 0], [0, 0, 0], [4, 2, 0], [4, 2, 0]], float)
    colors = np.array([[0, 0, 0]] * 2 + [[255, 0, 0]] * 2, np.uint8)
    quality = QualityMetric(Scene.from_cloud(points, colors))(np.array([0, 0, 1, 1], np.int32))
    assert quality is not None
    assert quality.color == 1 / 2
    assert quality.geometry == pytest.approx((1 + 0.5) / 2)  # x by 4/4, y by 2/4
    assert quality.total == pytest.approx(1 / 2 + 3 / 4)  # n_f = 1


def test_euclidean_norm() -> None:
    points = np.array([[0, 0, 0], [3, 4, 0]], float)
    scene = Scene.from_cloud(points, np.zeros((2, 3), np.uint8))
    quality = QualityMetric(scene, norm="euclidean")(np.array([0, 1], np.int32))
    assert quality is not None
    assert quality.geometry_inter == pytest.approx(5 / 4)


@pytest.mark.parametrize("labels", [[0, 0, 0], [-1, -1, -1], [2, 2, -1]])
def test_is_undefined_for_fewer_than_two_segments(labels: list[int]) -> None:
    scene = Scene.from_cloud(np.eye(3), np.zeros((3, 3), np.uint8))
    assert QualityMetric(scene)(np.array(labels, np.int32)) is None


def test_a_thin_segment_has_no_texture_and_no_nan() -> None:
    rgb = np.random.default_rng(0).integers(0, 255, (6, 6, 3)).astype(np.uint8)
    labels = np.zeros((6, 6), np.int32)
    labels[3] = 1  # one row: no 3 x 3 window fits
    quality = QualityMetric(frame(rgb, np.ones((6, 6))))(labels)
    assert quality is not None
    assert np.isfinite(quality.total)


@st.composite
def small_scenes(
    draw: st.DrawFn,
) -> tuple[NDArray[np.uint8], NDArray[np.float64], NDArray[np.int32]]:
    rng = np.random.default_rng(draw(st.integers(0, 2**20)))
    h, w = draw(st.integers(3, 9)), draw(st.integers(3, 9))
    rgb = rng.integers(0, 256, (h, w, 3)).astype(np.uint8)
    depth = rng.uniform(0.5, 4, (h, w))
    depth[rng.random((h, w)) < draw(st.sampled_from([0.0, 0.2]))] = np.nan
    blocks = rng.integers(-1, 4, (3, 3))
    labels = blocks[np.arange(h)[:, None] * 3 // h, np.arange(w)[None] * 3 // w].astype(np.int32)
    return rgb, depth, labels


@given(small_scenes(), st.sampled_from(["window", "off"]), st.sampled_from(["sum", "euclidean"]))
@settings(deadline=None, max_examples=80)
def test_equals_the_literal_twin(
    scene: tuple[NDArray[np.uint8], NDArray[np.float64], NDArray[np.int32]],
    texture: str,
    norm: str,
) -> None:
    rgb, depth, labels = scene
    fast = QualityMetric(frame(rgb, depth), texture, norm)(labels)  # type: ignore[arg-type]
    slow = literal_quality(rgb, depth, labels, texture == "window", norm)
    assert (fast is None) == (slow is None)
    if fast is not None and slow is not None:
        assert fast.total == pytest.approx(slow, abs=2e-5)


@given(small_scenes(), st.booleans())
@settings(deadline=None, max_examples=40)
def test_a_cloud_equals_the_literal_twin(
    scene: tuple[NDArray[np.uint8], NDArray[np.float64], NDArray[np.int32]], holes: bool
) -> None:
    """A cloud whose points differ in z only: the geometry of eq. 17 counts once."""
    rgb, depth, labels = scene
    depth = depth if holes else np.nan_to_num(depth, nan=1.0)
    points = np.stack([0 * depth, 0 * depth, depth], axis=-1).reshape(-1, 3)
    cloud = Scene.from_cloud(points, rgb.reshape(-1, 3))
    fast = QualityMetric(cloud)(labels.reshape(-1))
    slow = literal_quality(rgb, depth, labels, False, "sum")
    assert (fast is None) == (slow is None)
    if fast is not None and slow is not None:
        assert fast.color + 3 * fast.geometry == pytest.approx(slow, abs=2e-5)


@given(small_scenes(), st.sampled_from(["sum", "euclidean"]))
@settings(deadline=None, max_examples=60)
def test_windows_equal_their_twins(
    scene: tuple[NDArray[np.uint8], NDArray[np.float64], NDArray[np.int32]], norm: str
) -> None:
    rgb, _, labels = scene
    inside = np.s_[1:-1, 1:-1]
    local = _window_deviation(rgb, norm)  # type: ignore[arg-type]
    np.testing.assert_allclose(local[inside], window_deviation(rgb, norm)[inside], atol=1e-6)
    assert np.array_equal(_window_interior(labels), window_interior(labels))


@pytest.mark.parametrize("shape", [(1, 4), (4, 2), (2, 2)])
def test_a_frame_without_room_for_a_window(shape: tuple[int, int]) -> None:
    labels = np.arange(shape[0] * shape[1], dtype=np.int32).reshape(shape) % 2
    rgb = np.full((*shape, 3), 9, np.uint8)
    quality = QualityMetric(frame(rgb, labels + 1.0))(labels)
    assert quality is not None
    assert (quality.color, quality.geometry) == (0, 0.5)


def test_one_colour_and_one_depth_deviate_by_nothing() -> None:
    """Sums of squares must not leave a trace: 0.7 has no exact binary form."""
    rgb, depth = np.full((60, 80, 3), 179, np.uint8), np.full((60, 80), 0.7)
    labels = (np.arange(80) >= 40)[None].repeat(60, 0).astype(np.int32)
    rgb[:, 40:], depth[:, 40:] = 13, 2.2
    depth[0, 0], labels[0, 0] = 0.1, 2  # the nearest point is a segment of its own
    quality = QualityMetric(frame(rgb, depth))(labels)
    assert quality is not None
    assert quality.color_intra == 0
    assert quality.geometry_intra < 1e-12


@given(small_scenes(), st.permutations(range(4)))
@settings(deadline=None, max_examples=40)
def test_names_of_segments_do_not_matter(
    scene: tuple[NDArray[np.uint8], NDArray[np.float64], NDArray[np.int32]], order: list[int]
) -> None:
    rgb, depth, labels = scene
    metric = QualityMetric(frame(rgb, depth))
    one, two = metric(labels), metric(np.append(order, -1)[labels].astype(np.int32))
    assert (one is None) == (two is None)
    if one is not None and two is not None:
        assert one.total == pytest.approx(two.total, abs=1e-9)


def test_scale_of_the_scene_does_not_matter() -> None:
    rng = np.random.default_rng(2)
    points, colors = rng.normal(size=(50, 3)), rng.integers(0, 255, (50, 3)).astype(np.uint8)
    labels = (points[:, 0] > 0).astype(np.int32)
    values = [
        QualityMetric(Scene.from_cloud(points * s + t, colors))(labels)
        for s, t in ((1, 0), (1000, 0), (0.01, 5))
    ]
    totals = [value.total for value in values if value is not None]
    assert totals == pytest.approx([totals[0]] * 3, abs=1e-4)


def test_labels_of_another_shape_are_refused() -> None:
    scene = Scene.from_cloud(np.eye(3), np.zeros((3, 3), np.uint8))
    with pytest.raises(GeohueError, match=r"shape \(2,\); expected \(3,\)"):
        QualityMetric(scene)(np.zeros(2, np.int32))


def test_bad_options() -> None:
    scene = Scene.from_cloud(np.eye(3), np.zeros((3, 3), np.uint8))
    with pytest.raises(GeohueError, match="needs a grid"):
        QualityMetric(scene, "window")
    with pytest.raises(GeohueError, match="auto, window, off"):
        QualityMetric(scene, "wide")  # type: ignore[arg-type]
    with pytest.raises(GeohueError, match="sum, euclidean"):
        QualityMetric(scene, norm="max")  # type: ignore[arg-type]
