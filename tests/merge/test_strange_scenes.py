"""Scenes with next to nothing in them, and with numbers from the edges of float32."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geohue import Scene, Segmentation, segment
from geohue.features import CUES

PRESETS = ["fast", "best"]


def check(scene: Scene, result: Segmentation, everywhere: bool = True) -> None:
    """Labels 0..k-1, levels for them, and finite scores."""
    assert result.levels is not None
    labels = result.labels
    assert labels.shape == scene.shape
    assert set(np.unique(labels[labels >= 0])) == set(range(result.k))
    assert (labels >= 0).all() == everywhere
    assert np.array_equal(result.levels.at(), labels)
    tree = result.levels.tree
    assert np.isfinite(tree.scores).all()
    assert len(tree.merges) == tree.n_regions - 1
    regions = result.levels.regions
    assert np.array_equal(np.unique(regions[regions >= 0]), np.arange(tree.n_regions))


@pytest.mark.parametrize("preset", PRESETS)
class TestPlain:
    def test_one_colour_and_one_plane(self, preset: str) -> None:
        y, x = np.mgrid[:40, :60]
        scene = Scene.from_rgbd(np.full((40, 60, 3), 90, np.uint8), 1 / (1 - 0.006 * x + 0.004 * y))
        result = segment(scene, preset=preset)
        check(scene, result)
        assert result.k == 1
        assert any("colours are equal" in note for note in result.warnings)

    def test_one_colour_two_planes(self, preset: str) -> None:
        rng = np.random.default_rng(0)
        depth = np.where(np.arange(60) < 25, 1.0, 1.5)[None] + rng.normal(0, 0.002, (40, 60))
        scene = Scene.from_rgbd(np.full((40, 60, 3), 90, np.uint8), depth)
        result = segment(scene, preset=preset)
        check(scene, result)
        assert np.array_equal(result.labels, np.where(np.arange(60) < 25, 1, 0)[None].repeat(40, 0))

    def test_one_plane_two_colours(self, preset: str) -> None:
        rgb = np.full((40, 60, 3), 90, np.uint8)
        rgb[:, :25] = (200, 60, 50)
        noise = np.random.default_rng(0).normal(0, 0.002, (40, 60))
        scene = Scene.from_rgbd(rgb, 1 + noise)
        result = segment(scene, preset=preset)
        check(scene, result)
        assert np.array_equal(result.labels, np.where(np.arange(60) < 25, 1, 0)[None].repeat(40, 0))

    def test_three_points_with_depth(self, preset: str) -> None:
        rgb = np.random.default_rng(0).integers(0, 255, (60, 80, 3)).astype(np.uint8)
        depth = np.full((60, 80), np.nan)
        depth[1, 1], depth[40, 43], depth[17, 71] = 1, 2, 1.5
        scene = Scene.from_rgbd(rgb, depth)
        check(scene, segment(scene, preset=preset))
        check(scene, segment(scene, preset=preset, fill=False), everywhere=False)

    @pytest.mark.parametrize("shape", [(1, 1), (1, 2), (1, 90), (90, 1), (2, 2), (1, 400)])
    def test_narrow_images(self, preset: str, shape: tuple[int, int]) -> None:
        rng = np.random.default_rng(0)
        rgb = rng.integers(0, 255, (*shape, 3)).astype(np.uint8)
        for depth in (np.ones(shape), rng.uniform(1, 2, shape)):
            scene = Scene.from_rgbd(rgb, depth)
            for cues in CUES:
                check(scene, segment(scene, preset=preset, cues=cues))

    def test_copies_of_one_point(self, preset: str) -> None:
        for colors in (np.zeros((50, 3)), np.random.default_rng(0).random((50, 3))):
            scene = Scene.from_cloud(np.ones((50, 3)), colors)
            check(scene, segment(scene, preset=preset))

    @pytest.mark.parametrize("n", [1, 2, 3, 5])
    def test_few_points(self, preset: str, n: int) -> None:
        rng = np.random.default_rng(n)
        scene = Scene.from_cloud(rng.normal(size=(n, 3)), rng.random((n, 3)))
        check(scene, segment(scene, preset=preset))
        for k in range(1, n + 1):
            assert segment(scene, k, preset=preset).k == k

    def test_points_on_a_line(self, preset: str) -> None:
        points = np.linspace(0, 1, 300)[:, None] * [1, 2, 3]
        colors = np.where(np.arange(300)[:, None] < 120, 0.2, 0.9) * np.ones(3)
        scene = Scene.from_cloud(points, colors)
        result = segment(scene, preset=preset)
        check(scene, result)
        assert result.k == 2

    @pytest.mark.parametrize("size", [1e-30, 1e30])
    def test_tiny_and_huge_numbers(self, preset: str, size: float) -> None:
        """The same as in metres."""
        rng = np.random.default_rng(0)
        rgb = np.full((40, 60, 3), 90, np.uint8)
        rgb[:20, 25:] = (200, 60, 50)
        depth = np.where(np.arange(60) < 25, 1.0, 1.5)[None] + rng.normal(0, 0.002, (40, 60))
        metres = segment(Scene.from_rgbd(rgb, depth), preset=preset)
        scene = Scene.from_rgbd(rgb, depth * size)
        result = segment(scene, preset=preset)
        check(scene, result)
        assert metres.k == 3
        assert np.array_equal(result.labels, metres.labels)


@given(st.integers(0, 2**20))
@settings(deadline=None, max_examples=25)
def test_frames_of_odd_numbers(seed: int) -> None:
    rng = np.random.default_rng(seed)
    h, w = rng.integers(1, 24, 2)
    rgb = rng.integers(0, rng.choice([2, 256]), (h, w, 3)).astype(np.uint8)
    depth = rng.choice([0.0, np.nan, np.inf, 1.0, 1e-30, 1e30, 2.0], (h, w))
    scene = Scene.from_rgbd(rgb, depth)
    if scene.valid.any():
        check(scene, segment(scene, preset="fast", detail="auto"))


@given(st.integers(0, 2**20))
@settings(deadline=None, max_examples=25)
def test_clouds_of_odd_numbers(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 200))
    kinds = rng.choice([0.0, 1.0, 1e-30, 1e30, -2.0, np.nan], 3)
    points = rng.choice(kinds, (n, 3)) * rng.choice([1, rng.random()], (n, 3))
    scene = Scene.from_cloud(points, rng.integers(0, 3, (n, 3)).astype(np.uint8) * 90)
    if scene.valid.any():
        result = segment(scene, preset="fast")
        check(scene, result, everywhere=bool(scene.valid.all()))
        assert np.array_equal(result.labels >= 0, scene.valid)
