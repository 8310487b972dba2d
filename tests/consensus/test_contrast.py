"""Borders across which something changes, and those across which nothing does."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue.consensus import join_faint
from geohue.consensus.contrast import PRIOR
from geohue.regions.adjacency import adjacent_pixels


def slow(
    labels: NDArray[np.int32],
    pairs: list[tuple[int, int, float, float]],
    least: float,
) -> list[int]:
    """Join the least clear border, measured anew each time, until none is below `least`."""
    region = labels.reshape(-1).tolist()
    everywhere = [step for i, j, step, _ in pairs if region[i] == region[j]]
    while True:
        inside: dict[int, list[float]] = {r: [] for r in set(region)}
        borders: dict[tuple[int, int], list[tuple[float, float]]] = {}
        for i, j, step, share in pairs:
            a, b = sorted((region[i], region[j]))
            if a == b:
                inside[a].append(step)
            else:
                borders.setdefault((a, b), []).append((step, share))
        if not everywhere or not borders:
            return region
        own = {
            r: (sum(steps) + PRIOR * np.mean(everywhere)) / (len(steps) + PRIOR)
            for r, steps in inside.items()
        }
        clear = {
            (a, b): np.mean([s for s, _ in both])
            / min(own[a], own[b])
            * np.mean([v for _, v in both])
            for (a, b), both in borders.items()
        }
        a, b = min(clear, key=clear.__getitem__)
        if clear[a, b] >= least:
            return region
        region = [a if r == b else r for r in region]


@given(st.integers(0, 2**31), st.floats(0.1, 2))
@settings(deadline=None, max_examples=80)
def test_equals_measuring_anew(seed: int, least: float) -> None:
    rng = np.random.default_rng(seed)
    shape = tuple(int(n) for n in rng.integers(1, 7, 2))
    labels = rng.integers(0, 5, shape).astype(np.int32)
    one, other = adjacent_pixels(shape)
    step, share = rng.random(len(one)) + 0.01, rng.random(len(one))
    rows = zip(one.tolist(), other.tolist(), step.tolist(), share.tolist(), strict=True)
    joined = join_faint(labels, one, other, step, share, least)
    assert joined.reshape(-1).tolist() == slow(labels, list(rows), least)


def line(steps: list[float], share: float = 1.0) -> int:
    """Number of regions left of two, of ten points each, with the border in the middle."""
    labels = np.repeat(np.array([0, 1], np.int32), 10)
    one = np.arange(19)
    joined = join_faint(labels, one, one + 1, np.array(steps), np.full(19, share), 1.5)
    return len(np.unique(joined))


def test_a_step_like_those_beside_it_is_no_border() -> None:
    assert line([1.0] * 9 + [1.4] + [1.0] * 9) == 1
    assert line([1.0] * 9 + [1.6] + [1.0] * 9) == 2


def test_the_fewer_votes_the_plainer_it_must_be() -> None:
    assert line([1.0] * 9 + [4.0] + [1.0] * 9, 0.3) == 1
    assert line([1.0] * 9 + [6.0] + [1.0] * 9, 0.3) == 2


def test_the_calmer_side_shows_it() -> None:
    assert line([3.0] * 9 + [3.0] + [0.1] * 9) == 2
    assert line([3.0] * 9 + [3.0] + [3.0] * 9) == 1


def test_without_any_change() -> None:
    """Nothing changes: one part; constant parts that differ: two."""
    assert line([0.0] * 19) == 1
    assert line([0.0] * 9 + [1.0] + [0.0] * 9) == 2


def test_single_points_have_nothing_to_compare_with() -> None:
    alone = join_faint(
        np.array([0, 1], np.int32), np.array([0]), np.array([1]), np.ones(1), np.ones(1), 9
    )
    assert alone.tolist() == [0, 1]


def test_points_without_a_region_stay_without() -> None:
    none = np.zeros(0, np.int64)
    for labels in ([0, -1, 1], [-1, -1], []):
        given_ = np.array(labels, np.int32)
        assert join_faint(given_, none, none, np.zeros(0), np.zeros(0), 2).tolist() == labels
