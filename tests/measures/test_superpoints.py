"""Measures of over-segmentations: values worked by hand, laws, twins, other libraries."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray
from sklearn.metrics import r2_score
from sklearn.metrics.cluster import contingency_matrix

from geohue.errors import GeohueError
from geohue.measures.pairs import pair_boundary_precision_recall_f, pair_compactness
from geohue.measures.superpoints import (
    compactness,
    explained_variation,
    levinshtein_undersegmentation_error,
    superpoint_scores,
)
from geohue.regions.adjacency import adjacent_pixels, adjacent_points
from geohue.scene import Scene
from twins.superpoints import literal_compactness, literal_levinshtein, literal_pair_recall

Labels = NDArray[np.int64]


def maps(low: int, high: int) -> st.SearchStrategy[Labels]:
    return hnp.arrays(np.int64, (4, 5), elements=st.integers(low, high))


class TestLevinshtein:
    def test_by_hand(self) -> None:
        # Regions of 6 and 4; segments 3 | 5 (3 and 2) | 2: (8 - 6) / 6 and (7 - 4) / 4.
        pred = np.array([1, 1, 1, 2, 2, 2, 2, 2, 3, 3])
        gt = np.array([1] * 6 + [2] * 4)
        found = levinshtein_undersegmentation_error(pred, gt)
        assert found == pytest.approx((2 / 6 + 3 / 4) / 2)

    @given(maps(-1, 4), maps(1, 4))
    def test_twin(self, pred: Labels, gt: Labels) -> None:
        found = levinshtein_undersegmentation_error(pred, gt)
        assert found == pytest.approx(literal_levinshtein(pred, gt))

    @given(maps(0, 4), maps(1, 4))
    def test_a_refinement_leaks_nothing(self, cut: Labels, gt: Labels) -> None:
        assert levinshtein_undersegmentation_error(gt * 10 + cut, gt) == 0

    @given(maps(0, 4), maps(0, 3), maps(1, 4))
    def test_splitting_never_leaks_more(self, pred: Labels, cut: Labels, gt: Labels) -> None:
        finer = levinshtein_undersegmentation_error(pred * 10 + cut, gt)
        assert finer <= levinshtein_undersegmentation_error(pred, gt) + 1e-12


class TestCompactness:
    def test_by_hand(self) -> None:
        # A square of 4 pixels with 8 sides; a bar of 4 with 10; two alone with 4 each.
        labels = np.array([[1, 1, 2], [1, 1, 2], [3, -1, 2], [4, -1, 2]])
        expected = (4 * 4 / 64 + 4 * 4 / 100 + 2 * 1 / 16) / 10
        assert compactness(labels) == pytest.approx(4 * math.pi * expected)

    @given(maps(-1, 4))
    def test_twin(self, labels: Labels) -> None:
        labels[0, 0] = 1
        assert compactness(labels) == pytest.approx(literal_compactness(labels))
        assert compactness(labels) <= math.pi / 4 + 1e-12

    @given(maps(0, 3), st.permutations(range(4)))
    def test_names_do_not_matter(self, labels: Labels, names: list[int]) -> None:
        assert compactness(np.array(names)[labels]) == pytest.approx(compactness(labels))

    def test_of_pairs_on_a_grid(self) -> None:
        # 16 squares in a wrapped grid: all of degree 4, every perimeter as on an image.
        index = np.arange(64).reshape(8, 8)
        pairs = (
            np.concatenate([index.ravel(), index.ravel()]),
            np.concatenate([np.roll(index, 1, 0).ravel(), np.roll(index, 1, 1).ravel()]),
        )
        labels = (np.arange(64) // 8 // 2 * 4 + np.arange(64) % 8 // 2).astype(np.int64)
        assert pair_compactness(labels, pairs) == pytest.approx(math.pi / 4)
        twice = tuple(np.concatenate([side, side]) for side in pairs)
        assert pair_compactness(labels, (twice[0], twice[1])) == pytest.approx(math.pi / 4)

    def test_of_pairs_by_hand(self) -> None:
        # A cycle of 30: degree 2, each arc is cut twice, which counts 4. One arc has no label.
        cycle = np.arange(30), np.roll(np.arange(30), 1)
        labels = np.repeat([1, 2, -1], [2, 8, 20])
        small = 4 * math.pi * 2 / 16  # above 1
        large = 4 * math.pi * 8 / 16
        assert min(small, large) > 1
        assert pair_compactness(labels, cycle) == 1
        full = (
            np.concatenate([cycle[0]] * 4),
            np.concatenate([np.roll(cycle[0], k) for k in (1, 2, 3, 4)]),
        )
        # Degree 8: an end of an arc is cut 1 + 2 + 3 + 4 times (an arc of 2: 1 + 2 + 2 + 2).
        cuts = {2: 2 * 7 * 4 / 8, 8: 2 * 10 * 4 / 8}
        parts = [n * min(1.0, 4 * math.pi * n / cuts[n] ** 2) for n in (2, 8)]
        assert pair_compactness(labels, full) == pytest.approx(sum(parts) / 10)

    def test_round_patches_are_rounder_than_strips(self) -> None:
        points = np.random.default_rng(0).uniform(0, 1, (4000, 2))
        scene = Scene.from_cloud(
            np.column_stack([points, np.zeros(4000)]), np.zeros((4000, 3), np.uint8)
        )
        pairs = adjacent_points(scene)
        cell = np.floor(points * 8).astype(np.int64)
        squares = cell[:, 0] * 8 + cell[:, 1]
        strips = np.floor(points[:, 0] * 64).astype(np.int64)
        assert pair_compactness(squares, pairs) > 2 * pair_compactness(strips, pairs)
        assert 0.5 < pair_compactness(squares, pairs) < 1


class TestPairs:
    PAIRS = (np.arange(9), np.arange(1, 10))
    GT = np.array([1, 1, 1, 1, 1, 2, 2, 2, 2, 2])
    PRED = np.array([5, 5, 5, 6, 6, 6, 6, 6, 6, 7])  # borders at 2-3 and 8-9, the true one at 4-5

    @pytest.mark.parametrize(
        ("slack", "precision", "recall"),
        [(0, 0, 0), (1, 0, 0), (2, 0.5, 1), (3, 0.5, 1), (4, 1, 1)],
    )
    def test_by_hand(self, slack: int, precision: float, recall: float) -> None:
        found = pair_boundary_precision_recall_f(self.PRED, self.GT, self.PAIRS, slack=slack)
        assert found[:2] == (precision, recall)

    def test_pairs_with_ignored_ends_are_left_out(self) -> None:
        gt = np.where(np.arange(10) == 9, 0, self.GT)
        found = pair_boundary_precision_recall_f(self.PRED, gt, self.PAIRS, slack=2)
        assert found[:2] == (1, 1)

    @given(maps(-1, 2), maps(1, 3), st.integers(0, 3))
    def test_twin(self, pred: Labels, gt: Labels, slack: int) -> None:
        pairs = adjacent_pixels(pred.shape)
        pred, gt = pred.reshape(-1), gt.reshape(-1)
        listed = list(zip(pairs[0].tolist(), pairs[1].tolist(), strict=True))
        found = pair_boundary_precision_recall_f(pred, gt, pairs, slack=slack)
        expected = (
            literal_pair_recall(pred, gt, listed, slack),
            literal_pair_recall(gt, pred, listed, slack),
        )
        assert found[:2] == pytest.approx(expected)

    @given(maps(0, 3), maps(1, 4), maps(0, 2))
    def test_splitting_never_loses_recall(self, pred: Labels, gt: Labels, cut: Labels) -> None:
        pairs = adjacent_pixels(pred.shape)
        before = pair_boundary_precision_recall_f(pred, gt, pairs)
        after = pair_boundary_precision_recall_f(pred * 10 + cut, gt, pairs)
        assert after.recall >= before.recall

    def test_refusals(self) -> None:
        labels = np.ones(4, int)
        refused = {
            "both ends": (np.arange(3), np.arange(2)),
            "whole numbers": (np.zeros(2), np.zeros(2)),
            "from 0 to 3": (np.array([0]), np.array([4])),
        }
        for message, pairs in refused.items():
            with pytest.raises(GeohueError, match=message):
                pair_boundary_precision_recall_f(labels, labels, pairs)
        with pytest.raises(GeohueError, match="slack -1"):
            pair_boundary_precision_recall_f(labels, labels, (np.arange(2), np.arange(2)), slack=-1)
        with pytest.raises(GeohueError, match="no point has a label"):
            pair_compactness(-labels, (np.arange(2), np.arange(2)))
        with pytest.raises(GeohueError, match=r"give an \(H, W\)"):
            compactness(labels)


class TestExplainedVariation:
    def test_equals_r2_of_the_means(self) -> None:
        rng = np.random.default_rng(1)
        labels, values = rng.integers(-1, 6, 200), rng.normal(5, 2, (200, 3))
        means = np.empty_like(values)
        for label in np.unique(labels):
            means[labels == label] = values[labels == label].mean(axis=0)
        expected = r2_score(values, means, multioutput="variance_weighted")
        assert explained_variation(labels, values) == pytest.approx(expected)

    def test_points_without_values_are_left_out(self) -> None:
        values = np.array([0.0, 2.0, 10.0, 12.0, np.nan, np.inf])
        found = explained_variation(np.array([1, 1, 2, 2, 2, 3]), values)
        assert found == pytest.approx(100 / 104)

    def test_bounds(self) -> None:
        values = np.random.default_rng(2).normal(0, 1, (6, 8, 3))
        assert explained_variation(np.zeros((6, 8), int), values) == pytest.approx(0)
        assert explained_variation(np.arange(48).reshape(6, 8), values) == pytest.approx(1)
        assert explained_variation(np.zeros((6, 8), int), np.ones((6, 8))) == 1

    def test_refusals(self) -> None:
        with pytest.raises(GeohueError, match="values for each point"):
            explained_variation(np.zeros(3, int), np.zeros(4))
        with pytest.raises(GeohueError, match="finite values only"):
            explained_variation(np.zeros(3, int), np.full(3, np.nan))


class TestTogether:
    def test_grid(self) -> None:
        gt = np.repeat(np.arange(1, 5), 20)[None].repeat(40, 0)
        pred = gt * 2 + (np.arange(40) >= 20)[:, None]
        scores = superpoint_scores(pred, gt, values=gt.astype(float))
        assert scores["n_superpoints"] == 8
        for name in ("achievable_accuracy", "boundary_recall", "explained_variation"):
            assert scores[name] == 1
        assert scores["undersegmentation_error"] == scores["levinshtein_error"] == 0
        assert scores["compactness"] == pytest.approx(math.pi / 4)
        # The line across (80 pixels) is wrong but for the three true lines that it meets.
        assert scores["boundary_precision"] < 0.7

    def test_cloud(self) -> None:
        pairs = (np.arange(9), np.arange(1, 10))
        gt = np.repeat([1, 2], 5)
        scores = superpoint_scores(np.repeat([1, 2, 3], [2, 3, 5]), gt, pairs=pairs)
        assert (scores["boundary_recall"], scores["boundary_precision"]) == (1, 0.5)
        early = superpoint_scores(np.repeat([1, 2], [4, 6]), gt, pairs=pairs)
        assert (early["boundary_recall"], early["boundary_precision"]) == (1, 1)  # share point 4
        exact = superpoint_scores(np.repeat([1, 2], [4, 6]), gt, pairs=pairs, slack=0)
        assert exact["boundary_recall"] == 0
        bare = superpoint_scores(np.repeat([1, 2, 3], [2, 3, 5]), gt)
        assert set(scores) - set(bare) == {"boundary_recall", "boundary_precision", "compactness"}

    def test_accuracy_is_that_of_another_library(self) -> None:
        rng = np.random.default_rng(4)
        pred, gt = rng.integers(0, 30, 500), rng.integers(1, 6, 500)
        table = contingency_matrix(pred, gt)
        scores = superpoint_scores(pred, gt)
        assert scores["achievable_accuracy"] == pytest.approx(table.max(axis=1).sum() / 500)

    def test_default_tolerance(self) -> None:
        # 0.0025 of 800 pixels is 2.
        gt = np.ones((480, 640), int)
        gt[:, 300:] = 2
        moved = {d: np.roll(gt, d, 1)[:, 9:] for d in (2, 3)}
        truth = gt[:, 9:]
        assert superpoint_scores(moved[2], truth)["boundary_recall"] == 1
        assert superpoint_scores(moved[3], truth)["boundary_recall"] == 0

    def test_a_maize_plant(self, data_dir: Path) -> None:
        """More cells of a real cloud hold more of its truth."""
        path = data_dir / "maize" / "plant11.ply"
        if not path.is_file():
            pytest.skip("no maize/plant11.ply")
        _, rows = path.read_bytes().split(b"end_header\n", 1)
        row = [("xyz", "<f4", 3), ("rgb", "u1", 3), ("label", "<i4")]
        plant = np.frombuffer(rows, np.dtype(row))
        scene, gt = Scene.from_cloud(plant["xyz"], plant["rgb"]), plant["label"]
        pairs = adjacent_points(scene)
        scores = []
        for parts in (8, 32):
            cell = np.floor(scene.points * (parts / np.ptp(scene.points))).astype(np.int64)
            _, pred = np.unique(cell, axis=0, return_inverse=True)
            scores.append(superpoint_scores(pred.reshape(-1), gt, pairs=pairs, values=scene.points))
        coarse, fine = scores
        assert fine["n_superpoints"] > coarse["n_superpoints"]
        for name in ("achievable_accuracy", "explained_variation"):
            assert fine[name] >= coarse[name]
        assert fine["boundary_precision"] < 0.5
