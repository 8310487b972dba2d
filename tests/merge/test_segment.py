"""`segment` with the presets that merge: its laws."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from geohue import PRESETS, GeohueError, Scene, Segmentation, segment
from geohue.merge.score import Cues
from likeness import adjusted_rand_score

LIGHT = PRESETS["fast"].changed(landmarks=40, draft_points=1200)
law = settings(deadline=None, max_examples=6)
Labels = NDArray[np.int32]


def alike(one: Labels, two: Labels) -> float:
    return float(adjusted_rand_score(one.ravel(), two.ravel()))


def room(seed: int, n: int = 1500) -> Scene:
    """Two walls and a floor of slightly different colour, and a ball on the floor."""
    rng = np.random.default_rng(seed)
    u, v = rng.uniform(0, 3, (2, n))
    out = rng.normal(size=(n, 3))
    ball = 0.5 * out / np.linalg.norm(out, axis=1, keepdims=True) + [1.5, 1.5, 0.6]
    faces = [np.c_[u, v, 0 * u], np.c_[0 * u, u, v], np.c_[u, 0 * u, v], ball]
    part = np.arange(n) % 4
    points = np.choose(part[:, None], faces) + rng.normal(0, 0.005, (n, 3))
    hues = np.array([[150, 120, 90], [170, 170, 160], [140, 150, 170], [60, 140, 200]])
    colors = np.clip(hues[part] + rng.normal(0, 6, (n, 3)), 0, 255).astype(np.uint8)
    return Scene.from_cloud(points, colors)


def frame(seed: int, shape: tuple[int, int] = (48, 64)) -> Scene:
    """Patches of colour on steps and slopes, with gaps in the depth."""
    rng = np.random.default_rng(seed)
    rgb = np.kron(rng.integers(0, 255, (3, 4, 3)), np.ones((16, 16, 1)))[: shape[0], : shape[1]]
    depth = np.kron(rng.uniform(1, 3, (2, 2)), np.ones((24, 32)))[: shape[0], : shape[1]]
    depth = depth + 0.004 * np.arange(shape[1]) + rng.normal(0, 0.003, shape)
    depth[rng.random(shape) < 0.05] = np.nan
    noisy = np.clip(rgb + rng.normal(0, 5, rgb.shape), 0, 255)
    return Scene.from_rgbd(noisy.astype(np.uint8), depth)


def same(one: Segmentation, two: Segmentation) -> bool:
    assert one.levels is not None
    assert two.levels is not None
    return (
        np.array_equal(one.labels, two.labels)
        and np.array_equal(one.levels.regions, two.levels.regions)
        and np.array_equal(one.levels.tree.merges, two.levels.tree.merges)
        and np.array_equal(one.levels.tree.scores, two.levels.tree.scores)
        and (one.k, one.weight, one.quality) == (two.k, two.weight, two.quality)
    )


class TestDeterminism:
    @pytest.mark.parametrize("preset", ["fast", "best"])
    @pytest.mark.parametrize("make", [room, frame])
    def test_same_seed_same_labels_at_any_number_of_threads(
        self, make: Callable[[int], Scene], preset: str
    ) -> None:
        scene = make(0)
        runs = [segment(scene, preset=preset, seed=3, threads=n) for n in (1, 2, 8, 1)]
        assert runs[0].k > 1
        assert all(same(runs[0], run) for run in runs[1:])

    def test_another_seed_finds_about_the_same(self) -> None:
        one, two = (segment(room(0), preset="best", seed=seed) for seed in (0, 1))
        assert alike(one.labels, two.labels) > 0.95


class TestCloudLaws:
    @given(st.integers(0, 99), st.sampled_from([1e-30, 1e-4, 0.3, 7.0, 1e5, 1e30]))
    @law
    def test_scale_and_place(self, seed: int, scale: float) -> None:
        scene = room(seed)
        one = segment(scene, preset=LIGHT)
        moved = scale * (scene.points.astype(float) + np.array([3, -2, 7]))
        two = segment(Scene.from_cloud(moved, scene.colors), preset=LIGHT)
        assert one.k > 1
        assert alike(one.labels, two.labels) > 0.99  # float32 moves points by a few ulp

    @given(st.integers(0, 99))
    @law
    def test_pose(self, seed: int) -> None:
        """But for distances that are equal up to rounding, of which a draft takes one or other."""
        scene = room(seed)
        turn = Rotation.random(rng=np.random.default_rng(seed))
        turned = Scene.from_cloud(turn.apply(scene.points.astype(float)), scene.colors)
        one, two = (segment(s, preset=LIGHT.changed(draft_points=1500)) for s in (scene, turned))
        assert alike(one.labels, two.labels) > 0.85  # the least seen is 0.90

    @given(st.integers(0, 99))
    @law
    def test_a_power_of_two_changes_nothing_at_all(self, seed: int) -> None:
        scene = room(seed)
        large = Scene.from_cloud(scene.points * 2.0**9, scene.colors)
        one, two = segment(scene, preset=LIGHT), segment(large, preset=LIGHT)
        assert np.array_equal(one.labels, two.labels)

    @given(st.integers(0, 99))
    @law
    def test_permuting_points_permutes_labels(self, seed: int) -> None:
        scene = room(seed)
        order = np.random.default_rng(seed).permutation(scene.size)
        one = segment(scene, preset=LIGHT)
        two = segment(Scene.from_cloud(scene.points[order], scene.colors[order]), preset=LIGHT)
        assert alike(one.labels[order], two.labels) == 1

    def test_points_of_the_draft_and_between_them(self) -> None:
        """A draft of a third of the points finds nearly what the whole cloud does."""
        scene = room(0, 3600)
        one, two = segment(scene, preset="best"), segment(scene, preset=LIGHT)
        assert alike(one.labels, two.labels) > 0.9


class TestGridLaws:
    @given(st.integers(0, 99), st.sampled_from([2.0**-10, 2.0**10]))
    @law
    def test_scale(self, seed: int, scale: float) -> None:
        scene = frame(seed)
        assert scene.depth is not None
        large = Scene.from_rgbd(scene.colors, scene.depth * scale)
        one, two = segment(scene, preset=LIGHT), segment(large, preset=LIGHT)
        assert np.array_equal(one.labels, two.labels)


class TestCues:
    @pytest.mark.parametrize("preset", ["fast", "best"])
    def test_colour_sees_no_depth_and_geometry_no_colour(self, preset: str) -> None:
        scene = frame(1)
        assert scene.depth is not None
        full = np.where(np.isnan(scene.depth), 2.0, scene.depth)
        flat, image = Scene.from_rgbd(scene.colors, full), Scene.from_image(scene.colors)
        results = [segment(s, preset=preset, cues="color") for s in (scene, flat, image)]
        assert results[0].k > 3
        assert np.array_equal(results[0].labels, results[1].labels)
        assert np.array_equal(results[0].labels, results[2].labels)
        gray = Scene.from_rgbd(np.full_like(scene.colors, 70), full)
        one, two = (segment(s, preset=preset, cues="geometry") for s in (flat, gray))
        assert one.k > 1
        assert np.array_equal(one.labels, two.labels)
        assert (one.weight, results[0].weight) == (np.inf, 0)

    @pytest.mark.parametrize("cues", ["color", "geometry"])
    def test_of_a_cloud(self, cues: Cues) -> None:
        scene = room(0)
        points = scene.points.copy()
        points[::11] = np.nan
        result = segment(Scene.from_cloud(points, scene.colors), cues=cues)
        assert result.k > 1
        assert np.array_equal(result.labels < 0, np.isnan(points[:, 0]))

    def test_a_cloud_without_any_position(self) -> None:
        scene = Scene.from_cloud(np.full((20, 3), np.nan), np.eye(20, 3, dtype=np.uint8))
        with pytest.raises(GeohueError, match="no point has a position"):
            segment(scene, cues="color")


class TestCounts:
    @pytest.mark.parametrize("preset", ["fast", "best"])
    @pytest.mark.parametrize("make", [room, frame])
    def test_k_segments(self, make: Callable[[int], Scene], preset: str) -> None:
        scene = make(2)
        before = None
        for k in (1, 2, 3, 5, 8, 20):
            result = segment(scene, k, preset=preset)
            assert result.k == k
            if before is not None:  # nested
                pairs = np.stack([result.labels.ravel(), before.ravel()])
                assert len(np.unique(pairs, axis=1).T) == k
            before = result.labels

    def test_more_segments_than_regions_to_begin_with(self) -> None:
        plain = segment(room(0), preset="fast")
        assert plain.levels is not None
        assert len(plain.levels) < 200
        assert segment(room(0), 200, preset="fast").k == 200

    def test_what_lies_in_a_gap_is_no_segment_of_its_own(self) -> None:
        """A patch without depth, of the clearest colour, takes none of the k segments."""
        rgb = np.full((40, 60, 3), 90, np.uint8)
        rgb[:, 30:], rgb[20:, :30], rgb[10:30, 35:50] = (200, 60, 50), (90, 90, 150), (0, 255, 0)
        noise = np.random.default_rng(0).normal(0, 0.002, (40, 60))
        depth = np.where(np.arange(60) < 30, 1.0, 1.5)[None] + noise
        depth[10:30, 35:50] = np.nan
        scene = Scene.from_rgbd(rgb, depth)
        for k in (2, 3, 4, 5):
            result = segment(scene, k, preset="fast")
            assert result.k == k
            assert result.levels is not None
            assert set(np.unique(result.levels.regions)) == set(range(result.levels.tree.n_regions))
        assert segment(scene, preset="fast").k == 3

    @given(st.integers(0, 99), st.floats(-4, 4), st.floats(0, 4))
    @law
    def test_finer_is_nested(self, seed: int, detail: float, more: float) -> None:
        scene = room(seed)
        coarse = segment(scene, preset=LIGHT, detail=detail)
        fine = segment(scene, preset=LIGHT, detail=detail + more)
        assert fine.k >= coarse.k
        pairs = np.stack([fine.labels, coarse.labels])
        assert len(np.unique(pairs, axis=1).T) == fine.k
        assert fine.levels is not None
        assert np.array_equal(fine.levels.at(detail), coarse.labels)
        assert np.array_equal(fine.levels.with_segments(fine.k), fine.labels)

    @given(st.integers(0, 99), st.floats(-2, 2), st.floats(0, 2))
    @law
    def test_finer_is_nested_but_for_the_borders_of_a_frame(
        self, seed: int, detail: float, more: float
    ) -> None:
        """Borders are drawn between the segments of the level that was asked for."""
        scene = frame(seed)
        coarse = segment(scene, preset=LIGHT, detail=detail)
        fine = segment(scene, preset=LIGHT, detail=detail + more)
        assert fine.k >= coarse.k
        assert fine.levels is not None
        assert alike(fine.levels.at(detail), coarse.labels) > 0.95

    def test_words_of_detail(self) -> None:
        scene = frame(3)
        found = [segment(scene, preset=LIGHT, detail=d).k for d in ("coarse", "auto", "fine")]
        assert found == sorted(found)
        assert found[0] < found[2]
        assert segment(scene, preset=LIGHT, detail=0.0).k == found[1]

    @pytest.mark.parametrize("detail", ["fine", 0.5])
    def test_detail_and_k_or_paper_are_refused(self, detail: float) -> None:
        with pytest.raises(GeohueError, match="k is 3: give one of them"):
            segment(room(0), 3, detail=detail)
        for options in ({"preset": "paper"}, {"weight": 2.0}, {"method": "kmeans"}):
            with pytest.raises(GeohueError, match="no levels"):
                segment(room(0), detail=detail, **options)
        with pytest.raises(GeohueError, match="detail is 'finest'"):
            segment(room(0), detail="finest")  # type: ignore[arg-type]

    def test_the_paper_has_no_levels(self) -> None:
        assert segment(room(0), 3, preset="paper").levels is None
