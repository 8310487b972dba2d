"""Sums over regions and borders, and the averages within regions, against slow twins."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geohue.merge import table as t
from geohue.merge.smooth import Smooth, smooth_within
from geohue.merge.table import tabulate
from merge.tables import random_evidence
from twins import merge as twin

law = settings(deadline=None, max_examples=25)


class TestSmooth:
    @given(st.integers(0, 2**20))
    @law
    def test_against_the_twin(self, seed: int) -> None:
        evidence, labels = random_evidence(seed, regions=4)
        one, other = evidence.one, evidence.other
        inside = labels[one] == labels[other]
        pairs = list(zip(one[inside].tolist(), other[inside].tolist(), strict=True))
        found = smooth_within(evidence, inside)
        np.testing.assert_allclose(found.lab, twin.smoothed(evidence.lab, pairs, 6), atol=1e-11)
        np.testing.assert_allclose(found.points, twin.smoothed(evidence.points, pairs, 6))
        normals = twin.smoothed(evidence.normals, pairs, 6)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        np.testing.assert_allclose(found.normals, normals, atol=1e-11)

    def test_nothing_crosses_a_border_and_normals_may_be_missing(self) -> None:
        evidence, _ = random_evidence(0)
        nothing = np.zeros(len(evidence.one), bool)
        bare = replace(evidence, normals=np.zeros_like(evidence.normals))
        found = smooth_within(bare, nothing)
        assert np.array_equal(found.lab, evidence.lab)
        assert np.array_equal(found.points, evidence.points)
        assert (found.normals == 0).all()

    def test_steps_by_hand(self) -> None:
        normals = np.array([[0.0, 1, 0], [0, 0, 1]])
        smooth = Smooth(np.array([[1.0, 2, 2], [0, 0, 0]]), normals, np.eye(3)[1:])
        pair = np.array([0]), np.array([1])
        color, convexity, gap = smooth.steps(*pair, np.array([4.0, 2.0]))
        # The way is (0, -1, 1).
        assert color.tolist() == [3]
        assert convexity == pytest.approx(2 / np.sqrt(2))
        assert gap.tolist() == [0]
        flat = replace(smooth, normals=np.array([[0.0, 0, 1], [0, 0, 1]]))
        assert flat.steps(*pair, np.array([4.0, 2.0]))[2].tolist() == [0.5]


@given(st.integers(0, 2**20), st.integers(0, 3))
@law
def test_regions_against_the_twin(seed: int, cuts: int) -> None:
    evidence, labels = random_evidence(seed, cuts=cuts)
    table, facts = tabulate(evidence, labels), twin.Facts(evidence, labels)
    for i, row in enumerate(table.region):
        here = np.flatnonzero(labels == i)
        inside, points = facts.inside(labels, i), evidence.points[here]
        np.testing.assert_allclose(row[t.SIZE], len(here))
        np.testing.assert_allclose(row[t.LAB : t.LAB + 3], evidence.lab[here].sum(axis=0))
        np.testing.assert_allclose(row[t.NORMAL : t.NORMAL + 3], evidence.normals[here].sum(axis=0))
        np.testing.assert_allclose(row[t.POSITION : t.POSITION + 3], points.sum(axis=0))
        products = (points.T @ points)[np.triu_indices(3)]
        np.testing.assert_allclose(row[t.SPREAD : t.SPREAD + 6], products)
        histogram = np.bincount(evidence.texture[here], minlength=8)
        assert row[t.TEXTURE : t.TEXTURE + 8].tolist() == histogram.tolist()
        assert row[t.INNER_PAIRS] == len(inside)
        np.testing.assert_allclose(row[t.INNER_STEP], evidence.step[inside].sum(), atol=1e-12)
        assert row[t.PERIMETER] == facts.perimeter(labels, i)
        np.testing.assert_allclose(row[t.UNIT], evidence.unit[here].sum())
        votes = [np.bincount(cut[here], minlength=cut.max() + 1) for cut in evidence.cuts]
        assert table.votes[i].tolist() == np.concatenate([*votes, []]).tolist()
    np.testing.assert_allclose(table.scene, [len(labels), facts.typical, max(cuts, 1)])


@given(st.integers(0, 2**20), st.integers(1, 3))
@law
def test_borders_against_the_twin(seed: int, pieces: int) -> None:
    evidence, labels = random_evidence(seed, pieces=pieces)
    table, facts = tabulate(evidence, labels), twin.Facts(evidence, labels)
    ends = [tuple(pair) for pair in table.ends.tolist()]
    assert len(set(ends)) == len(ends)
    assert all(i < j for i, j in ends)
    touching = {tuple(sorted((labels[a], labels[b]))) for a, b in facts.pairs}
    touching = {(i, j) for i, j in touching if i != j}
    assert set(ends[: len(touching)]) == touching
    linked = [tuple(sorted(labels[link].tolist())) for link in evidence.distant]
    wanted = [pair for pair in dict.fromkeys(linked) if pair not in touching]
    assert ends[len(touching) :] == wanted  # the nearest first
    assert not table.border[len(touching) :].any()
    for (i, j), row in zip(ends[: len(touching)], table.border, strict=False):
        border = facts.border(labels, i, j)
        middle = (
            evidence.points[evidence.one[border]] + evidence.points[evidence.other[border]]
        ) / 2
        sums = [len(border), evidence.step[border].sum(), sum(facts.color[e] for e in border)]
        sums += [evidence.depth_step[border].sum(), sum(facts.convexity[e] for e in border)]
        sums += [sum(facts.gap[e] for e in border), *middle.sum(axis=0)]
        sums += (middle.T @ middle)[np.triu_indices(3)].tolist()
        np.testing.assert_allclose(row, sums, atol=1e-10)


def test_one_region_has_no_border() -> None:
    evidence, labels = random_evidence(1)
    table = tabulate(evidence, np.zeros_like(labels))
    assert table.ends.shape == (0, 2)
    assert table.region[0, t.PERIMETER] == 0
