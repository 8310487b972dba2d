from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

from geohue import PRESETS, Scene, segment
from geohue.compute.parallel import Workers, workers
from geohue.settings.weight import HALF_OCTAVES
from geohue.weight.agreement import BorderContrast, weight_by_agreement
from geohue.weight.likeness import distances
from twins import agreement as twin

ALONE = Workers(None)


def stripes() -> Scene:
    """Black, black, white, white columns on a wall."""
    rgb = np.zeros((4, 4, 3), np.uint8)
    rgb[:, 2:] = 255
    return Scene.from_rgbd(rgb, np.ones((4, 4)))


class TestContrast:
    def test_by_hand(self) -> None:
        """Lab steps: 100 across the middle, 0 elsewhere; 12 horizontal and 12 vertical pairs."""
        contrast = BorderContrast(stripes())
        middle = np.repeat([[0, 0, 1, 1]], 4, 0).astype(np.int32)
        assert contrast(middle) == pytest.approx(100 / (4 * 100 / 24), rel=1e-4)
        beside = np.repeat([[0, 1, 1, 1]], 4, 0).astype(np.int32)
        assert contrast(beside) == 0
        assert np.isnan(contrast(np.zeros((4, 4), np.int32)))

    def test_missing_labels_and_missing_depth_have_no_border(self) -> None:
        labels = np.repeat([[0, 0, -1, -1]], 4, 0).astype(np.int32)
        assert np.isnan(BorderContrast(stripes())(labels))
        depth = np.ones((4, 4))
        depth[:, 1] = np.nan
        holed = Scene.from_rgbd(stripes().colors, depth)
        beside = np.repeat([[0, 1, 1, 1]], 4, 0).astype(np.int32)
        assert np.isnan(BorderContrast(holed)(beside))

    def test_clouds_go_by_their_nearest_points(self) -> None:
        rng = np.random.default_rng(0)
        points = rng.uniform(0, 1, (400, 3))
        colors = np.where(points[:, :1] < 0.5, 20, 220).repeat(3, 1).astype(np.uint8)
        contrast = BorderContrast(Scene.from_cloud(points, colors))
        along = contrast((points[:, 0] < 0.5).astype(np.int32))
        across = contrast((points[:, 1] < 0.5).astype(np.int32))
        assert along > 3 * across

    @given(st.integers(0, 2**20), st.sampled_from([0.0, 0.3]), st.booleans())
    @settings(deadline=None, max_examples=60)
    def test_equals_its_twin(self, seed: int, missing: float, wide: bool) -> None:
        rng = np.random.default_rng(seed)
        rgb = rng.integers(0, 256, (7, 9, 3)).astype(np.uint8)
        depth = rng.uniform(1, 2, (7, 9))
        depth[rng.random((7, 9)) < missing] = np.nan
        scene = Scene.from_rgbd(rgb, depth)
        labels = rng.integers(-1, 3, (7, 9)).astype(np.int32)
        # Any memory layout and integer type will do.
        asked: Any = np.asfortranarray(labels).astype(np.int64) if wide else labels
        expected = twin.contrast(scene, labels)
        assert BorderContrast(scene)(asked) == pytest.approx(expected, nan_ok=True)


@given(
    hnp.arrays(
        np.int32, st.tuples(st.integers(1, 5), st.integers(1, 40)), elements=st.integers(-1, 6)
    ),
    st.sampled_from([1, 9]),
)
@settings(deadline=None, max_examples=150)
def test_distances_equal_their_twin(maps: NDArray[np.int32], spread: int) -> None:
    """Also with labels that leave gaps, points without a label, and maps without common points."""
    spaced = list(np.where(maps < 0, -1, maps * spread).astype(np.int32))
    found, expected = distances(spaced), twin.distances(spaced)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)


def test_distance_by_hand() -> None:
    """Halves against quarters: one bit; the same parts under other names: none."""
    halves = np.array([0, 0, 0, 0, 1, 1, 1, 1, -1], np.int32)
    quarters = np.array([0, 0, 1, 1, 2, 2, 3, 3, 0], np.int32)
    named = np.array([5, 5, 5, 5, 2, 2, 2, 2, -1], np.int32)
    expected = [[0, 1, 0], [1, 0, 1], [0, 1, 0]]
    np.testing.assert_allclose(distances([halves, quarters, named]), expected, atol=1e-12)


class TestRule:
    def test_the_odd_one_out_loses(self) -> None:
        good = np.repeat([[0, 0, 1, 1]], 4, 0).astype(np.int32)
        odd = np.repeat([[0, 1, 1, 1]], 4, 0).astype(np.int32)
        weights = (0.5, 1.0, 2.0, 4.0)
        weight, maps = weight_by_agreement(
            lambda x: odd if x == 1 else good, stripes(), ALONE, weights
        )
        assert weight == 4.0  # its only neighbour agrees; 0.5 stands beside the odd one
        assert len(maps) == 4

    def test_weights_without_two_segments_are_left_out(self) -> None:
        good = np.repeat([[0, 0, 1, 1]], 4, 0).astype(np.int32)
        weight, _ = weight_by_agreement(
            lambda x: good if x == 2 else np.zeros_like(good), stripes(), ALONE, (1.0, 2.0)
        )
        assert weight == 2.0
        none, _ = weight_by_agreement(lambda _: np.zeros_like(good), stripes(), ALONE)
        assert none == 1.0

    def test_equal_weights_take_the_one_nearest_to_1(self) -> None:
        good = np.repeat([[0, 0, 1, 1]], 4, 0).astype(np.int32)
        assert weight_by_agreement(lambda _: good, stripes(), ALONE)[0] == 1.0

    def test_threads_change_nothing(self, three_boxes: tuple[Scene, NDArray[np.int32]]) -> None:
        scene, truth = three_boxes
        with workers(3) as team:
            one = weight_by_agreement(lambda x: np.roll(truth, int(4 * x), 1), scene, team)
        assert (
            one[0] == weight_by_agreement(lambda x: np.roll(truth, int(4 * x), 1), scene, ALONE)[0]
        )


def test_in_the_driver(three_boxes: tuple[Scene, NDArray[np.int32]]) -> None:
    scene, _ = three_boxes
    result = segment(scene, 3, "agreement")
    assert result.weight in HALF_OCTAVES
    assert [w for w, _ in result.weight_curve] == list(HALF_OCTAVES)
    quick = segment(scene, 3, "agreement", "fast")
    assert [w for w, _ in quick.weight_curve] == list(PRESETS["fast"].weight.compared)
    assert PRESETS["best"].weight.rule == PRESETS["fast"].weight.rule == "merge"
    assert PRESETS["paper"].weight.rule == "quality"
    assert segment(scene, 3, "quality", "fast").weight_curve != quick.weight_curve


def test_finds_objects_where_q_cuts_the_table(data_dir: object) -> None:
    """On a plain table Q prefers pieces of it; agreement frees the boxes."""
    from pathlib import Path

    import cv2

    from geohue.measures import evaluate
    from geohue.read.scenes.scenes import read_scene

    folder = Path(str(data_dir)) / "mosd" / "frames" / "learn3"
    scene = read_scene(folder / "rgb.png", folder / "depth.png", folder / "intrinsics.json")
    truth = cv2.imread(str(folder / "labels_object.png"), cv2.IMREAD_UNCHANGED)
    assert truth is not None
    scores = [
        evaluate(segment(scene, 6, rule).labels, truth.astype(np.int32))["voi_bits"]
        for rule in ("quality", "agreement")
    ]
    assert scores[1] < scores[0] - 0.3
