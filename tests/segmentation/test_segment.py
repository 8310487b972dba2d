"""The driver: what it finds, the laws it keeps, and what it says to bad input."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from geohue import PRESETS, GeohueError, Intrinsics, Scene, segment
from geohue.baselines import BASELINES
from geohue.features import CUES
from geohue.segmentation.clusterers import known_methods
from likeness import adjusted_rand_score

LIGHT = PRESETS["paper"].changed(landmarks=60, draft_points=2000)
law = settings(
    deadline=None, max_examples=8, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def agreement(a: NDArray[np.int32], b: NDArray[np.int32]) -> float:
    return float(adjusted_rand_score(a.ravel(), b.ravel()))


def parts_cloud(seed: int, n: int = 900, k: int = 3) -> tuple[Scene, NDArray[np.int32]]:
    """Groups that lie apart in space and differ in colour."""
    rng = np.random.default_rng(seed)
    truth = np.arange(n) % k
    centers = np.array([[0, 0, 0], [4, 0, 1], [0, 5, 2]])
    hues = np.array([[220, 40, 40], [40, 200, 60], [50, 60, 230]])
    points = centers[truth] + rng.normal(0, 0.35, (n, 3))
    colors = np.clip(hues[truth] + rng.normal(0, 9, (n, 3)), 0, 255).astype(np.uint8)
    return Scene.from_cloud(points, colors), truth.astype(np.int32)


class TestFinds:
    def test_parts_that_only_both_cues_tell_apart(
        self, three_boxes: tuple[Scene, NDArray[np.int32]]
    ) -> None:
        scene, truth = three_boxes
        fusion = segment(scene, k=3)
        assert agreement(fusion.labels, truth) > 0.99
        assert agreement(segment(scene, k=3, cues="color").labels, truth) < 0.8
        assert agreement(segment(scene, k=3, cues="geometry").labels, truth) < 0.8
        assert fusion.quality is not None
        assert 0 < fusion.weight < np.inf

    @pytest.mark.parametrize("preset", list(PRESETS))
    def test_parts_of_a_cloud_with_every_preset(self, preset: str) -> None:
        scene, truth = parts_cloud(0)
        result = segment(scene, preset=preset)
        assert result.k == 3
        assert agreement(result.labels, truth) == 1

    def test_one_segment_where_there_is_nothing_to_split(self) -> None:
        rng = np.random.default_rng(0)
        noise = rng.normal(128, 3, (60, 80, 3)).astype(np.uint8)
        wall = Scene.from_rgbd(noise, 2 + 0.002 * rng.normal(size=(60, 80)))
        result = segment(wall)
        assert (result.k, result.quality, result.weight_curve) == (1, None, [])
        assert "one segment" in result.warnings[-1]

    def test_every_pixel_gets_a_label_and_the_largest_is_0(
        self, three_boxes: tuple[Scene, NDArray[np.int32]]
    ) -> None:
        scene, truth = three_boxes
        assert scene.depth is not None
        holes = scene.depth.copy()
        holes[10:30, 20:50] = np.nan
        holed = Scene.from_rgbd(scene.colors, holes)
        result = segment(holed, k=3)
        assert result.n_labelled == result.n_points == truth.size
        sizes = np.bincount(result.labels.ravel())
        assert (np.diff(sizes) <= 0).all()
        open_result = segment(holed, k=3, fill=False)
        assert np.array_equal(open_result.labels < 0, np.isnan(holes))
        assert agreement(result.labels, truth) > 0.95

    def test_components(self) -> None:
        rgb = np.zeros((40, 60, 3), np.uint8)
        rgb[:, 20:40] = 255
        scene = Scene.from_rgbd(rgb, np.ones((40, 60)))
        assert segment(scene, k=2, weight=0.01).k == 2
        assert segment(scene, k=2, weight=0.01, components=True).k == 3

    def test_constant_colour_falls_to_geometry_and_says_so(self) -> None:
        scene, truth = parts_cloud(1)
        grey = Scene.from_cloud(scene.points, np.full(scene.points.shape, 80, np.uint8))
        result = segment(grey, k=3)
        assert agreement(result.labels, truth) == 1
        assert any("colours are equal" in note for note in result.warnings)

    def test_constant_depth_is_a_wall_with_colours(self) -> None:
        rgb = np.zeros((40, 60, 3), np.uint8)
        rgb[:, 30:] = (200, 60, 40)
        result = segment(Scene.from_rgbd(rgb, np.full((40, 60), 2.0)), k=2)
        assert result.labels[0, ::15].tolist() == [0, 0, 1, 1]

    def test_one_point_and_one_value(self) -> None:
        one = segment(Scene.from_cloud(np.zeros((1, 3)), np.zeros((1, 3))))
        assert one.labels.tolist() == [0]
        same = segment(Scene.from_cloud(np.ones((9, 3)), np.zeros((9, 3))), k=3)
        assert same.k == 1
        assert "1 segment(s) instead of 3" in same.warnings[-1]

    def test_as_many_segments_as_points(self) -> None:
        scene, _ = parts_cloud(2, n=3)
        assert sorted(segment(scene, k=3).labels.tolist()) == [0, 1, 2]

    def test_missing_points_of_a_cloud_have_no_label(self) -> None:
        scene, _ = parts_cloud(3)
        points = scene.points.copy()
        points[::7] = np.nan
        labels = segment(Scene.from_cloud(points, scene.colors), k=3).labels
        assert np.array_equal(labels < 0, np.isnan(points[:, 0]))


class TestMethods:
    @pytest.mark.parametrize("method", known_methods())
    def test_every_method_gives_the_same_kind_of_result(
        self, method: str, three_boxes: tuple[Scene, NDArray[np.int32]]
    ) -> None:
        scene, truth = three_boxes
        cues = BASELINES[method].cues if method in BASELINES else CUES
        for cue in cues:
            result = segment(scene, 3, cues=cue, method=method, preset="fast")
            assert (result.method, result.n_labelled) == (method, truth.size)
            assert set(np.unique(result.labels)) == set(range(result.k))
            again = segment(scene, 3, cues=cue, method=method, preset="fast", threads=1)
            assert np.array_equal(result.labels, again.labels)

    @pytest.mark.parametrize("method", ["nncsc", "kmeans", "felzenszwalb"])
    def test_fusion_finds_the_three_boxes(
        self, method: str, three_boxes: tuple[Scene, NDArray[np.int32]]
    ) -> None:
        scene, truth = three_boxes
        assert agreement(segment(scene, 3, method=method).labels, truth) > 0.9

    def test_cues_and_scenes_that_a_method_is_not_defined_for(
        self, three_boxes: tuple[Scene, NDArray[np.int32]]
    ) -> None:
        with pytest.raises(GeohueError, match="choose 'color' or 'geometry'"):
            segment(three_boxes[0], 3, method="edison")
        cloud, _ = parts_cloud(0, 30)
        with pytest.raises(GeohueError, match="needs a grid"):
            segment(cloud, 3, method="bleiweiss-werman")

    def test_clouds_too(self) -> None:
        scene, truth = parts_cloud(4, 300)
        for method in ("kmeans", "meanshift", "felzenszwalb"):
            assert agreement(segment(scene, 3, method=method).labels, truth) > 0.9


class TestLaws:
    @given(st.floats(1e-3, 1e3), st.integers(0, 99))
    @law
    def test_scale_and_pose_of_the_geometry_change_nothing(self, scale: float, seed: int) -> None:
        scene, _ = parts_cloud(seed)
        turn = Rotation.random(rng=np.random.default_rng(seed))
        moved = scale * (turn.apply(scene.points.astype(float)) + np.array([3, -2, 7]))
        one = segment(scene, 3, 1.5, LIGHT)
        two = segment(Scene.from_cloud(moved, scene.colors), 3, 1.5, LIGHT)
        assert np.array_equal(one.labels, two.labels)

    @given(st.integers(0, 99))
    @law
    def test_permuting_points_permutes_labels(self, seed: int) -> None:
        scene, _ = parts_cloud(seed)
        order = np.random.default_rng(seed).permutation(scene.size)
        one = segment(scene, 3, preset=LIGHT)
        two = segment(Scene.from_cloud(scene.points[order], scene.colors[order]), 3, preset=LIGHT)
        assert one.weight == two.weight
        assert agreement(one.labels[order], two.labels) == 1

    def test_small_weight_is_colour_alone_and_large_is_geometry_alone(
        self, three_boxes: tuple[Scene, NDArray[np.int32]]
    ) -> None:
        scene, _ = three_boxes
        for weight, near, cues in ((0.0, 1e-6, "color"), (np.inf, 1e6, "geometry")):
            alone = segment(scene, 2, cues=cues, preset=LIGHT)
            assert alone.weight == weight
            assert np.array_equal(alone.labels, segment(scene, 2, weight, LIGHT).labels)
            assert agreement(alone.labels, segment(scene, 2, near, LIGHT).labels) > 0.999

    @given(st.integers(0, 2**31))
    @law
    def test_same_seed_same_labels_at_any_number_of_threads(self, seed: int) -> None:
        rng = np.random.default_rng(seed % 5)
        rgb = np.kron(rng.integers(0, 255, (6, 8, 3)), np.ones((15, 15, 1))).astype(np.uint8)
        depth = np.kron(rng.uniform(1, 3, (3, 4)), np.ones((30, 30)))
        scene = Scene.from_rgbd(rgb, depth + 0.01 * rng.random(depth.shape))
        runs = [segment(scene, seed=seed, preset=LIGHT, threads=n) for n in (1, 2, 4, 1)]
        for run in runs[1:]:
            assert np.array_equal(run.labels, runs[0].labels)
            assert run.weight_curve == runs[0].weight_curve
            assert (run.k, run.weight, run.quality) == (
                runs[0].k,
                runs[0].weight,
                runs[0].quality,
            )

    def test_a_finer_search_finds_the_same_scene(
        self, three_boxes: tuple[Scene, NDArray[np.int32]]
    ) -> None:
        scene, truth = three_boxes
        fine = PRESETS["paper"].changed(weights=tuple(2.0 ** (e / 4) for e in range(-16, 17)))
        one, two = segment(scene, 3, preset="paper"), segment(scene, 3, preset=fine)
        assert agreement(one.labels, two.labels) > 0.99
        assert max(q for _, q in two.weight_curve) - max(q for _, q in one.weight_curve) < 0.02


class TestBadInput:
    @pytest.mark.parametrize("k", [0, -1, 256, 2.5, "many", True])
    def test_k(self, k: object) -> None:
        scene, _ = parts_cloud(0, 30)
        with pytest.raises(GeohueError, match=r"k is .*1 to 255"):
            segment(scene, k)  # type: ignore[arg-type]

    @pytest.mark.parametrize("weight", [-1.0, np.nan, "heavy"])
    def test_weight(self, weight: object) -> None:
        scene, _ = parts_cloud(0, 30)
        with pytest.raises(GeohueError, match=r"weight is .*at least 0"):
            segment(scene, 2, weight)  # type: ignore[arg-type]

    @pytest.mark.parametrize(
        ("option", "message"),
        [
            ({"preset": "quick"}, "paper, fast, best"),
            ({"cues": "depth"}, "fusion, color, geometry"),
            ({"method": "watershed"}, "nncsc"),
            ({"seed": -1}, "seed is -1"),
            ({"seed": 0.5}, r"seed is 0\.5"),
            ({"threads": 0}, "threads is 0"),
            ({"components": True}, "cloud without"),
        ],
    )
    def test_options(self, option: dict[str, object], message: str) -> None:
        scene, _ = parts_cloud(0, 30)
        with pytest.raises(GeohueError, match=message):
            segment(scene, 2, **option)  # type: ignore[arg-type]

    def test_fewer_points_than_segments(self) -> None:
        scene, _ = parts_cloud(0, 3)
        with pytest.raises(GeohueError, match=r"3 usable point\(s\) cannot form 4"):
            segment(scene, 4)

    def test_all_depth_missing(self) -> None:
        rgb = np.random.default_rng(0).integers(0, 255, (20, 20, 3)).astype(np.uint8)
        scene = Scene.from_rgbd(rgb, np.full((20, 20), np.nan), Intrinsics.guess(20, 20))
        with pytest.raises(GeohueError, match="all depth is missing"):
            segment(scene)
        assert segment(scene, 2, cues="color").n_labelled == 400


@given(st.integers(0, 2**20), st.integers(1, 6))
@settings(deadline=None, max_examples=25)
def test_strange_scenes_never_give_nan_or_stray_labels(seed: int, k: int) -> None:
    rng = np.random.default_rng(seed)
    h, w = rng.integers(1, 24, 2)
    rgb = rng.integers(0, rng.choice([2, 256]), (h, w, 3)).astype(np.uint8)
    depth = rng.choice([0.0, np.nan, np.inf, 1.0, 1e-30, 1e30, 2.0], (h, w))
    scene = Scene.from_rgbd(rgb, depth)
    try:
        result = segment(scene, k, preset=LIGHT)
    except GeohueError:
        assert scene.valid.sum() < k
        return
    assert result.labels.min() >= 0
    assert set(np.unique(result.labels)) == set(range(result.k))
    assert result.k <= k
    assert result.quality is None or np.isfinite(result.quality)
    assert all(np.isfinite(q) for _, q in result.weight_curve)


def test_the_function_stays_a_function_whatever_is_imported() -> None:
    import geohue
    import geohue.segmentation.driver
    import geohue.studies.benchmark.trials

    assert callable(geohue.segment)
