"""The labels of two views compared through the disparity."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geohue.errors import GeohueError
from geohue.stereo import view_agreement


def test_by_hand() -> None:
    """Labels swapped and one pixel shifted; the first column leaves the frame."""
    left = np.array([[0, 0, 1, 1]])
    right = np.array([[1, 0, 0, 0]])
    found = view_agreement(left, right, np.ones((1, 4)))
    assert found.compared == 3
    assert found.share == 1
    assert found.partner.tolist() == [1, 0]


def test_labels_are_paired_one_to_one() -> None:
    left = np.array([[0, 0, 1, 1, 2, 2]])
    right = np.zeros((1, 6), np.int32)
    found = view_agreement(left, right, np.zeros((1, 6)))
    assert found.share == pytest.approx(1 / 3)
    assert (found.partner >= 0).sum() == 1


@given(st.integers(0, 2**32 - 1))
def test_the_numbers_of_the_labels_do_not_matter(seed: int) -> None:
    rng = np.random.default_rng(seed)
    labels = rng.integers(0, 4, (6, 8))
    other = rng.permutation(7)[labels]
    assert view_agreement(labels, other, np.zeros((6, 8))).share == 1


def test_what_has_no_partner_takes_no_part() -> None:
    left = np.array([[0, -1, 1]])
    nothing = view_agreement(left, np.array([[0, 0, -1]]), np.array([[np.nan, 0, 0]]))
    assert nothing.share is None
    assert nothing.compared == 0
    assert nothing.partner.tolist() == [-1, -1]
    assert view_agreement(left, left, np.zeros((1, 3))).compared == 2


def test_bad_labels_are_refused() -> None:
    with pytest.raises(GeohueError, match="whole numbers"):
        view_agreement(np.zeros((2, 2)), np.zeros((2, 2), int), np.zeros((2, 2)))  # type: ignore[arg-type]
    with pytest.raises(GeohueError, match="differ in size"):
        view_agreement(np.zeros((2, 2), int), np.zeros((2, 3), int), np.zeros((2, 2)))
