"""Boundary measures: cases worked by hand, readable twins, laws, ignored pixels."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.measures.boundary import (
    boundary_displacement_error,
    boundary_distances,
    boundary_map,
    boundary_precision_recall_f,
)

Labels = NDArray[np.int64]


def columns(text: str, rows: int = 6) -> Labels:
    """Label map with the digits of `text` as columns."""
    return np.tile([int(digit) for digit in text], (rows, 1))


class TestMap:
    def test_corner(self) -> None:
        labels = np.array([[1, 1, 1], [1, 1, 2], [1, 3, 3]])
        assert boundary_map(labels).astype(int).tolist() == [[0, 0, 1], [0, 1, 1], [1, 0, 0]]

    def test_one_region_has_none(self) -> None:
        assert not boundary_map(np.full((4, 5), 3)).any()

    def test_border_of_ignored_is_none(self) -> None:
        labels = columns("1002233")
        assert np.flatnonzero(boundary_map(labels, ignore=0)[0]).tolist() == [4]
        assert np.flatnonzero(boundary_map(labels)[0]).tolist() == [0, 2, 4]

    def test_needs_a_grid(self) -> None:
        with pytest.raises(GeohueError, match=r"\(7,\).*\(H, W\).*partition"):
            boundary_map(np.arange(7))


class TestByHand:
    GT = columns("1111111222222233333333")
    PRED = columns("1111122222222222224444")

    # True lines at columns 6 and 13, predicted ones at 4 and 17: 2 and 4 pixels apart.
    @pytest.mark.parametrize(
        ("tolerance", "share"), [(0, 0.0), (1.9, 0.0), (2, 0.5), (3.9, 0.5), (4, 1.0)]
    )
    def test_tolerance(self, tolerance: float, share: float) -> None:
        scores = boundary_precision_recall_f(self.PRED, self.GT, tolerance=tolerance)
        assert scores == (share, share, share)

    def test_displacement(self) -> None:
        assert boundary_displacement_error(self.PRED, self.GT) == 3

    def test_harmonic_mean(self) -> None:
        # All of the truth is found; a third line is wrong.
        pred = columns("1111111222222233333344")
        assert boundary_precision_recall_f(pred, self.GT, tolerance=1) == pytest.approx(
            (2 / 3, 1, 0.8)
        )

    def test_default_tolerance(self) -> None:
        gt = np.ones((480, 640), int)
        gt[:, 300:] = 2
        assert boundary_distances(gt, gt).tolerance == pytest.approx(6)
        assert boundary_precision_recall_f(np.roll(gt, 6, 1)[:, 6:], gt[:, 6:]).recall == 0
        assert boundary_precision_recall_f(np.roll(gt, 5, 1)[:, 5:], gt[:, 5:]).recall == 1


class TestWithoutBoundary:
    FLAT = np.ones((3, 4), int)
    SPLIT = columns("1122", rows=3)

    def test_neither(self) -> None:
        assert boundary_precision_recall_f(self.FLAT, self.FLAT) == (1, 1, 1)
        assert boundary_displacement_error(self.FLAT, self.FLAT) == 0

    def test_nothing_predicted(self) -> None:
        assert boundary_precision_recall_f(self.FLAT, self.SPLIT) == (1, 0, 0)
        assert boundary_displacement_error(self.FLAT, self.SPLIT) == 5

    def test_nothing_to_find(self) -> None:
        assert boundary_precision_recall_f(self.SPLIT, self.FLAT) == (0, 1, 0)
        assert boundary_displacement_error(self.SPLIT, self.FLAT) == 5


class TestIgnored:
    def test_border_of_an_ignored_area_is_not_to_be_found(self) -> None:
        gt = columns("1111100000000")
        assert boundary_precision_recall_f(np.ones_like(gt), gt, tolerance=2) == (1, 1, 1)
        assert boundary_displacement_error(np.ones_like(gt), gt) == 0

    @pytest.mark.parametrize("tolerance", [0, 0.5, 1, 2])
    @pytest.mark.parametrize("pred", ["1111122222222", "1111112222222", "1111111111122"])
    def test_a_boundary_there_is_not_wrong(self, pred: str, tolerance: float) -> None:
        gt = columns("1111100000000")
        assert boundary_precision_recall_f(columns(pred), gt, tolerance=tolerance) == (1, 1, 1)
        assert boundary_displacement_error(columns(pred), gt, tolerance=tolerance) == 0

    def test_a_boundary_further_off_is_wrong(self) -> None:
        pred, gt = columns("1122222222222"), columns("1111100000000")
        assert boundary_precision_recall_f(pred, gt, tolerance=2) == (0, 1, 0)
        assert boundary_precision_recall_f(pred, gt, tolerance=4) == (1, 1, 1)

    @pytest.mark.parametrize("pred", ["1112222222222", "1111112222222", "1111111112222"])
    def test_a_thin_gap_between_objects_is_a_boundary(self, pred: str) -> None:
        # The gap is 4 wide: its middle line lies 2 from either side.
        gt = columns("1111000022222")
        assert boundary_precision_recall_f(np.ones_like(gt), gt, tolerance=2).recall == 0
        assert boundary_precision_recall_f(columns(pred), gt, tolerance=3) == (1, 1, 1)

    def test_a_thin_gap_in_one_object_is_none(self) -> None:
        gt = columns("1111001111111")
        assert boundary_precision_recall_f(np.ones_like(gt), gt, tolerance=2) == (1, 1, 1)

    def test_a_wide_gap_is_no_boundary(self) -> None:
        gt = columns("1111000002222")
        assert boundary_distances(gt, gt, tolerance=2).gt_to_pred.size == 0
        assert boundary_distances(gt, gt, tolerance=3).gt_to_pred.size == 6

    def test_another_label_is_ignored(self) -> None:
        gt = columns("1111199999999")
        assert boundary_precision_recall_f(np.ones_like(gt), gt, 9, tolerance=2).recall == 1
        assert boundary_precision_recall_f(np.ones_like(gt), gt, None, tolerance=2).recall == 0

    def test_all_ignored(self) -> None:
        with pytest.raises(GeohueError, match=r"\(6, 3\).*ignored label 0"):
            boundary_displacement_error(columns("123"), columns("000"))


class TestRefusals:
    @pytest.mark.parametrize("tolerance", [-1, math.inf, math.nan])
    def test_tolerance(self, tolerance: float) -> None:
        with pytest.raises(GeohueError, match="tolerance"):
            boundary_precision_recall_f(columns("12"), columns("12"), tolerance=tolerance)

    @pytest.mark.parametrize(
        ("pred", "message"),
        [
            (np.ones((6, 2)), "float64"),
            (np.ones((5, 2), int), r"\(5, 2\).*\(6, 2\)"),
        ],
    )
    def test_labels(self, pred: NDArray[Any], message: str) -> None:
        with pytest.raises(GeohueError, match=message):
            boundary_displacement_error(pred, columns("12"))

    def test_clouds(self) -> None:
        with pytest.raises(GeohueError, match=r"\(3,\)"):
            boundary_displacement_error(np.arange(3), np.arange(3), None)


def slow_boundary(labels: Labels, ignore: int | None = None) -> list[tuple[int, int]]:
    height, width = labels.shape
    return [
        (y, x)
        for y in range(height)
        for x in range(width)
        for dy, dx in [(0, 1), (1, 0)]
        if y + dy < height and x + dx < width
        if ignore not in (labels[y, x], labels[y + dy, x + dx])
        if labels[y, x] != labels[y + dy, x + dx]
    ]


def slow_distances(
    pred: Labels, gt: Labels, tolerance: float, ignore: int | None
) -> tuple[list[float], list[float]]:
    """Both rules of the module, pixel by pixel. Ties for the nearest label must not arise."""

    def nearest(pixel: tuple[int, int], others: list[tuple[int, int]], empty: float) -> float:
        return min((math.dist(pixel, other) for other in others), default=empty)

    pixels = list(np.ndindex(*gt.shape))
    ignored = [p for p in pixels if gt[p] == ignore]
    labelled = [p for p in pixels if gt[p] != ignore]
    closed = gt.copy()
    for p in ignored:
        closest = min(labelled, key=lambda q: math.dist(p, q))
        if math.dist(p, closest) <= tolerance:
            closed[p] = gt[closest]
    of_gt, of_pred = sorted(set(slow_boundary(closed, ignore))), sorted(set(slow_boundary(pred)))
    diagonal = math.hypot(*gt.shape)
    there = [
        nearest(p, of_gt, diagonal)
        for p in of_pred
        if nearest(p, of_gt, diagonal) <= tolerance
        or nearest(p, ignored, math.inf) > max(tolerance, 1)
    ]
    return there, [nearest(p, of_pred, diagonal) for p in of_gt]


maps = st.tuples(st.integers(1, 6), st.integers(1, 7)).flatmap(
    lambda shape: st.tuples(
        hnp.arrays(np.int64, shape, elements=st.integers(-1, 1)),
        hnp.arrays(np.int64, shape, elements=st.integers(1, 2)),
    )
)


def agree(pred: Labels, gt: Labels, tolerance: float, ignore: int | None) -> None:
    there, back = slow_distances(pred, gt, tolerance, ignore)
    fast = boundary_distances(pred, gt, ignore, tolerance=tolerance)
    assert fast.pred_to_gt.tolist() == pytest.approx(there)
    assert fast.gt_to_pred.tolist() == pytest.approx(back)


@settings(deadline=None)
@given(maps, st.sampled_from([0, 1, 1.5, 3]))
def test_against_the_readable_twin(pair: tuple[Labels, Labels], tolerance: float) -> None:
    agree(*pair, tolerance, None)


@settings(deadline=None)
@given(maps, st.sampled_from([0, 0.5, 0.99]), st.data())
def test_twin_with_ignored_pixels(
    pair: tuple[Labels, Labels], tolerance: float, data: st.DataObject
) -> None:
    # Below one pixel no gap closes, so no tie for the nearest label can arise.
    pred, gt = pair
    gaps = data.draw(hnp.arrays(np.bool_, gt.shape))
    gaps.flat[0] = False
    agree(pred, np.where(gaps, 0, gt), tolerance, 0)


@pytest.mark.parametrize("tolerance", [0, 1, 2, 2.5, 6])
@pytest.mark.parametrize("seed", range(4))
def test_twin_with_ignored_strips(seed: int, tolerance: float) -> None:
    # Strips two wide: each of their pixels has one nearest labelled pixel.
    rng = np.random.default_rng(seed)
    gt = np.kron(rng.integers(1, 4, (1, 4)), np.ones((5, 5), int))
    gt[:, 4:6] = gt[:, 14:16] = 0
    agree(rng.integers(-1, 2, gt.shape), gt, tolerance, 0)


@settings(deadline=None)
@given(maps)
def test_laws(pair: tuple[Labels, Labels]) -> None:
    pred, gt = pair
    assert boundary_precision_recall_f(gt, gt, None) == (1, 1, 1)
    assert boundary_displacement_error(gt, gt, None) == 0
    there = boundary_precision_recall_f(pred, gt, None, tolerance=1)
    back = boundary_precision_recall_f(gt, pred, None, tolerance=1)
    assert there == pytest.approx((back.recall, back.precision, back.f))
    wider = boundary_precision_recall_f(pred, gt, None, tolerance=2)
    assert all(0 <= narrow <= wide <= 1 for narrow, wide in zip(there, wider, strict=True))
    error = boundary_displacement_error(pred, gt, None)
    assert error == pytest.approx(boundary_displacement_error(gt, pred, None))
    assert 0 <= error <= math.hypot(*gt.shape) + 1e-9
    renamed = np.array([40, 7, -1])[pred + 1]
    assert boundary_precision_recall_f(renamed, gt, None, tolerance=1) == there
