"""Measures of steadiness, by hand."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from geohue import GeohueError
from geohue.measures import flicker, identity_switches, steadiness
from geohue.measures.temporal import near_borders


def ints(rows: list[list[int]]) -> NDArray[np.int32]:
    return np.array(rows, np.int32)


def test_labels_are_followed_to_their_new_places() -> None:
    before = ints([[0, 0, 0, 0, 0, 1, 1, 1]])
    after = ints([[9, 0, 0, 0, 0, 0, 0, 1]])  # one to the right; the first 1 became 0
    target = np.array([[1, 2, 3, 4, 5, 6, 7, -1]])
    found = steadiness(before, after, target, width=1)
    assert tuple(found) == pytest.approx((6 / 7, 1 / 2, 7))
    assert tuple(steadiness(before, before, np.arange(8)[None])) == (1, 1, 8)
    assert np.isnan(steadiness(before, after, np.full((1, 8), -1)).kept)
    with pytest.raises(GeohueError, match="target"):
        steadiness(before, after, np.arange(7)[None])


def test_a_label_for_one_frame_flickers_a_change_does_not() -> None:
    here = np.arange(4)[None]
    films = [ints([[0, 0, 0, 0]]), ints([[0, 1, 1, 2]]), ints([[0, 0, 1, 3]])]
    assert flicker(films, [here, here]) == 1 / 4
    there = np.array([[0, -1, 2, 3]])
    assert flicker(films, [here, there]) == 0
    assert np.isnan(flicker(films[:2], [here]))


def test_switches_of_things_by_their_own_label() -> None:
    truth = ints([[0] * 60 + [1] * 60])
    good, swapped = truth + 5, 6 - truth
    merged = np.zeros_like(truth)
    assert identity_switches([truth] * 3, [good, good, good]) == {0: 0, 1: 0}
    assert identity_switches([truth] * 3, [good, swapped, good]) == {0: 2, 1: 2}
    # While both are one segment, one of them has no own; it may have its old label after that.
    assert identity_switches([truth] * 2, [good, merged]) == {0: 1, 1: 0}
    assert identity_switches([truth] * 2, [good, swapped], least=61) == {}


def test_borders_have_two_sides() -> None:
    labels = np.zeros((5, 7), np.int32)
    labels[:, 4:] = 1
    assert near_borders(labels, 2)[0].tolist() == [False, False, True, True, True, True, False]
