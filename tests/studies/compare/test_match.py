"""Colours of a plate: the same part has the same one."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from geohue.results.picture import palette
from geohue.studies.compare.match import COLORS, match_labels

LABELS = st.lists(st.integers(-1, 6), min_size=30, max_size=30).map(
    lambda values: np.array(values, np.int32)
)


@given(LABELS, st.permutations(range(7)))
def test_renumbering_does_not_matter(labels: np.ndarray, order: list[int]) -> None:
    _, compact = np.unique(np.append(labels, -1), return_inverse=True)
    reference = (compact[:-1] - 1).astype(np.int32)
    n = int(reference.max()) + 1
    mixed = np.append(np.array(order)[np.array(order) < n], -1)[reference].astype(np.int32)
    np.testing.assert_array_equal(match_labels(mixed, reference), reference)


@given(LABELS, LABELS)
def test_segments_stay_apart_and_gaps_stay_gaps(labels: np.ndarray, reference: np.ndarray) -> None:
    found = match_labels(labels, reference)
    np.testing.assert_array_equal(found < 0, labels < 0)
    pairs = set(zip(labels.tolist(), found.tolist(), strict=True))
    assert len(pairs) == len({a for a, _ in pairs}) == len({b for _, b in pairs})


def test_many_segments_leave_the_colours_of_the_reference_alone() -> None:
    reference = np.repeat(np.array([0, 1], np.int32), 300)
    labels = np.arange(600, dtype=np.int32)
    found = match_labels(labels, reference)
    assert (found == 0).sum() == (found == 1).sum() == 1
    assert found.max() == COLORS - 1


def test_the_palette_has_so_many_colours() -> None:
    assert len(np.unique(palette(COLORS), axis=0)) == COLORS


def test_without_any_segment() -> None:
    none = np.full((2, 2), -1, np.int32)
    zero = np.zeros((2, 2), np.int32)
    np.testing.assert_array_equal(match_labels(none, zero), none)
    np.testing.assert_array_equal(match_labels(zero, none), zero)
