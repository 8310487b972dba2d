"""Object measures: values worked by hand, laws, and the slow twin."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.measures.objects import (
    BackgroundFrom,
    ObjectScores,
    match_objects,
    object_precision_recall_f,
)
from geohue.measures.outlines import object_boundary_precision_recall_f
from twins.objects import literal_objects, literal_outline, literal_outlines, literal_overlap, value

Labels = NDArray[np.int64]
TABLE = (1,)


def maps(low: int, high: int) -> st.SearchStrategy[Labels]:
    return hnp.arrays(np.int64, (4, 5), elements=st.integers(low, high))


def spread(*counts: tuple[int, int, int]) -> tuple[Labels, Labels]:
    """Make labels with `n` pixels of predicted `p` and true `g` for each (p, g, n)."""
    parts = [([p] * n, [g] * n) for p, g, n in counts]
    pred, gt = (np.concatenate([part[side] for part in parts]) for side in (0, 1))
    return pred, gt


class TestByHand:
    # Table 1 with 40 pixels, objects 2 (20) and 3 (10). Segment 10: the table and 4 of object 2.
    # Segment 11: 12 of object 2 and 3 of the table. Segment 12: 4 of object 2. 13: object 3.
    PRED, GT = spread(
        (10, 1, 37), (10, 2, 4), (11, 1, 3), (11, 2, 12), (12, 2, 4), (13, 3, 9), (-1, 3, 1)
    )

    def test_background_from_truth(self) -> None:
        # 10 is background; 11-2 and 13-3 are pairs; 12 has no partner.
        found = object_precision_recall_f(self.PRED, self.GT, TABLE)
        precision, recall = 21 / (15 + 4 + 9), 21 / 30
        # F of the pairs: 24/35 and 18/19.
        f = 2 * precision * recall / (precision + recall)
        assert found == pytest.approx((precision, recall, f, 1 / 2))

    def test_background_from_prediction(self) -> None:
        # Now 10 is an object as well; no object is better off with it.
        found = object_precision_recall_f(self.PRED, self.GT, TABLE, background_from="prediction")
        assert found[:2] == pytest.approx((21 / (41 + 28), 21 / 30))

    def test_without_a_background_the_table_is_an_object(self) -> None:
        found = object_precision_recall_f(self.PRED, self.GT)
        # 10-1, 11-2, 13-3 of 69 predicted (the one without a label is background) and 70 true.
        assert found[:2] == pytest.approx((58 / 69, 58 / 70))
        assert found.detected == pytest.approx(2 / 3)

    def test_the_sum_counts_not_the_first_come(self) -> None:
        # Alone, 10 would take object 2 (F 0.75); together, 10-3 and 11-2 are worth more.
        pred, gt = spread((10, 2, 6), (10, 3, 4), (11, 2, 4))
        matching = match_objects(pred, gt)
        table = matching.table
        pairs = zip(table.pred_labels[matching.pred], table.gt_labels[matching.gt], strict=True)
        f = {(10, 2): 12 / 20, (10, 3): 8 / 14, (11, 2): 8 / 14}
        assert f[10, 3] + f[11, 2] > f[10, 2]
        assert sorted(pairs) == [(10, 3), (11, 2)]

    def test_ties_go_to_the_larger_overlap(self) -> None:
        # Object 2 has 12 pixels. F of 5 is 2 * 3 / (3 + 12), of 6 is 2 * 6 / (18 + 12): the same.
        pred, gt = spread((5, 2, 3), (6, 2, 6), (6, 1, 6), (6, 3, 6), (-1, 2, 3))
        for first, second in ((5, 6), (6, 5)):
            named = np.where(pred == 5, first, np.where(pred == 6, second, pred))
            found = object_precision_recall_f(named, gt, [1, 3], background_from="prediction")
            assert found[:2] == pytest.approx((6 / 21, 6 / 12))

    def test_threshold_of_detection(self) -> None:
        # F = 6/8, exactly enough.
        assert object_precision_recall_f(*spread((5, 2, 3), (6, 2, 2))).detected == 1
        assert object_precision_recall_f(*spread((5, 2, 30), (6, 2, 21))).detected == 0

    def test_ignored_pixels(self) -> None:
        pred, gt = spread((5, 2, 3), (6, 0, 9), (5, 0, 4))
        assert object_precision_recall_f(pred, gt) == ObjectScores(1, 1, 1, 1)
        # 0 as background: 5 has 3 on the object, 4 beside it.
        assert object_precision_recall_f(pred, gt, [0]) == ObjectScores(1, 0, 0, 0)
        found = object_precision_recall_f(pred, gt, [0], background_from="prediction")
        assert found[:2] == pytest.approx((3 / 16, 1))

    def test_a_tie_with_the_background_stays_an_object(self) -> None:
        assert object_precision_recall_f(*spread((5, 2, 3), (5, 1, 3)), TABLE).recall == 1


class TestNothing:
    def test_no_predicted_object(self) -> None:
        assert object_precision_recall_f(*spread((-1, 2, 3))) == (1, 0, 0, 0)
        found = object_boundary_precision_recall_f(np.full((1, 4), -1), np.array([[2, 2, 3, 3]]))
        assert found == (1, 0, 0)

    def test_no_true_object(self) -> None:
        pred, gt = spread((5, 1, 3))
        assert object_precision_recall_f(pred, gt, TABLE) == (1, 1, 1, 1)
        found = object_precision_recall_f(pred, gt, TABLE, background_from="prediction")
        assert found == (0, 1, 0, 0)

    def test_refusals(self) -> None:
        flat = np.ones(3, int)
        with pytest.raises(GeohueError, match="choose among truth, prediction"):
            match_objects(flat, flat, background_from="guess")  # type: ignore[arg-type]
        with pytest.raises(GeohueError, match=r"need \(H, W\)"):
            object_boundary_precision_recall_f(flat, flat)
        with pytest.raises(GeohueError, match="slack -1"):
            object_boundary_precision_recall_f(flat[None], flat[None], slack=-1)


class TestOutlines:
    def test_slack_is_a_disc_of_another_library(self) -> None:
        from skimage.morphology import dilation, disk

        rows, columns = np.indices((60, 80))
        masks = [(rows - 30) ** 2 + (columns - c) ** 2 < 300 for c in (38, 43)]
        pred, gt = (np.where(mask, 2, 1) for mask in masks)
        mine, theirs = (literal_outline(mask) for mask in masks)
        expected = (
            (mine & dilation(theirs, disk(3))).sum() / mine.sum(),
            (theirs & dilation(mine, disk(3))).sum() / theirs.sum(),
        )
        found = object_boundary_precision_recall_f(pred, gt, TABLE, slack=3)
        assert 0 < expected[0] < 1
        assert found[:2] == pytest.approx(expected)

    @pytest.mark.parametrize("shape", [(480, 640), (600, 800)])
    def test_slack_by_default(self, shape: tuple[int, int]) -> None:
        # 0.003 of 800 pixels is 2.4, of 1000 it is 3: so 3 match and 4 do not.
        gt = np.ones(shape, int)
        gt[100:300, 100:300] = 2
        moved = {d: np.roll(gt, d, axis=1) for d in (3, 4)}
        exact = object_boundary_precision_recall_f(moved[3], gt, TABLE)
        assert exact == (1, 1, 1)
        assert object_boundary_precision_recall_f(moved[4], gt, TABLE).recall < 0.6

    def test_a_narrow_gap_is_closed(self) -> None:
        gt = np.array([[2, 2, 2, 0, 0, 3, 3, 3]])
        pred = np.array([[2, 2, 2, 2, 3, 3, 3, 3]])
        assert object_boundary_precision_recall_f(pred, gt, slack=1) == (1, 1, 1)
        none = object_boundary_precision_recall_f(np.full_like(pred, 2), gt, slack=1)
        assert none == (1, 0, 0)

    def test_what_stays_ignored_neither_rewards_nor_punishes(self) -> None:
        gt = np.array([[2] * 6 + [0] * 9 + [3] * 6])
        pred = np.where(np.arange(21) < 10, 2, 3)[None]  # ends somewhere in the gap
        assert object_boundary_precision_recall_f(pred, gt, slack=1) == (1, 1, 1)
        early = np.where(np.arange(21) < 5, 2, 3)[None]  # its line is two pixels from the gap
        assert object_boundary_precision_recall_f(early, gt, slack=2) == (1, 1, 1)
        far = np.where(np.arange(21) < 4, 2, 3)[None]
        assert object_boundary_precision_recall_f(far, gt, slack=2).precision == 0
        assert object_boundary_precision_recall_f(far, gt, slack=1).precision == 0

    def test_a_line_of_another_object_is_of_no_use(self) -> None:
        gt = np.array([[1, 1, 2, 2, 2, 2, 1, 1, 3, 3, 1]])
        # The object is missed, a false one starts where it ends.
        pred = np.array([[-1, -1, -1, -1, -1, -1, 5, 5, -1, -1, -1]])
        found = object_boundary_precision_recall_f(
            pred, gt, TABLE, background_from="prediction", slack=1
        )
        assert found == (0, 0, 0)


@pytest.mark.parametrize("source", ["truth", "prediction"])
@given(pred=maps(-1, 3), gt=maps(1, 4), slack=st.sampled_from([0, 1, 1.5]))
@settings(max_examples=50)
def test_twin(source: BackgroundFrom, pred: Labels, gt: Labels, slack: float) -> None:
    predicted, true, pairs = literal_objects(pred, gt, TABLE, source == "truth")
    found = object_precision_recall_f(pred, gt, TABLE, None, background_from=source)
    assert found[:2] == pytest.approx(literal_overlap(predicted, true, pairs))
    # Other pairs may be worth the same and have other outlines: those of the library, then.
    matching = match_objects(pred, gt, TABLE, None, source)
    chosen = list(
        zip(
            np.searchsorted(np.flatnonzero(matching.is_object), matching.pred).tolist(),
            np.searchsorted(np.flatnonzero(matching.is_true_object), matching.gt).tolist(),
            strict=True,
        )
    )
    assert value(predicted, true, chosen) == pytest.approx(value(predicted, true, pairs))
    lines = object_boundary_precision_recall_f(
        pred, gt, TABLE, None, background_from=source, slack=slack
    )
    assert lines[:2] == pytest.approx(literal_outlines(predicted, true, chosen, slack))


@given(maps(1, 4))
def test_the_truth_is_perfect(gt: Labels) -> None:
    gt[0, 0] = 2
    sources: tuple[BackgroundFrom, ...] = ("truth", "prediction")
    for source in sources:
        pred = np.where(gt == 1, -1, gt * 7)
        assert object_precision_recall_f(pred, gt, TABLE, background_from=source) == (1, 1, 1, 1)
        lines = object_boundary_precision_recall_f(pred, gt, TABLE, background_from=source)
        assert lines == (1, 1, 1)


@given(maps(-1, 3), maps(0, 4), st.permutations(range(4)), st.permutations(range(10, 14)))
def test_names_do_not_matter(pred: Labels, gt: Labels, mine: list[int], theirs: list[int]) -> None:
    gt[0, 0] = 2
    renamed = np.where(pred < 0, -1, np.array(mine)[pred])
    truth = np.where(gt == 0, 0, np.array(theirs)[gt - 1])
    found = object_precision_recall_f(renamed, truth, [theirs[0]])
    assert found[:3] == pytest.approx(object_precision_recall_f(pred, gt, TABLE)[:3])


@given(maps(0, 1), maps(1, 4), st.integers(1, 4))
def test_splitting_loses_all_but_the_largest_piece(halves: Labels, gt: Labels, cut: int) -> None:
    split = np.where((gt == cut) & (halves == 1), 9, gt)
    found = object_precision_recall_f(split, gt, (), None)
    lost = min(int((split == cut).sum()), int((split == 9).sum()))
    assert found[:2] == pytest.approx((1 - lost / gt.size, 1 - lost / gt.size))


def test_swapping_sides_swaps_precision_and_recall() -> None:
    rng = np.random.default_rng(3)
    pred, gt = rng.integers(1, 6, (2, 30, 40))
    there = object_precision_recall_f(pred, gt, (), None)
    back = object_precision_recall_f(gt, pred, (), None)
    assert there[:3] == pytest.approx((back.recall, back.precision, back.f))
    lines = object_boundary_precision_recall_f(pred, gt, (), None)
    lines_back = object_boundary_precision_recall_f(gt, pred, (), None)
    assert lines == pytest.approx((lines_back.recall, lines_back.precision, lines_back.f))


def test_a_table_top(data_dir: Path) -> None:
    """The parts of a real scene's objects against the objects: only what is cut up is lost."""
    from geohue.read.images.pictures import read_labels

    folder = data_dir / "mosd" / "frames" / "learn40"
    if not folder.is_dir():
        pytest.skip("no mosd/frames/learn40")
    truth, parts = (read_labels(folder / f"{n}.png") for n in ("labels_object", "labels"))
    assert object_precision_recall_f(truth - 1, truth, TABLE) == (1, 1, 1, 1)
    assert object_boundary_precision_recall_f(truth - 1, truth, TABLE) == (1, 1, 1)
    found = object_precision_recall_f(parts - 1, truth, TABLE)
    assert found.precision == found.recall  # every part lies in one object
