"""From a draft and its cuts to regions and merges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from geohue import Scene
from geohue.features import extract_features, lab_of
from geohue.merge.draft import draft_evidence, merge_draft
from geohue.merge.evidence import Evidence, gather
from geohue.merge.oversegment import oversegment
from geohue.merge.score import Cues
from geohue.merge.tree import MergeTree
from geohue.regions.graph import PairGraph
from merge.tables import random_evidence

Labels = NDArray[np.int32]
Found = tuple[Labels, MergeTree]


def halves(seed: int = 0) -> tuple[Scene, Labels]:
    """Two walls that differ in colour and depth, with noise."""
    rng = np.random.default_rng(seed)
    truth = (np.arange(40) >= 22).astype(np.int32)[None].repeat(30, 0)
    rgb = np.array([[190, 60, 50], [60, 120, 180]])[truth] + rng.normal(0, 5, (30, 40, 3))
    depth = np.array([1.0, 1.4])[truth] + rng.normal(0, 0.003, truth.shape)
    return Scene.from_rgbd(np.clip(rgb, 0, 255).astype(np.uint8), depth), truth


def merged(
    scene: Scene, cuts: Sequence[Labels] = (), cues: Cues = "fusion", least: int = 1
) -> Found:
    graph = PairGraph.of(scene, 0.0, everywhere=cues == "color")
    return merge_draft(graph, extract_features(scene, cues), cuts, least)


def same(one: Found, two: Found) -> bool:
    return (
        np.array_equal(one[0], two[0])
        and np.array_equal(one[1].merges, two[1].merges)
        and np.array_equal(one[1].scores, two[1].scores)
    )


class TestGrid:
    def test_finds_both_walls_again_and_again(self) -> None:
        scene, truth = halves()
        regions, tree = merged(scene, [truth])
        labels = tree.with_segments(2)[regions]
        assert np.array_equal(labels, truth)
        assert tree.scores[-1] > 0 > tree.scores[0]
        assert regions.dtype == np.int32
        assert same((regions, tree), merged(scene, [truth]))

    def test_regions_and_merges_are_complete(self) -> None:
        scene, truth = halves(1)
        regions, tree = merged(scene, [truth])
        assert np.array_equal(np.unique(regions), np.arange(tree.n_regions))
        assert len(tree.merges) == tree.n_regions - 1

    def test_votes_count(self) -> None:
        """A border that all cuts draw across a wall of one colour."""
        plain = Scene.from_rgbd(np.full((30, 40, 3), 99, np.uint8), np.ones((30, 40)))
        truth = (np.arange(40) >= 22).astype(np.int32)[None].repeat(30, 0)
        assert merged(plain)[1].n_regions == 1
        regions, _ = merged(plain, [truth])
        assert np.array_equal(regions, truth)

    def test_geometry_ignores_colour_and_colour_ignores_depth(self) -> None:
        scene, truth = halves()
        gray = Scene.from_rgbd(np.zeros_like(scene.colors), np.asarray(scene.depth))
        assert same(merged(scene, [truth], "geometry"), merged(gray, [truth], "geometry"))
        flat = Scene.from_rgbd(scene.colors, np.ones(scene.shape))
        assert same(merged(scene, [truth], "color"), merged(flat, [truth], "color"))
        image = Scene.from_image(scene.colors)
        assert same(merged(scene, [truth], "color"), merged(image, [truth], "color"))

    def test_pixels_in_gaps_have_a_region(self) -> None:
        scene, truth = halves()
        depth = np.asarray(scene.depth).copy()
        depth[10:20, 5:35] = np.nan
        regions, tree = merged(Scene.from_rgbd(scene.colors, depth), [truth])
        assert regions.min() == 0
        assert np.array_equal(tree.with_segments(2)[regions], truth)

    def test_colours_are_blurred_by_half_a_pixel_before_regions_begin(self) -> None:
        """The finest regions are those of Felzenszwalb's rule on blurred colours."""
        rng = np.random.default_rng(3)
        rgb = np.kron(rng.integers(0, 255, (3, 4, 3)), np.ones((9, 9, 1)))
        rgb = np.clip(rgb + rng.normal(0, 12, rgb.shape), 0, 255).astype(np.uint8)
        scene = Scene.from_rgbd(rgb, np.ones(rgb.shape[:2]))
        graph = PairGraph.of(scene, 0.0)
        evidence, _ = random_evidence(0)
        no = np.zeros(len(graph.one))
        plain = replace(evidence, one=graph.one, other=graph.other, gap=no, share=no)
        lab = gaussian_filter(lab_of(scene.colors).astype(float), (0.5, 0.5, 0)).reshape(-1, 3)
        smallest = scene.size // 200
        expected = oversegment(plain, lab, 20.0, smallest)
        assert np.array_equal(merged(scene)[0].ravel(), expected)

    def test_regions_of_a_cloud_begin_with_colours_averaged_over_neighbours(self) -> None:
        rng = np.random.default_rng(4)
        colors = rng.integers(0, 256, (60, 3)).astype(np.uint8)
        scene = Scene.from_cloud(rng.normal(size=(60, 3)), colors)
        graph = PairGraph.of(scene, 0.0)
        evidence, found = draft_evidence(graph, extract_features(scene), [])
        lab = lab_of(colors).astype(float)
        assert np.array_equal(evidence.lab, lab)
        for i in range(60):
            beside = [*evidence.other[evidence.one == i], *evidence.one[evidence.other == i]]
            assert len(beside) > 2
            np.testing.assert_allclose(found[i], lab[[i, *beside]].mean(axis=0))

    def test_steps_of_pixels_in_gaps_are_those_of_the_nearest(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        steps: list[NDArray[np.float64]] = []

        def spy(*arguments: Any) -> Evidence:
            steps.append(arguments[7])
            return gather(*arguments)

        monkeypatch.setattr("geohue.merge.draft.gather", spy)
        depth = np.array([[9.0, 1, np.nan, np.nan, np.nan, 1, 4]])
        scene = Scene.from_rgbd(np.zeros((1, 7, 3), np.uint8), depth)
        merged(scene)
        assert (steps[0] > 0).tolist() == [True, False, False, True, False, True]


class TestLeast:
    @pytest.mark.parametrize("least", [2, 9, 60, 200])
    def test_as_many_regions_as_asked_for(self, least: int) -> None:
        rng = np.random.default_rng(0)
        rgb = rng.integers(90, 110, (12, 20, 3)).astype(np.uint8)
        scene = Scene.from_rgbd(rgb, 1 + 0.01 * rng.random((12, 20)))
        regions, tree = merged(scene, least=least)
        assert tree.n_regions >= least
        assert regions.max() + 1 == tree.n_regions

    def test_even_where_nothing_differs_at_most_as_many_as_points(self) -> None:
        plain = Scene.from_rgbd(np.zeros((4, 5, 3), np.uint8), np.ones((4, 5)))
        assert merged(plain, least=99)[1].n_regions in (1, 20)

    def test_small_drafts_may_have_small_regions(self) -> None:
        """A two hundredth of the points is enough, however few: here two of 400."""
        rgb = np.zeros((20, 20, 3), np.uint8)
        rgb[4, 4:6] = 255
        regions, _ = merged(Scene.from_rgbd(rgb, np.ones((20, 20))))
        assert regions.max() > 0


class TestCloud:
    def test_pieces_are_joined_last_and_small_pieces_are_none(self) -> None:
        rng = np.random.default_rng(0)
        points = np.concatenate([rng.random((200, 3)), rng.random((200, 3)) + 9])
        scene = Scene.from_cloud(points, np.full((400, 3), 120, np.uint8))
        _, tree = merged(scene)
        assert tree.scores[-1] == 1000
        assert (tree.scores[:-1] < 1000).all()
        near = Scene.from_cloud(
            np.concatenate([points[:200], points[200:208] - 7]), scene.colors[:208]
        )
        assert (merged(near)[1].scores < 1000).all()

    @pytest.mark.parametrize(("gap", "apart"), [(3.8, False), (4.2, True), (5.5, True)])
    def test_pieces_within_four_medians_may_be_one_thing(self, gap: float, apart: bool) -> None:
        y, x = np.mgrid[:9, :9].reshape(2, -1).astype(float)
        sheet = np.stack([x, y, 0 * x], axis=1)
        points = np.concatenate([sheet, sheet + np.array([0, 0, gap])])
        graph = PairGraph.of(Scene.from_cloud(points, np.zeros((162, 3), np.uint8)), 0.0)
        away = graph.draft.points[graph.one] - graph.draft.points[graph.other]
        assert np.median(np.linalg.norm(away, axis=1)[: graph.n_beside]) == 1
        assert graph.n_beside < len(graph.one)
        colors = np.repeat([[200, 30, 30], [30, 200, 30]], 81, axis=0).astype(np.uint8)
        _, tree = merged(Scene.from_cloud(points, colors))
        assert (tree.scores[-1] == 1000) == apart
