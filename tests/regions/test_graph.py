"""The points of a draft as a graph: pairs across gaps, and links between pieces."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue import Scene
from geohue.regions.graph import PairGraph
from geohue.regions.groups import connected_groups


def cloud(points: NDArray[np.float64]) -> Scene:
    return Scene.from_cloud(points, np.zeros(points.shape, np.uint8))


def frame(depth: NDArray[np.float64]) -> Scene:
    return Scene.from_rgbd(np.zeros((*depth.shape, 3), np.uint8), depth)


def row(n: int, at: float) -> NDArray[np.float64]:
    """Points one apart along y, at some x."""
    return np.asarray(np.c_[np.full(n, at), np.arange(float(n)), np.zeros(n)])


def linked(*parts: NDArray[np.float64], far: float = 4.0) -> tuple[PairGraph, NDArray[np.int32]]:
    graph = PairGraph.of(cloud(np.concatenate(parts)), 0.0)
    one, other, _ = graph.close_pairs(far)
    everywhere = np.zeros(graph.draft.size, np.int32)
    return graph, connected_groups(everywhere, one, other)


class TestClosePairs:
    def test_near_pieces_are_one_and_far_ones_are_not(self) -> None:
        _, piece = linked(row(60, 0), row(60, 3.9), row(60, 8.0))
        # Each point is beside its 5 nearest, 1 to 3 away: the median is 1 or 2.
        assert piece.max() == 0
        assert linked(row(60, 0), row(60, 30))[1].max() == 1
        assert linked(row(60, 0), row(60, 30), far=40.0)[1].max() == 0

    def test_the_limit_counts_in_medians_of_neighbours(self) -> None:
        graph = PairGraph.of(cloud(np.concatenate([row(60, 0), row(60, 30)])), 0.0)
        away = graph.draft.points[graph.one] - graph.draft.points[graph.other]
        length = np.linalg.norm(away, axis=1)
        median = float(np.median(length[: graph.n_beside]))
        assert length[graph.n_beside :].min() == 30
        for far, distant in ((30 / median * 0.999, True), (30 / median * 1.001, False)):
            assert (graph.close_pairs(far)[2].size > 0) == distant

    def test_small_pieces_are_nothing_of_their_own(self) -> None:
        assert linked(row(60, 0), row(29, 30))[1].max() == 0
        assert linked(row(60, 0), row(30, 30))[1].max() == 1

    def test_all_pairs_once_and_the_shortest_links_first(self) -> None:
        graph, _ = linked(row(60, 0), row(60, 90), row(60, 40))
        one, other, distant = graph.close_pairs(4.0)
        assert len(one) + len(distant) == len(graph.one)
        together = np.concatenate([np.stack([one, other], axis=1), distant])
        pairs = np.stack([graph.one, graph.other], axis=1)
        assert sorted(together.tolist()) == sorted(pairs.tolist())
        points = graph.draft.points
        length = np.linalg.norm(points[distant[:, 0]] - points[distant[:, 1]], axis=1)
        assert length[0] == 40
        assert length[-1] == 50
        assert (np.diff(length) >= 0).all()

    @given(st.integers(0, 2**20), st.sampled_from([1e-6, 0.25, 1e6]))
    @settings(deadline=None, max_examples=15)
    def test_scale_says_nothing(self, seed: int, scale: float) -> None:
        rng = np.random.default_rng(seed)
        points = rng.normal(size=(150, 3)) + rng.choice([0, 40.0], (150, 1))
        one = PairGraph.of(cloud(points), 0.0).close_pairs(4.0)
        two = PairGraph.of(cloud(points * scale), 0.0).close_pairs(4.0)
        assert [len(part) for part in one] == [len(part) for part in two]

    def test_a_grid_has_no_distance(self) -> None:
        depth = np.ones((6, 8))
        depth[:, 4:] = 90
        graph = PairGraph.of(frame(depth), 0.0)
        one, other, distant = graph.close_pairs(4.0)
        assert one is graph.one
        assert other is graph.other
        assert distant.shape == (0, 2)


class TestRealPairs:
    def test_gaps_count_as_the_nearest_pixel(self) -> None:
        graph = PairGraph.of(frame(np.array([[1.0, np.nan, np.nan, 1.0]])), 0.0)
        assert graph.near is not None
        assert graph.near.tolist() == [[0, 0, 3, 3]]
        one, other, real = graph.real_pairs()
        assert list(zip(one.tolist(), other.tolist(), strict=True)) == [(0, 3)]
        assert real.tolist() == [False, True, False]

    def test_without_gaps_where_colour_alone_counts(self) -> None:
        for depth in ([[1.0, np.nan, np.nan, 1.0]], [[np.nan] * 4]):
            graph = PairGraph.of(frame(np.array(depth)), 0.0, everywhere=True)
            assert graph.near is not None
            assert graph.near.tolist() == [[0, 1, 2, 3]]

    def test_points_in_one_place_are_no_pair(self) -> None:
        points = np.array([[0.0, 0, 0], [0, 0, 0], [1, 0, 0]])
        one, other, real = PairGraph.of(cloud(points), 0.0).real_pairs()
        assert {frozenset(pair) for pair in zip(one.tolist(), other.tolist(), strict=True)} == {
            frozenset([0, 2])
        }
        assert len(real) > real.sum() > 0


class TestTidied:
    def test_gaps_and_small_regions(self) -> None:
        depth = np.ones((10, 20))
        depth[:, 9:11] = np.nan
        graph = PairGraph.of(frame(depth), 0.02)
        assert graph.smallest == 10  # not 4
        labels = np.zeros((10, 20), np.int32)
        labels[:, 10:] = 1
        labels[2:5, 2:5] = 2  # nine pixels
        labels[np.isnan(depth)] = -1
        expected = (np.arange(20) >= 10).astype(np.int32)[None].repeat(10, 0)
        assert np.array_equal(graph.tidied(labels), expected)
        assert np.array_equal(graph.known(expected) < 0, np.isnan(depth))

    def test_share_of_the_points(self) -> None:
        assert PairGraph.of(frame(np.ones((100, 100))), 0.002).smallest == 20
        assert PairGraph.of(cloud(np.random.default_rng(0).random((50, 3))), 0.9).smallest == 45
        assert PairGraph.of(cloud(np.random.default_rng(0).random((50, 3))), 0.1).smallest == 30

    def test_noise_says_nothing(self) -> None:
        noise = np.random.default_rng(0).integers(0, 40, (12, 12)).astype(np.int32)
        assert not PairGraph.of(frame(np.ones((12, 12))), 0.0).tidied(noise).any()
        points = np.random.default_rng(0).random((100, 3))
        graph = PairGraph.of(cloud(points), 0.0)
        assert not graph.tidied(np.arange(100, dtype=np.int32)).any()

    def test_small_groups_of_a_cloud(self) -> None:
        points = np.concatenate([row(80, 0), row(80, 90)])
        labels = np.repeat([0, 1], 80).astype(np.int32)
        expected = labels.copy()
        labels[10:14] = 7
        assert np.array_equal(PairGraph.of(cloud(points), 0.0).tidied(labels), expected)


@pytest.mark.parametrize(("size", "kept"), [(9, False), (10, True)])
def test_fewer_than_10_pixels_are_no_region(size: int, kept: bool) -> None:
    draft = Scene.from_rgbd(np.zeros((20, 20, 3), np.uint8), np.ones((20, 20)))
    labels = np.zeros((20, 20), np.int32)
    labels[5, 5 : 5 + size] = 1
    assert PairGraph.of(draft, 0.0).tidied(labels).any() == kept


@pytest.mark.parametrize(("size", "kept"), [(29, False), (30, True)])
def test_fewer_than_30_points_are_no_region(size: int, kept: bool) -> None:
    draft = cloud(row(300, 0.0))
    labels = (np.arange(300) < size).astype(np.int32)
    assert bool((PairGraph.of(draft, 0.0).tidied(labels) == 1).any()) == kept
