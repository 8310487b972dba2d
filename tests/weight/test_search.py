from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geohue.compute.parallel import Workers, workers
from geohue.settings.weight import COARSE
from geohue.weight.search import search_weight

ALONE = Workers(None)


@given(st.floats(-3.5, 3.5))
def test_finds_the_peak_of_a_smooth_curve(peak: float) -> None:
    weight, curve = search_weight(lambda x: -((np.log2(x) - peak) ** 2), ALONE)
    assert abs(np.log2(weight) - peak) <= 0.126
    assert curve == sorted(curve)
    assert len(curve) == len(COARSE) + 4


def test_equal_scores_take_the_weight_nearest_to_1() -> None:
    weight, _ = search_weight(lambda _: 0.5, ALONE)
    assert weight == 1


def test_undefined_scores_are_left_out() -> None:
    weight, curve = search_weight(lambda x: None if x > 1 else x, ALONE)
    assert weight == 1
    assert all(x <= 1 for x, _ in curve)
    assert search_weight(lambda _: None, ALONE) == (1.0, [])


@pytest.mark.parametrize("threads", [2, 5])
def test_threads_change_nothing(threads: int) -> None:
    def score(x: float) -> float:
        return float(np.sin(3 * np.log2(x)))

    with workers(threads) as team:
        assert search_weight(score, team) == search_weight(score, ALONE)
