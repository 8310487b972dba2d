"""Hierarchies at the best common threshold and at each frame's best."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.measures.boundary import boundary_precision_recall_f
from geohue.measures.hierarchy import Curve, best_levels, hierarchy_curve
from geohue.measures.partition import rand_index, segmentation_covering, variation_of_information

Labels = NDArray[np.int64]

GT = np.array([[1, 1, 1, 1, 2, 2, 2, 2]])
EIGHTHS = np.arange(8)[None]
QUARTERS = EIGHTHS // 2
WHOLE = np.zeros((1, 8), int)


def curve(
    thresholds: list[float], voi: list[float], counts: list[list[int]] | None = None
) -> Curve:
    regions = np.array([voi, [1 - v / 10 for v in voi], [1 - v / 5 for v in voi]])
    return Curve(np.array(thresholds), regions, None if counts is None else np.array(counts).T)


class TestCurve:
    def test_each_level_is_measured_as_alone(self) -> None:
        levels = [(3.0, WHOLE), (0.5, QUARTERS), (0.0, EIGHTHS), (1.0, GT)]
        found = hierarchy_curve(levels, GT, tolerance=0)
        assert found.thresholds.tolist() == [0, 0.5, 1, 3]
        assert found.boundary is not None
        for i, labels in enumerate((EIGHTHS, QUARTERS, GT, WHOLE)):
            assert found.regions[0, i] == variation_of_information(labels, GT).total
            assert found.regions[1, i] == rand_index(labels, GT)
            assert found.regions[2, i] == segmentation_covering(labels, GT)
            scores = boundary_precision_recall_f(labels, GT, tolerance=0)
            hits, predicted, hit, true = found.boundary[:, i]
            assert true == 1
            assert (hits / predicted if predicted else 1) == scores.precision
            assert hit / true == scores.recall

    def test_a_function_is_called_at_the_thresholds(self) -> None:
        made = hierarchy_curve(lambda t: EIGHTHS // int(t), GT, thresholds=[4, 2])
        listed = hierarchy_curve([(2, EIGHTHS // 2), (4, EIGHTHS // 4)], GT)
        assert np.array_equal(made.thresholds, listed.thresholds)
        assert np.array_equal(made.regions, listed.regions)

    def test_clouds_have_no_boundaries(self) -> None:
        assert hierarchy_curve([(0, GT[0])], GT[0]).boundary is None
        assert hierarchy_curve([(0, GT)], GT, boundaries=False).boundary is None
        assert set(best_levels([hierarchy_curve([(0, GT[0])], GT[0])])) == {
            "voi_bits",
            "rand",
            "covering",
        }

    def test_ignored_pixels(self) -> None:
        gt = np.where(np.arange(8) < 4, GT, 0)
        assert hierarchy_curve([(0, QUARTERS)], gt).regions[0, 0] == 1
        assert hierarchy_curve([(0, QUARTERS)], gt, None).regions[0, 0] == 1
        halves = EIGHTHS // 4
        assert hierarchy_curve([(0, halves)], gt, None).regions[0, 0] == 0

    def test_refusals(self) -> None:
        with pytest.raises(GeohueError, match="at which thresholds"):
            hierarchy_curve(lambda _: GT, GT)
        with pytest.raises(GeohueError, match="of its own"):
            hierarchy_curve([(0, GT)], GT, thresholds=[0])
        for levels in ([], [(1.0, GT), (1, GT)], [(float("nan"), GT)]):
            with pytest.raises(GeohueError, match="all different"):
                hierarchy_curve(levels, GT)
        with pytest.raises(GeohueError, match="curves is empty"):
            best_levels([])


class TestBest:
    def test_by_hand(self) -> None:
        one = curve([0, 1, 2], [3.0, 1.0, 2.0])
        other = curve([0, 1, 2], [4.0, 3.0, 1.0])
        best = best_levels([one, other])
        # Means 3.5, 2, 1.5; the bests 1 and 1.
        assert best["voi_bits"] == (1.5, 2, 1)
        assert best["rand"] == pytest.approx((0.85, 2, 0.9))
        assert best["covering"] == pytest.approx((0.7, 2, 0.8))
        assert "boundary_f" not in best

    def test_thresholds_that_differ(self) -> None:
        # At 0 | 1 | 2 | 3: one has 5, 5, 1, 1 (its first level holds below 2); other 2, 4, 4, 0.
        one, other = curve([2], [1.0]), curve([0, 1, 3], [2.0, 4.0, 0.5])
        assert best_levels([one, other])["voi_bits"] == (0.75, 3, 0.75)
        other = curve([0, 1, 3], [2.0, 4.0, 9.0])
        assert best_levels([one, other])["voi_bits"] == (1.5, 0, 1.5)
        early = curve([0, 1], [2.0, 1.0])
        # At 3 the last level of `early` still holds.
        assert best_levels([early, curve([0, 3], [2.0, 1.0])])["voi_bits"] == (1, 3, 1)

    def test_of_equal_thresholds_the_lowest(self) -> None:
        assert best_levels([curve([4, 5], [1.0, 1.0])])["voi_bits"].threshold == 4

    def test_boundaries_are_pooled(self) -> None:
        # Hits, predicted, found, true.
        one = curve([0, 1], [0.0, 0.0], [[10, 40, 10, 10], [8, 8, 8, 10]])
        other = curve([0, 1], [0.0, 0.0], [[30, 30, 30, 40], [10, 10, 10, 40]])
        best = best_levels([one, other])["boundary_f"]
        fine = 2 * (40 / 70) * (40 / 50) / (40 / 70 + 40 / 50)
        coarse = 2 * 1 * (18 / 50) / (1 + 18 / 50)
        assert fine > coarse
        assert best.ods == pytest.approx(fine)
        assert best.threshold == 0
        assert best.ois == pytest.approx(2 * 1 * (38 / 50) / (1 + 38 / 50))  # one: 1, other: 0

    def test_nothing_to_find_and_nothing_found(self) -> None:
        flat = best_levels([curve([0], [0.0], [[0, 0, 0, 0]])])
        assert flat["boundary_f"].ods == 1
        missed = best_levels([curve([0], [0.0], [[0, 5, 0, 5]])])
        assert missed["boundary_f"].ods == 0

    def test_a_perfect_level(self) -> None:
        levels = [(0.0, EIGHTHS), (1.0, GT), (2.0, WHOLE)]
        best = best_levels([hierarchy_curve(levels, GT, tolerance=0)] * 2)
        assert best["voi_bits"] == (0, 1, 0)
        for name in ("rand", "covering", "boundary_f"):
            assert best[name] == (1, 1, 1)


@given(
    st.lists(hnp.arrays(np.int64, (2, 6), elements=st.integers(0, 3)), min_size=1, max_size=4),
    hnp.arrays(np.int64, (2, 6), elements=st.integers(1, 3)),
    st.lists(st.integers(0, 5), min_size=4, max_size=4, unique=True),
)
def test_the_own_best_is_never_worse(maps: list[Labels], gt: Labels, places: list[int]) -> None:
    half = len(maps) // 2 + 1
    one = [(float(t), labels) for t, labels in zip(places, maps[:half], strict=False)]
    other = [(float(t), labels) for t, labels in zip(places[::-1], maps[-half:], strict=False)]
    best = best_levels([hierarchy_curve(levels, gt) for levels in (one, other)])
    assert best["voi_bits"].ois <= best["voi_bits"].ods + 1e-12
    assert best["rand"].ois >= best["rand"].ods - 1e-12
    assert best["covering"].ois >= best["covering"].ods - 1e-12
    alone = best_levels([hierarchy_curve(one, gt)])
    for found in alone.values():
        assert found.ods == pytest.approx(found.ois)
