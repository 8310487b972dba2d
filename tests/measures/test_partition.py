"""Region measures: cases worked by hand, readable twins and other libraries."""

from __future__ import annotations

import math
from itertools import combinations
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from skimage import metrics
from sklearn.metrics import adjusted_rand_score, mutual_info_score, rand_score

from geohue.errors import GeohueError
from geohue.measures.contingency import contingency_table
from geohue.measures.partition import (
    achievable_segmentation_accuracy,
    adjusted_rand_index,
    probabilistic_rand_index,
    rand_index,
    segmentation_covering,
    undersegmentation_error,
    variation_of_information,
)

Labels = NDArray[np.int64]

skimage_metrics: Any = metrics  # it ships code without types

# Two halves of four pixels; the prediction moves one pixel over.
HALVES: Labels = np.array([1, 1, 1, 1, 2, 2, 2, 2])
MOVED: Labels = np.array([5, 5, 5, 7, 7, 7, 7, 7])


def frames() -> list[tuple[Labels, Labels]]:
    """Blocks with noise, from coarse to one label a pixel, unlabelled and ignored pixels too."""
    rng = np.random.default_rng(4)
    pairs = []
    for n_pred, n_gt in [(1, 1), (1, 6), (7, 1), (5, 5), (60, 9), (1200, 30)]:
        gt = np.kron(rng.integers(0, n_gt, (6, 8)), np.ones((5, 5), int)) + (n_gt == 1)
        pred = np.where(rng.random(gt.shape) < 0.5, gt, rng.integers(-1, n_pred, gt.shape))
        pairs.append((pred, gt))
    return pairs


def compared(pred: Labels, gt: Labels) -> tuple[Labels, Labels]:
    """Labels of the compared pixels, from 0 up (scikit-image takes no negative ones)."""
    return pred[gt != 0] + 1, gt[gt != 0]


class TestByHand:
    """Overlaps 3, 1 and 4 of 8 pixels: H(pred|gt) = 4/8 h(1/4), H(gt|pred) = 5/8 h(1/5)."""

    def test_variation_of_information(self) -> None:
        over = 0.5 * (0.75 * math.log2(4 / 3) + 0.25 * math.log2(4))
        under = 0.625 * (0.2 * math.log2(5) + 0.8 * math.log2(5 / 4))
        got = variation_of_information(MOVED, HALVES)
        assert got == pytest.approx((over + under, over, under), rel=1e-14)

    def test_nats(self) -> None:
        bits = variation_of_information(MOVED, HALVES)
        nats = variation_of_information(MOVED, HALVES, base=math.e)
        assert nats == pytest.approx([math.log(2) * x for x in bits], rel=1e-14)

    def test_rand(self) -> None:
        # Pairs joined: by both 3 + 0 + 6, by pred 3 + 10, by gt 6 + 6, of 28.
        assert rand_index(MOVED, HALVES) == (28 + 2 * 9 - 13 - 12) / 28

    def test_adjusted_rand(self) -> None:
        expected = 13 * 12 / 28
        assert adjusted_rand_index(MOVED, HALVES) == pytest.approx(
            (9 - expected) / (12.5 - expected)
        )

    def test_covering(self) -> None:
        assert segmentation_covering(MOVED, HALVES) == pytest.approx((4 * 3 / 4 + 4 * 4 / 5) / 8)

    def test_undersegmentation_error(self) -> None:
        # The larger region leaks one pixel, counted at both true regions it touches.
        assert undersegmentation_error(MOVED, HALVES) == 2 / 8

    def test_achievable_accuracy(self) -> None:
        assert achievable_segmentation_accuracy(MOVED, HALVES) == 7 / 8

    def test_probabilistic_rand(self) -> None:
        one, two = rand_index(MOVED, HALVES), rand_index(MOVED, MOVED)
        assert probabilistic_rand_index(MOVED, [HALVES, MOVED]) == (one + two) / 2


def test_over_and_under_segmentation_are_told_apart() -> None:
    split, merged = np.arange(8), np.zeros(8, int)
    assert variation_of_information(split, HALVES) == (2, 2, 0)
    assert variation_of_information(merged, HALVES) == (1, 0, 1)
    assert undersegmentation_error(split, HALVES) == 0
    assert undersegmentation_error(merged, HALVES) == 1
    assert achievable_segmentation_accuracy(split, HALVES) == 1
    assert segmentation_covering(merged, HALVES) == 0.5


def test_unlabelled_pixels_are_one_region() -> None:
    pred = np.array([1, 1, -1, -1, 2, 2, -1, -1])
    assert variation_of_information(pred, HALVES) == (1.5, 1, 0.5)
    assert variation_of_information(pred, HALVES, keep_unlabelled=False).total == 0
    assert rand_index(pred, HALVES, keep_unlabelled=False) == 1
    assert segmentation_covering(pred, HALVES, keep_unlabelled=False) == 1


def test_one_pixel() -> None:
    one = np.array([3])
    assert rand_index(one, one) == 1
    assert adjusted_rand_index(one, one) == 1
    assert variation_of_information(one, one).total == 0


@pytest.mark.parametrize(("pred", "gt"), frames())
class TestAgainstOtherLibraries:
    def test_variation_of_information(self, pred: Labels, gt: Labels) -> None:
        ours = variation_of_information(pred, gt)
        p, g = compared(pred, gt)
        assert (ours.under, ours.over) == pytest.approx(
            skimage_metrics.variation_of_information(p, g), abs=1e-12
        )

    def test_mutual_information(self, pred: Labels, gt: Labels) -> None:
        p, g = compared(pred, gt)
        shared = mutual_info_score(g, p)
        apart = mutual_info_score(p, p) + mutual_info_score(g, g) - 2 * shared
        assert variation_of_information(pred, gt, base=math.e).total == pytest.approx(
            apart, abs=1e-9
        )

    def test_rand(self, pred: Labels, gt: Labels) -> None:
        p, g = compared(pred, gt)
        assert rand_index(pred, gt) == pytest.approx(rand_score(g, p), rel=1e-12)
        assert adjusted_rand_index(pred, gt) == pytest.approx(adjusted_rand_score(g, p), abs=1e-12)

    def test_joined_pairs(self, pred: Labels, gt: Labels) -> None:
        # The adapted Rand error is 1 - F of the joined pairs: a view of our table on its own.
        table = contingency_table(pred, gt)
        both, in_pred, in_gt = (
            float((n * (n - 1)).sum()) for n in (table.counts, table.pred_sizes, table.gt_sizes)
        )
        p, g = compared(pred, gt)
        error, _, _ = skimage_metrics.adapted_rand_error(g, p, ignore_labels=())
        assert 1 - 2 * both / (in_pred + in_gt) == pytest.approx(error, abs=1e-12)


def slow_covering(pred: Labels, gt: Labels) -> float:
    """Equation of the docstring, region by region."""
    covered = 0.0
    for true in np.unique(gt):
        region = gt == true
        overlaps = [
            np.sum(region & (pred == label)) / np.sum(region | (pred == label))
            for label in np.unique(pred)
        ]
        covered += region.sum() * max(overlaps)
    return covered / gt.size


def slow_leak(pred: Labels, gt: Labels) -> float:
    leak = 0.0
    for label in np.unique(pred):
        region = pred == label
        for true in np.unique(gt[region]):
            leak += float(min(np.sum(region & (gt == true)), np.sum(region & (gt != true))))
    return leak / gt.size


def slow_rand(pred: Labels, gt: Labels) -> float:
    pairs = list(combinations(range(pred.size), 2))
    agreed = [bool((pred[a] == pred[b]) == (gt[a] == gt[b])) for a, b in pairs]
    return sum(agreed) / len(pairs)


@pytest.mark.parametrize(("pred", "gt"), frames()[:-1])
def test_against_readable_twins(pred: Labels, gt: Labels) -> None:
    p, g = compared(pred, gt)
    assert segmentation_covering(pred, gt) == pytest.approx(slow_covering(p, g), rel=1e-12)
    assert undersegmentation_error(pred, gt) == pytest.approx(slow_leak(p, g), rel=1e-12)
    some = slice(None, None, 15)
    assert rand_index(p[some], g[some]) == pytest.approx(slow_rand(p[some], g[some]), rel=1e-12)


def test_pairs_of_a_large_frame_do_not_overflow() -> None:
    gt = np.ones(1_000_000, np.uint8)
    pred = (np.arange(1_000_000) >= 500_000).astype(np.uint8)
    assert rand_index(pred, gt) == pytest.approx(0.5, abs=1e-6)
    assert adjusted_rand_index(pred, gt) == 0


@pytest.mark.parametrize("base", [1, 0, -2, math.inf, math.nan])
def test_bad_base(base: float) -> None:
    with pytest.raises(GeohueError, match="base"):
        variation_of_information(HALVES, HALVES, base=base)


def test_no_truths() -> None:
    with pytest.raises(GeohueError, match="truths is empty"):
        probabilistic_rand_index(HALVES, [])


@pytest.mark.parametrize(
    "measure",
    [
        variation_of_information,
        rand_index,
        adjusted_rand_index,
        segmentation_covering,
        undersegmentation_error,
        achievable_segmentation_accuracy,
    ],
)
def test_every_measure_refuses_other_shapes(measure: Any) -> None:
    with pytest.raises(GeohueError, match=r"\(8,\).*\(7,\)"):
        measure(HALVES, HALVES[:7])
