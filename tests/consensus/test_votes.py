"""Votes for borders, and what is joined by them."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue.consensus import count_votes, join_by_votes
from geohue.regions.adjacency import adjacent_pixels
from twins import votes as twin

law = settings(deadline=None, max_examples=80)


def graph(seed: int) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64], int]:
    """A small grid whose pairs have votes that no two borders share."""
    rng = np.random.default_rng(seed)
    shape = tuple(int(n) for n in rng.integers(1, 7, 2))
    one, other = adjacent_pixels(shape)
    share = rng.random(len(one))
    return one, other, share, shape[0] * shape[1]


def same_parts(a: NDArray[np.int32], b: NDArray[np.int32]) -> bool:
    pairs = set(zip(a.tolist(), b.tolist(), strict=True))
    return len(pairs) == len(set(a.tolist())) == len(set(b.tolist()))


@given(st.integers(0, 2**31), st.floats(0, 1.1))
@law
def test_rounds_of_mutual_neighbours_equal_one_border_at_a_time(seed: int, least: float) -> None:
    one, other, share, n = graph(seed)
    slow = twin.join(list(zip(one.tolist(), other.tolist(), share.tolist(), strict=True)), n, least)
    if least == 0:
        return  # the twin joins nothing then, not even what no vote parts
    assert same_parts(join_by_votes(one, other, share, n, least), np.array(slow, np.int32))


@given(st.integers(0, 2**31), st.floats(0.01, 1), st.floats(0.01, 1))
@law
def test_asking_for_more_votes_only_joins_more(seed: int, a: float, b: float) -> None:
    one, other, share, n = graph(seed)
    fine, coarse = (join_by_votes(one, other, share, n, least) for least in sorted((a, b)))
    assert len(set(zip(fine.tolist(), coarse.tolist(), strict=True))) == fine.max() + 1


@given(st.integers(0, 2**31))
@law
def test_permuting_points_permutes_regions(seed: int) -> None:
    one, other, share, n = graph(seed)
    order = np.random.default_rng(seed).permutation(n)
    place = np.argsort(order)
    moved = join_by_votes(place[other], place[one], share, n, 0.25)
    assert same_parts(join_by_votes(one, other, share, n, 0.25)[order], moved)


def test_the_mean_along_a_border_counts() -> None:
    """Two rows of three: one weak pair in a strong border does not open it."""
    one, other = adjacent_pixels((2, 3))
    across = other - one == 3
    share = np.full(len(one), 0.1)
    share[across] = [0.9, 0.2, 0.9]
    assert join_by_votes(one, other, share, 6, 0.5).tolist() == [0, 0, 0, 1, 1, 1]


def test_regions_are_numbered_by_their_first_points() -> None:
    one, other = np.array([3, 2]), np.array([0, 1])
    assert join_by_votes(one, other, np.zeros(2), 5, 0.25).tolist() == [0, 1, 1, 0, 2]


def test_no_pairs_and_no_points() -> None:
    none = np.zeros(0, np.int64)
    assert join_by_votes(none, none, np.zeros(0), 3, 0.25).tolist() == [0, 1, 2]
    assert join_by_votes(none, none, np.zeros(0), 0, 0.25).tolist() == []


def test_votes_by_hand() -> None:
    maps = list(np.array([[0, 0, 1, -1], [4, 2, 2, -1]], np.int32))
    shares = count_votes(maps, np.array([0, 1, 0, 2]), np.array([1, 2, 2, 3]))
    assert shares.tolist() == [0.5, 0.5, 1.0, 1.0]
    assert count_votes([], np.array([0]), np.array([1])).tolist() == [0.0]
