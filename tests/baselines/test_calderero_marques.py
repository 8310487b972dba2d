"""Region merging by statistics, and the consensus of two processes."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from geohue.baselines.calderero_marques import consensus, fine_partition, segment_image, unite
from geohue.baselines.merging import Criterion, merge_costs, merge_regions, soft_histograms

Counts = NDArray[np.float64]


def counts_of(*rows: list[float]) -> Counts:
    return np.array(rows)[:, None, :]


def slow_cost(one: Counts, other: Counts, criterion: Criterion) -> float:
    total = 0.0
    for a, b in zip(one, other, strict=True):
        n1, n2 = a.sum(), b.sum()
        if n1 == 0 or n2 == 0:
            continue
        union = (a + b) / (n1 + n2)
        for counts, n in ((a, n1), (b, n2)):
            p = counts / n
            has = p > 0
            if criterion == "kl":
                total += n * (p[has] * np.log(p[has] / union[has])).sum()
            else:
                total -= n * np.log(np.sqrt(p * union).sum())
    return total


def slow_merge(
    counts: Counts, pairs: NDArray[np.int32], target: int, criterion: Criterion
) -> NDArray[np.int32]:
    """The definition: look at every pair of neighbours before every merging."""
    regions = {i: counts[i].copy() for i in range(len(counts))}
    label = np.arange(len(counts))
    neighbours = {(min(a, b), max(a, b)) for a, b in pairs.tolist()}
    while len(regions) > target and neighbours:
        cost = {p: slow_cost(regions[p[0]], regions[p[1]], criterion) for p in neighbours}
        one, other = min(neighbours, key=lambda p: (cost[p], p))
        regions[one] += regions.pop(other)
        label[label == other] = one
        renamed = [tuple(one if v == other else v for v in p) for p in neighbours]
        neighbours = {(min(a, b), max(a, b)) for a, b in renamed if a != b}
    return np.unique(label, return_inverse=True)[1].astype(np.int32)


def test_costs_by_hand() -> None:
    # Two pixels of one value, two of another: each loses log 2; BC of each with the union: 1/2^0.5.
    counts = counts_of([2, 0], [0, 2], [1, 1])
    pair = np.array([[0, 1]], np.int32)
    assert merge_costs(counts, pair)[0] == pytest.approx(4 * np.log(2))
    assert merge_costs(counts, pair, "bhattacharyya")[0] == pytest.approx(2 * np.log(2))
    empty = counts_of([2, 0], [0, 0])
    assert merge_costs(empty, pair)[0] == 0


@pytest.mark.parametrize("criterion", ["kl", "bhattacharyya"])
def test_costs_equal_the_slow_twin(criterion: Criterion) -> None:
    rng = np.random.default_rng(0)
    counts = rng.integers(0, 5, (6, 3, 4)).astype(float)
    pairs = np.array([[i, j] for i in range(6) for j in range(i)], np.int32)
    want = [slow_cost(counts[i], counts[j], criterion) for i, j in pairs]
    np.testing.assert_allclose(merge_costs(counts, pairs, criterion), want, atol=1e-12)


@pytest.mark.parametrize("criterion", ["kl", "bhattacharyya"])
@pytest.mark.parametrize("target", [1, 4, 9])
def test_merging_equals_the_slow_twin(target: int, criterion: Criterion) -> None:
    rng = np.random.default_rng(1)
    counts = rng.random((20, 2, 5)) * rng.integers(1, 30, (20, 1, 1))
    ids = np.arange(20, dtype=np.int32).reshape(4, 5)
    pairs = np.concatenate(
        [
            np.stack([ids[:, :-1].ravel(), ids[:, 1:].ravel()], axis=1),
            np.stack([ids[:-1].ravel(), ids[1:].ravel()], axis=1),
        ]
    )
    np.testing.assert_array_equal(
        merge_regions(counts, pairs, target, criterion),
        slow_merge(counts, pairs, target, criterion),
    )


def test_merging_stops_without_neighbours() -> None:
    counts = counts_of([1, 0], [1, 0], [1, 0])
    assert merge_regions(counts, np.array([[0, 1]], np.int32), 1).tolist() == [0, 0, 1]


def test_consensus_by_hand() -> None:
    # A row of four. Colour would join 0-1 and 2-3, depth 0-1 and 1-2: both agree on 0-1 only.
    color = counts_of([9, 0, 0], [9, 0, 0], [0, 9, 0], [0, 8, 1])
    depth = counts_of([9, 0, 0], [9, 0, 0], [8, 1, 0], [0, 0, 9])
    pairs = np.array([[0, 1], [1, 2], [2, 3]], np.int32)
    assert consensus(color, depth, pairs, 3).tolist() == [0, 0, 1, 2]


def test_regions_without_depth_go_by_colour() -> None:
    color = counts_of([9, 0], [8, 1], [0, 9])
    depth = counts_of([9, 0], [0, 0], [0, 9])
    pairs = np.array([[0, 1], [1, 2]], np.int32)
    assert consensus(color, depth, pairs, 2).tolist() == [0, 0, 1]


def test_without_any_depth_colour_decides() -> None:
    color = counts_of([9, 0], [8, 1], [0, 9])
    pairs = np.array([[0, 1], [1, 2]], np.int32)
    assert consensus(color, np.zeros((3, 1, 2)), pairs, 2).tolist() == [0, 0, 1]


def test_uniting_stops_at_the_number() -> None:
    pairs = np.array([[0, 1], [2, 3], [1, 2]], np.int32)
    assert unite(4, pairs, 3).tolist() == [0, 0, 1, 2]
    assert unite(4, pairs, 1).tolist() == [0, 0, 0, 0]


def test_histograms_keep_the_mass() -> None:
    values = np.random.default_rng(2).random((50, 2)).astype(np.float32)
    regions = np.repeat(np.arange(5, dtype=np.int32), 10)
    counts = soft_histograms(values, regions, 5, 8)
    np.testing.assert_allclose(counts.sum(axis=2), 10)
    flat = soft_histograms(np.ones((4, 1), np.float32), np.zeros(4, np.int32), 1, 8)
    assert flat[0, 0].tolist() == [4, 0, 0, 0, 0, 0, 0, 0]


def test_superpixels_keep_to_depth_and_colour() -> None:
    lab = np.zeros((30, 40, 3), np.float32)
    lab[:15, :, 0] = 80
    depth = np.ones((30, 40), np.float32)
    depth[:, 20:] = 2
    labels = fine_partition(lab, depth, 40)
    quarter = (np.arange(30)[:, None] >= 15) * 2 + (np.arange(40) >= 20)
    pure = [len(np.unique(quarter[labels == i])) == 1 for i in range(labels.max() + 1)]
    assert all(pure)
    assert len(np.unique(segment_image(lab, depth, 4)[:, :20])) == 2
