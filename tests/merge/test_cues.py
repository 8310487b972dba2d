"""Each cue by hand, and all of them against a slow twin."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue.merge import table as t
from geohue.merge.cues import NAMES, fit_plane, measure
from geohue.merge.evidence import Evidence
from geohue.merge.table import tabulate
from merge.tables import random_evidence
from twins import merge as twin

SQUARE = [[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
RING = [[0, 1], [1, 2], [2, 3], [0, 3]]
TWO = np.array([0, 0, 0, 0, 1, 1, 1, 1], np.int32)


def floors() -> Evidence:
    """Two squares, 0.1 above each other, each a ring of four points."""
    points = np.array([*SQUARE, *SQUARE]) + np.repeat([0, 0.1], 4)[:, None] * [0, 0, 1]
    pairs = np.array([*RING, *(np.array(RING) + 4), [0, 4], [1, 5], [2, 6], [3, 7]])
    return Evidence(
        lab=np.repeat([[0.0, 0, 0], [3, 4, 0]], 4, axis=0),
        points=points,
        normals=np.repeat([[0.0, 0, 1], [1, 0, 0]], 4, axis=0),
        unit=np.repeat([1.0, 3.0], 4),
        one=pairs[:, 0],
        other=pairs[:, 1],
        share=np.zeros(12),
        step=np.repeat([0.1, 0.3, 1.1], 4),
        gap=np.zeros(12),
        depth_step=np.repeat([5.0, 5.0, 0.008], 4),
        texture=np.array([2, 2, 2, 2, 2, 2, 3, 3]),
        cuts=[TWO, 0 * TWO, np.array([0, 0, 0, 0, 0, 0, 1, 1], np.int32)],
        distant=np.zeros((0, 2), np.int64),
    )


def measured(evidence: Evidence, labels: NDArray[np.int32], e: int = 0) -> dict[str, float]:
    table, scratch, out = tabulate(evidence, labels), np.empty(6), np.full(len(NAMES), np.nan)
    for i in range(len(table.region)):
        fit_plane(table.region, i, scratch)
    i, j = table.ends[e].tolist()
    measure(table, i, j, e, out, scratch)
    return dict(zip(NAMES, out.tolist(), strict=True))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("offset", np.log(0.1 / 0.004 + 0.5)),  # in the smaller unit
        ("color_step", np.log(5 + 0.5)),
        ("depth_step", np.log(0.008 / 0.004 + 0.5)),
        ("texture", (0.5**2 / 1.5 + 0.5**2 / 0.5) / 2),
        ("convexity", -1.0),
        ("one_plane", np.log(0.05 / 0.002 + 0.1)),
        ("whole_votes", (1 + 0 + 0.5) / 3),
        ("length", 4 / np.sqrt(4)),
        ("gap", np.log(0.05 / 0.004 + 0.5)),
        ("contrast", np.log(1.1 / ((0.4 + 20 * 0.2) / 24) + 0.05)),
        ("straightness", 1.0),
        ("perimeter", 1.0),
        ("smaller", np.log(0.5)),
        ("larger", np.log(0.5)),
        ("region_convexity", -1.0),
    ],
)
def test_by_hand(name: str, value: float) -> None:
    assert measured(floors(), TWO)[name] == pytest.approx(value, abs=1e-7)


def test_all_cues_are_in_the_test_by_hand() -> None:
    assert len(NAMES) == 15


class TestOneByOne:
    def test_sizes(self) -> None:
        three = np.array([0, 0, 0, 1, 1, 1, 1, 1], np.int32)
        found = measured(floors(), three)
        assert found["smaller"] == pytest.approx(np.log(3 / 8))
        assert found["larger"] == pytest.approx(np.log(5 / 8))
        assert found["length"] == pytest.approx(5 / np.sqrt(3))

    def test_a_border_of_two_pairs_has_no_straightness(self) -> None:
        """Of the three pairs of the first square one is left out."""
        straight = floors()
        line = np.arange(8.0)[:, None] * [[1.0, 1, 0]]
        assert measured(replace(straight, points=line), TWO)["straightness"] == pytest.approx(
            0, abs=2e-4
        )
        few = replace(straight, one=straight.one[:10], other=straight.other[:10])
        few = replace(few, step=few.step[:10], depth_step=few.depth_step[:10])
        assert measured(few, TWO)["straightness"] == 0.3
        same = replace(straight, points=np.zeros((8, 3)))
        assert measured(same, TWO)["straightness"] == 0.3

    def test_offset_is_the_larger_of_both_ways(self) -> None:
        """A wall whose middle lies in the floor's plane, while the floor's is off the wall's."""
        wall = np.array(SQUARE)[:, [2, 0, 1]] * 2 + [3, -1, -1]  # x = 3
        points = np.concatenate([np.array(SQUARE) * 2 - [1, 1, 0], wall])
        found = measured(replace(floors(), points=points, unit=np.ones(8)), TWO)
        assert found["offset"] == pytest.approx(np.log(3 / 0.004 + 0.5))
        swapped = measured(replace(floors(), points=points, unit=np.ones(8)), 1 - TWO)
        assert swapped["offset"] == pytest.approx(found["offset"])

    def test_regions_of_a_line_or_less_have_no_plane(self) -> None:
        line = np.arange(8.0)[:, None] * [[1.0, 2, 3]]
        for labels in (TWO, np.array([0, 0, 1, 1, 1, 1, 1, 1], np.int32)):
            found = measured(replace(floors(), points=line), labels)
            assert found["offset"] == pytest.approx(np.log(0.5))
            assert found["one_plane"] == pytest.approx(np.log(0.1), abs=1e-3)

    def test_no_cuts_no_votes(self) -> None:
        assert measured(replace(floors(), cuts=[]), TWO)["whole_votes"] == 0

    def test_no_step_anywhere(self) -> None:
        quiet = replace(floors(), step=np.zeros(12))
        assert measured(quiet, TWO)["contrast"] == pytest.approx(np.log(0.05))

    def test_regions_around_one_middle_do_not_turn(self) -> None:
        """The direction between the centroids would be rounding."""
        around = np.array([*SQUARE, *(2 * np.array(SQUARE) - [0.5, 0.5, 1e-9])])
        assert measured(replace(floors(), points=around), TWO)["region_convexity"] == 0

    def test_plane_of_a_region(self) -> None:
        table = tabulate(floors(), 0 * TWO)
        fit_plane(table.region, 0, np.empty(6))
        assert np.abs(table.region[0, t.PLANE : t.PLANE + 3]).round(9).tolist() == [0, 0, 1]
        assert table.region[0, t.RESIDUAL] == pytest.approx(0.05**2)


@given(st.integers(0, 2**20), st.integers(0, 4))
@settings(deadline=None, max_examples=40)
def test_against_the_twin(seed: int, cuts: int) -> None:
    evidence, labels = random_evidence(seed, regions=5, cuts=cuts)
    ends, facts = tabulate(evidence, labels).ends, twin.Facts(evidence, labels)
    for e, (i, j) in enumerate(ends.tolist()):
        found = list(measured(evidence, labels, e).values())
        np.testing.assert_allclose(found, twin.cues(facts, labels, i, j), rtol=1e-7, atol=1e-7)


@given(st.integers(0, 2**20), st.sampled_from([1e-30, 1e-9, 1e-3, 0.1, 7.0, 1e6, 1e30]))
@settings(deadline=None, max_examples=20)
def test_the_scale_of_a_scene_says_nothing(seed: int, scale: float) -> None:
    evidence, labels = random_evidence(seed, regions=3)
    large = replace(evidence, points=scale * evidence.points, unit=scale * evidence.unit)
    one, two = measured(evidence, labels), measured(large, labels)
    assert two == pytest.approx(one, rel=1e-7, abs=1e-7)
