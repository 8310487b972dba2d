"""Greedy merging against a twin that computes everything anew, and its heap and lists."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue.merge.evidence import Evidence
from geohue.merge.greedy import APART, Queue, linked, merge_all, place, remove
from geohue.merge.table import INNER_PAIRS, PERIMETER, tabulate
from merge.tables import random_evidence
from twins import merge as twin

Sets = list[frozenset[frozenset[int]]]


def merged(
    evidence: Evidence, labels: NDArray[np.int32], weights: NDArray[np.float64]
) -> tuple[Sets, list[float]]:
    """The two sets of first regions of each merge."""
    merges, scores = merge_all(tabulate(evidence, labels), weights)
    members = {i: frozenset([i]) for i in range(int(labels.max()) + 1)}
    sets = []
    for kept, gone in merges.tolist():
        sets.append(frozenset([members[kept], members.pop(gone)]))
        members[kept] = frozenset().union(*sets[-1])
    return sets, scores.tolist()


@given(st.integers(0, 2**20), st.integers(2, 9), st.integers(1, 3))
@settings(deadline=None, max_examples=40)
def test_against_the_twin(seed: int, regions: int, pieces: int) -> None:
    evidence, labels = random_evidence(seed, regions, pieces=pieces)
    weights = np.random.default_rng(seed).normal(size=16)
    found, scores = merged(evidence, labels, weights)
    expected, expected_scores = twin.merge(evidence, labels, weights, APART)
    assert found == expected
    np.testing.assert_allclose(scores, expected_scores, rtol=1e-9, atol=1e-7)


def test_scores_to_nine_digits() -> None:
    for seed in range(10):
        evidence, labels = random_evidence(seed, 8)
        weights = np.abs(np.random.default_rng(seed).normal(size=16))
        found, scores = merged(evidence, labels, weights)
        expected, expected_scores = twin.merge(evidence, labels, weights)
        assert found == expected
        np.testing.assert_allclose(scores, expected_scores, atol=1e-9)


@given(st.integers(0, 2**20), st.integers(1, 3))
@settings(deadline=None, max_examples=30)
def test_many_regions_become_one(seed: int, pieces: int) -> None:
    """Each merge is of two regions that are still there, until nothing is left to merge."""
    evidence, labels = random_evidence(seed, 40, 1, pieces)
    table = tabulate(evidence, labels)
    total, votes = table.region[:, :28].sum(axis=0), table.votes.sum(axis=0)
    found, _ = merged(evidence, labels, np.random.default_rng(seed).normal(size=16))
    assert len(found) == 39 or pieces > 1
    merges, _ = merge_all(table, np.zeros(16))
    if len(merges) == 39:
        last = merges[-1, 0]
        np.testing.assert_allclose(table.region[last, :24], total[:24], atol=1e-9)
        np.testing.assert_allclose(table.votes[last], votes)
        assert table.region[last, PERIMETER] == 0
        assert table.region[last, INNER_PAIRS] == len(evidence.one)


class TestDistant:
    def test_pieces_come_last_and_whole(self) -> None:
        evidence, labels = random_evidence(3, regions=9, pieces=3)
        _, scores = merged(evidence, labels, np.zeros(16))
        assert scores == [0.0] * (8 - 2) + [APART] * 2

    def test_without_a_link_nothing_is_merged(self) -> None:
        evidence, labels = random_evidence(3, regions=9, pieces=3)
        alone = replace(evidence, distant=np.zeros((0, 2), np.int64))
        found, scores = merged(alone, labels, np.zeros(16))
        assert len(found) == 8 - 2
        assert APART not in scores

    def test_nearest_first(self) -> None:
        """Also where the nearest link belongs to a region that another took up."""
        evidence, _ = random_evidence(0, regions=2, size=1)
        points = np.arange(8) // 2
        labels = points.astype(np.int32)  # 0 and 1 touch; 2 and 3 lie apart
        pairs = np.array([[0, 1], [2, 3], [4, 5], [6, 7], [0, 2]])
        small = replace(
            evidence,
            one=pairs[:, 0],
            other=pairs[:, 1],
            step=evidence.step[:5],
            depth_step=evidence.depth_step[:5],
        )
        zero, one, two, three = (frozenset([i]) for i in range(4))
        links = {(2, 4): two, (0, 6): three}  # 1 to 2 is nearest, then 0 to 3, then 0 to 2
        assert list(links.values()) == [two, three]
        linked_ = replace(small, distant=np.array([*links, (0, 4)]))
        found, scores = merged(linked_, labels, np.zeros(16))
        assert scores == [0, APART, APART]
        assert found[:2] == [frozenset([zero, one]), frozenset([zero | one, two])]


def order_of(queue: Queue) -> list[int]:
    out = []
    while queue.size[0] > 0:
        out.append(int(queue.heap[0]))
        remove(queue, int(queue.heap[0]))
    return out


def empty(n: int) -> Queue:
    return Queue(np.empty(n, np.int64), np.full(n, -1), np.empty(n), np.zeros(1, np.int64))


@given(
    st.lists(
        st.tuples(st.integers(0, 14), st.sampled_from([None, -1.0, 0.0, 0.5, 2.0, np.inf])),
        max_size=80,
    )
)
@settings(deadline=None, max_examples=150)
def test_heap(steps: Sequence[tuple[int, float | None]]) -> None:
    """Like a dictionary that is sorted by score and number when asked for its first."""
    queue, known = empty(15), dict[int, float]()
    for e, score in steps:
        if score is not None:
            place(queue, e, score)
            known[e] = score
        elif e in known:
            remove(queue, e)
            del known[e]
        assert queue.size[0] == len(known)
        assert set(np.flatnonzero(queue.place >= 0)) == set(known)
        if known:
            assert queue.heap[0] == min(known, key=lambda k: (known[k], k))
    assert order_of(queue) == sorted(known, key=lambda k: (known[k], k))


@given(st.integers(0, 2**20))
@settings(deadline=None, max_examples=20)
def test_lists_of_borders(seed: int) -> None:
    evidence, labels = random_evidence(seed, pieces=2)
    table = tabulate(evidence, labels)
    links = linked(table)
    for region in range(len(table.region)):
        halves, half = [], int(links.first[region])
        while half >= 0:
            halves.append(half)
            half = int(links.next[half])
        assert halves == [
            2 * e + side
            for e, ends in enumerate(table.ends)
            for side in (0, 1)
            if ends[side] == region
        ]
        assert links.last[region] == (halves[-1] if halves else -1)
    assert (links.marks == -1).all()


@pytest.mark.parametrize("n", [1, 2])
def test_tiny_tables(n: int) -> None:
    evidence, labels = random_evidence(0, regions=n)
    found, _ = merged(evidence, labels, np.zeros(16))
    assert len(found) == n - 1
