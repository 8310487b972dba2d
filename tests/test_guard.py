"""The judgement of the guard against slower revisions, on made-up measurements."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st

if TYPE_CHECKING:
    from benchmarks.guard.judge import Comparison


@pytest.fixture(autouse=True)
def _benchmarks_can_be_imported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[1]))


def _compare(base: list[float], head: list[float], tolerance: float = 1.25) -> Comparison:
    from benchmarks.guard.judge import compare

    return compare(base, head, tolerance)


def test_the_middle_and_the_quartiles_are_those_of_the_pairs() -> None:
    found = _compare([1, 2, 4, 8, 16], [2, 3, 4, 10, 20])
    # Ratios 2, 1.5, 1, 1.25, 1.25.
    assert (found.ratio, found.low, found.high) == (1.25, 1.25, 1.5)
    assert (found.base, found.head) == (4, 4)
    assert found.verdict == "same"  # at the tolerance, not above it


def test_a_busy_machine_is_no_slower_revision() -> None:
    busy = [1.0, 9.0, 2.0, 7.0, 1.0]
    assert _compare(busy, [1.05 * value for value in busy]).verdict == "same"


def test_noise_around_one_is_no_slower_revision() -> None:
    # The middle is above the tolerance, but a quarter of the pairs is below 1.
    found = _compare([1, 1, 1, 1, 1], [0.7, 0.9, 1.3, 1.6, 2.0])
    assert found.ratio > 1.25
    assert found.verdict == "same"


@given(
    st.lists(st.floats(0.01, 100), min_size=3, max_size=20),
    st.floats(1.3, 5),
)
def test_a_slower_revision_is_found_and_a_faster_one_in_the_other_order(
    base: list[float], factor: float
) -> None:
    head = [factor * value for value in base]
    assert _compare(base, head).verdict == "slower"
    assert _compare(head, base).verdict == "faster"
    assert _compare(base, head, tolerance=1.01 * factor).verdict == "same"


@pytest.mark.parametrize(("base", "head"), [([1.0, 1.0], [1.0, 1.0]), ([1.0] * 3, [1.0] * 4)])
def test_too_few_or_unpaired_measurements_are_refused(base: list[float], head: list[float]) -> None:
    with pytest.raises(ValueError, match="expected 3 or more pairs"):
        _compare(base, head)
