"""The table of overlaps, and what it refuses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.measures.contingency import contingency_table

PRED = np.array([[-1, 4, 4], [9, 9, 4]], np.int32)
GT = np.array([[1, 1, 0], [7, 1, 1]], np.uint16)


def test_by_hand() -> None:
    table = contingency_table(PRED, GT)
    assert table.toarray().tolist() == [[1, 0], [2, 0], [1, 1]]
    assert table.pred_labels.tolist() == [-1, 4, 9]
    assert table.gt_labels.tolist() == [1, 7]
    assert table.pred_sizes.tolist() == [1, 2, 2]
    assert table.gt_sizes.tolist() == [4, 1]
    assert table.n_pixels == 5


def test_unlabelled_left_out() -> None:
    table = contingency_table(PRED, GT, keep_unlabelled=False)
    assert table.pred_labels.tolist() == [4, 9]
    assert table.n_pixels == 4


def test_other_ignore() -> None:
    assert contingency_table(PRED, GT, ignore=1).toarray().tolist() == [[1, 0], [0, 1]]
    assert contingency_table(PRED, GT, ignore=None).n_pixels == 6


def test_masks_and_clouds_are_labels() -> None:
    table = contingency_table(np.array([True, False, True]), np.array([3, 3, 5]))
    assert table.toarray().tolist() == [[1, 0], [1, 1]]


def label_pairs() -> st.SearchStrategy[NDArray[Any]]:
    """Small labels, and the ends of the type, whose range no table can span."""
    values = {
        kind: st.integers(-3, 3) | st.sampled_from([-(2 ** (bits - 1)), 2 ** (bits - 1) - 1])
        for kind, bits in (("int8", 8), ("int32", 32), ("int64", 64))
    }
    return st.sampled_from(sorted(values)).flatmap(
        lambda kind: hnp.arrays(
            kind, st.tuples(st.just(2), st.integers(1, 40)), elements=values[kind]
        )
    )


@given(label_pairs())
def test_equals_a_loop(pair: NDArray[Any]) -> None:
    pred, gt = pair
    table = contingency_table(pred, gt, ignore=None)
    assert table.pred_labels.tolist() == sorted(set(pred.tolist()))
    assert table.gt_labels.tolist() == sorted(set(gt.tolist()))
    loop = [
        [int(np.sum((pred == i) & (gt == j))) for j in table.gt_labels] for i in table.pred_labels
    ]
    assert table.toarray().tolist() == loop
    assert table.pred_sizes.tolist() == [sum(row) for row in loop]
    assert table.gt_sizes.tolist() == [sum(col) for col in zip(*loop, strict=True)]
    assert table.counts.dtype == np.int64
    assert table.counts.min() >= 1


@given(hnp.arrays(np.uint8, (3, 4)))
def test_unsigned_labels_have_no_unlabelled(pred: NDArray[Any]) -> None:
    gt = np.ones((3, 4), int)
    assert contingency_table(pred, gt, keep_unlabelled=False).n_pixels == 12


@pytest.mark.parametrize(
    ("pred", "gt", "message"),
    [
        (np.zeros((2, 3), int), np.ones((3, 2), int), r"\(2, 3\).*\(3, 2\).*crop"),
        (
            np.zeros((2, 3)),
            np.ones((2, 3), int),
            r"pred has shape \(2, 3\) and type float64.*astype",
        ),
        (np.zeros((2, 3), int), np.full((2, 3), np.nan), r"gt has shape \(2, 3\) and type float64"),
        (
            np.zeros((2, 3), int),
            np.zeros((2, 3), int),
            r"\(2, 3\).*no pixel.*ignore=0.*ignore=None",
        ),
        (np.zeros(0, int), np.zeros(0, int), r"\(0,\).*no pixel"),
    ],
)
def test_refusals(pred: NDArray[Any], gt: NDArray[Any], message: str) -> None:
    with pytest.raises(GeohueError, match=message):
        contingency_table(pred, gt)


def test_all_unlabelled_left_out() -> None:
    with pytest.raises(GeohueError, match="keep_unlabelled=False"):
        contingency_table(np.full(3, -1), np.ones(3, int), keep_unlabelled=False)
