"""Laws of the region measures, on random partitions."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

from geohue.measures.partition import (
    VariationOfInformation,
    achievable_segmentation_accuracy,
    adjusted_rand_index,
    rand_index,
    segmentation_covering,
    undersegmentation_error,
    variation_of_information,
)

Labels = NDArray[np.int64]
EPS = 1e-12


def partitions(count: int) -> st.SearchStrategy[list[Labels]]:
    """`count` label arrays of one random size."""
    sizes = st.integers(1, 30)
    return sizes.flatmap(
        lambda n: st.lists(
            hnp.arrays(np.int64, n, elements=st.integers(-1, 5)), min_size=count, max_size=count
        )
    )


def voi(a: Labels, b: Labels) -> VariationOfInformation:
    return variation_of_information(a, b, ignore=None)


def measures(a: Labels, b: Labels) -> list[float]:
    return [
        *voi(a, b),
        rand_index(a, b, None),
        adjusted_rand_index(a, b, None),
        segmentation_covering(a, b, None),
        undersegmentation_error(a, b, None),
        achievable_segmentation_accuracy(a, b, None),
    ]


def same_partition(a: Labels, b: Labels) -> bool:
    return bool(np.array_equal(a[:, None] == a, b[:, None] == b))


@given(partitions(2))
def test_symmetry(pair: list[Labels]) -> None:
    a, b = pair
    there, back = voi(a, b), voi(b, a)
    assert np.allclose(there, (back.total, back.under, back.over), rtol=0, atol=EPS)
    assert rand_index(a, b, None) == rand_index(b, a, None)
    assert adjusted_rand_index(a, b, None) == adjusted_rand_index(b, a, None)


@given(partitions(3))
def test_voi_triangle_inequality(triple: list[Labels]) -> None:
    a, b, c = triple
    assert voi(a, c).total <= voi(a, b).total + voi(b, c).total + EPS


@given(partitions(2))
def test_perfect_only_for_equal_partitions(pair: list[Labels]) -> None:
    a, b = pair
    equal = same_partition(a, b)
    assert (voi(a, b).total == 0) == equal
    assert (rand_index(a, b, None) == 1) == equal
    assert (adjusted_rand_index(a, b, None) == 1) == equal
    assert (segmentation_covering(a, b, None) > 1 - EPS) == equal


@given(partitions(2), st.permutations(range(-1, 6)), st.permutations(range(10, 17)))
def test_names_of_labels_do_not_matter(
    pair: list[Labels], new_a: list[int], new_b: list[int]
) -> None:
    a, b = pair
    renamed = measures(np.array(new_a)[a + 1], np.array(new_b)[b + 1])
    assert np.allclose(renamed, measures(a, b), rtol=0, atol=EPS)


@given(partitions(2), st.randoms(use_true_random=False))
def test_order_of_pixels_does_not_matter(pair: list[Labels], random: object) -> None:
    a, b = pair
    order = list(range(a.size))
    random.shuffle(order)  # type: ignore[attr-defined]
    assert measures(a[order], b[order]) == measures(a, b)


@given(partitions(2))
def test_bounds(pair: list[Labels]) -> None:
    a, b = pair
    total, over, under = voi(a, b)
    assert 0 <= over <= math.log2(np.unique(a).size) + EPS
    assert 0 <= under <= math.log2(np.unique(b).size) + EPS
    assert math.isclose(total, over + under)
    assert total <= math.log2(a.size) + EPS
    assert 0 <= rand_index(a, b, None) <= 1
    assert -0.5 <= adjusted_rand_index(a, b, None) <= 1
    assert 0 < segmentation_covering(a, b, None) <= 1 + EPS


@given(partitions(2))
def test_leak_is_bounded_by_the_achievable_accuracy(pair: list[Labels]) -> None:
    a, b = pair
    missed = 1 - achievable_segmentation_accuracy(a, b, None)
    assert missed - EPS <= undersegmentation_error(a, b, None) <= min(1, 2 * missed) + EPS


@given(partitions(2))
def test_a_refinement_only_over_segments(pair: list[Labels]) -> None:
    gt, cut = pair
    finer = gt * 10 + cut
    assert voi(finer, gt).under == 0
    assert voi(gt, finer).over == 0
    assert undersegmentation_error(finer, gt, None) == 0
    assert achievable_segmentation_accuracy(finer, gt, None) == 1


@given(partitions(2))
def test_ignored_pixels_do_not_matter(pair: list[Labels]) -> None:
    pred, gt = pair
    gt[0] = 1
    other = np.where(gt == 0, 99, pred)
    assert variation_of_information(pred, gt) == variation_of_information(other, gt)
    assert segmentation_covering(pred, gt) == segmentation_covering(other, gt)
