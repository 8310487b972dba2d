from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray
from skimage.color import rgb2lab

from geohue import GeohueError, Scene
from geohue.features import Block, Features, extract_features, lab_of, normalized
from twins import features as twin


def random_scene(n: int = 200, seed: int = 0) -> Scene:
    rng = np.random.default_rng(seed)
    return Scene.from_cloud(
        rng.normal(size=(n, 3)) * [1, 2, 3], rng.integers(0, 256, (n, 3)).astype(np.uint8)
    )


def test_lab_is_within_half_a_unit_of_scikit_image() -> None:
    rgb = np.random.default_rng(0).integers(0, 256, (1, 5000, 3)).astype(np.uint8)
    assert np.abs(lab_of(rgb) - rgb2lab(rgb)).max() < 0.5


def test_grey_has_the_lightness_of_its_luminance() -> None:
    """255 is luminance 1, 188 is ((188/255 + 0.055) / 1.055)^2.4 = 0.5029: L = 116 Y^(1/3) - 16."""
    gray = np.array([[255] * 3, [188] * 3, [0] * 3], np.uint8)
    np.testing.assert_allclose(lab_of(gray)[:, 0], [100, 76.25, 0], atol=0.1)


def test_normalisation_by_hand() -> None:
    """Three points with standard deviations 1, 2 and 3 on the axes: divided by 2 (eq. 3)."""
    root = np.sqrt(1.5)
    points = root * np.array([[-1, -2, -3], [0, 0, 0], [1, 2, 3]])
    features = extract_features(Scene.from_cloud(points, np.zeros((3, 3))), "geometry")
    assert features.geometry[2] == pytest.approx(root * np.array([0.5, 1, 1.5]), rel=1e-6)
    assert not features.color.any()


def test_vectors_are_eq_5() -> None:
    features = extract_features(random_scene())
    assert features.color.std(axis=0).mean() == pytest.approx(1, abs=1e-5)
    assert features.geometry.std(axis=0).mean() == pytest.approx(1, abs=1e-5)
    vectors = features.vectors(2.0)
    assert np.array_equal(vectors[:, :3], features.color)
    assert np.array_equal(vectors[:, 3:], 2 * features.geometry)
    # `mixed` is the same up to one factor.
    assert np.allclose(features.mixed(2.0) * np.sqrt(5), vectors, atol=1e-5)


def test_mixed_at_the_ends_is_one_cue_alone() -> None:
    features = extract_features(random_scene())
    assert np.array_equal(features.mixed(0.0)[:, :3], features.color)
    assert not features.mixed(0.0)[:, 3:].any()
    assert np.allclose(features.mixed(np.inf)[:, 3:], features.geometry)
    assert np.abs(features.mixed(np.inf)[:, :3]).max() < 1e-6


def test_two_views_make_nine_dimensions() -> None:
    """Eq. 19: each view is normalised by its own deviations."""
    scene = random_scene()
    other = replace(scene, second_colors=(scene.colors // 2).astype(np.uint8))
    features = extract_features(other)
    assert features.vectors(1.0).shape == (200, 9)
    for view in (features.color[:, :3], features.color[:, 3:]):
        assert view.std(axis=0).mean() == pytest.approx(1, abs=1e-5)
    assert np.array_equal(features.color[:, :3], extract_features(scene).color)
    # The spread, and with it the meaning of the affinity scale, is that of one view.
    for weight in (0.0, 1.0, np.inf):
        one, two = (extract_features(s).mixed(weight) for s in (scene, other))
        assert (two**2).sum() == pytest.approx((one**2).sum(), rel=0.1)


@pytest.mark.parametrize("offset", [0, 1e4])
def test_a_cue_without_spread_is_zero_and_said_so(offset: float) -> None:
    scene = Scene.from_cloud(np.full((5, 3), offset + 0.1), np.full((5, 3), 90, np.uint8))
    features = extract_features(scene)
    assert not features.mixed(1.0).any()
    assert len(features.notes) == 2


@pytest.mark.parametrize(("step", "same"), [(1e-4, True), (6e-3, False)])
def test_a_spread_is_structure_from_a_millionth_on(step: float, same: bool) -> None:
    values = np.float32(1000) + np.float32(step) * np.resize([0, 1], (50, 3)).astype(np.float32)
    scaled, constant = normalized(values)
    assert values.std() > 0
    assert constant == same
    assert (not scaled.any()) == same


def test_missing_geometry_takes_no_part_unless_colour_alone_counts() -> None:
    depth = np.ones((4, 5))
    depth[0] = np.nan
    scene = Scene.from_rgbd(np.zeros((4, 5, 3), np.uint8), depth)
    assert len(extract_features(scene)) == 15
    assert len(extract_features(scene, "color")) == 20
    labels = extract_features(scene).to_scene(np.arange(15, dtype=np.int32))
    assert labels[0].tolist() == [-1] * 5
    assert labels[1].tolist() == [0, 1, 2, 3, 4]


def test_a_part_keeps_the_normalisation_of_the_whole() -> None:
    features = extract_features(random_scene())
    part = features.at(np.array([5, 3, 9]))
    assert np.array_equal(part.color, features.color[[5, 3, 9]])
    assert part.shape == (3,)


def test_no_geometry_at_all() -> None:
    scene = Scene.from_image(np.zeros((3, 3, 3), np.uint8))
    with pytest.raises(GeohueError, match='cues="color"'):
        extract_features(scene)
    with pytest.raises(GeohueError, match="fusion, color, geometry"):
        extract_features(scene, "depth")
    with pytest.raises(GeohueError, match="no points"):
        extract_features(Scene.from_cloud(np.zeros((0, 3)), np.zeros((0, 3))))


@given(
    hnp.arrays(
        np.float32, st.tuples(st.integers(1, 40), st.just(3)), elements=st.floats(-9, 9, width=32)
    ),
    st.sampled_from([0.0, 5.0, 1e4]),
)
@settings(deadline=None)
def test_normalisation_equals_its_twin(values: NDArray[np.float32], offset: float) -> None:
    points = (values + np.float32(offset)).astype(np.float32)
    scene = Scene(np.zeros(points.shape, np.uint8), points)
    expected, constant = twin.normalized(points)
    features = extract_features(scene, "geometry")
    np.testing.assert_allclose(features.geometry, expected, rtol=2e-6, atol=1e-6)
    assert len(features.notes) == constant


@given(st.sampled_from([0.0, 1 / 16, 1.0, 7.3]), st.sampled_from([1, 2]), st.integers(0, 9))
@settings(deadline=None)
def test_mixed_equals_its_twin(weight: float, views: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    color = rng.normal(size=(11, 3 * views)).astype(np.float32)
    geometry = rng.normal(size=(11, 3)).astype(np.float32)
    blocks = (
        *(Block("color", "color", color[:, 3 * v : 3 * v + 3]) for v in range(views)),
        Block("geometry", "geometry", geometry),
    )
    features = Features(blocks, np.arange(11), (11,), "fusion")
    expected = twin.mixed(color, geometry, weight)
    np.testing.assert_allclose(features.mixed(weight), expected, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("holes", [False, True])
def test_rows_go_back_to_their_places(holes: bool) -> None:
    depth = np.ones((4, 5)) + np.arange(5)
    depth[1, 2:4] = np.nan if holes else 1
    rgb = np.random.default_rng(0).integers(0, 256, (4, 5, 3)).astype(np.uint8)
    scene = Scene.from_rgbd(rgb, depth)
    features = extract_features(scene)
    assert np.array_equal(features.to_scene(features.index.astype(np.int32)) >= 0, scene.valid)
    every_other = np.arange(20).reshape(4, 5)[::2, ::2]
    part = features.at(every_other)
    rows = np.searchsorted(features.index, every_other.ravel()[part.index])
    assert np.array_equal(part.geometry, features.geometry[rows])
    assert np.array_equal(part.color, features.color[rows])
    assert np.array_equal(part.to_scene(part.index.astype(np.int32)) >= 0, scene.valid[::2, ::2])
