"""What pairs of neighbours say: by hand, and how it changes with the scene's scale."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue.merge.evidence import Evidence, gaps, gather, turns

Floats = NDArray[np.float64]
law = settings(deadline=None, max_examples=25)
ONE, OTHER = np.array([0]), np.array([1])
NONE = np.zeros((0, 2), np.int64)


def gathered(
    points: Floats,
    pairs: NDArray[np.int64],
    depth: Floats | None = None,
    normals: Floats | None = None,
    lab: Floats | None = None,
) -> Evidence:
    n, e = len(points), len(pairs)
    up = np.tile([0.0, 0, 1], (n, 1)) if normals is None else normals
    color = np.zeros((n, 3)) if lab is None else lab
    return gather(
        color, points, up, depth, pairs[:, 0], pairs[:, 1], np.zeros(e), np.zeros(e), [], NONE
    )


def chain(n: int) -> NDArray[np.int64]:
    return np.stack([np.arange(n - 1), np.arange(1, n)], axis=1)


class TestPairs:
    def test_gap_by_hand(self) -> None:
        flat = np.array([[0.0, 0, 1], [0, 0, 1]])
        assert gaps(flat, np.array([[5.0, 0, -0.5]]), ONE, OTHER).tolist() == [0.5]
        bent = np.array([[1.0, 0, 0], [0, 0, 1]])
        assert gaps(bent, np.array([[2.0, 9, 3]]), ONE, OTHER).tolist() == [2.5]

    @pytest.mark.parametrize(
        ("normals", "expected"),
        [
            ([[0, 1, 0], [0, 0, 1]], np.sqrt(2)),  # floor, then wall: concave
            ([[0, 0, 1], [0, 1, 0]], -np.sqrt(2)),  # front, then top of a box: convex
            ([[0, 0, 1], [0, 0, 1]], 0.0),
        ],
    )
    def test_corners(self, normals: list[list[float]], expected: float) -> None:
        """Normals look away from the camera; y runs down, z forward, and so does the way."""
        way = np.array([[0, -0.1, 0.1]])
        found = turns(np.array(normals, float), way, ONE, OTHER)
        assert found == pytest.approx(expected)
        back = turns(np.array(normals[::-1], float), -way, ONE, OTHER)
        assert back == pytest.approx(expected)

    @given(st.integers(0, 2**20), st.sampled_from([1e-30, 1e-15, 1e-3, 1e6, 1e30]))
    @law
    def test_turns_have_no_scale(self, seed: int, scale: float) -> None:
        way, one, other = np.random.default_rng(seed).normal(size=(3, 5, 3))
        normals, first = np.concatenate([one, other]), np.arange(5)
        found = turns(normals, way * scale, first, first + 5)
        np.testing.assert_allclose(found, turns(normals, way, first, first + 5), rtol=1e-9)

    def test_points_in_one_place_do_not_turn(self) -> None:
        assert turns(np.eye(3)[:2], np.zeros((1, 3)), ONE, OTHER).tolist() == [0]
        rounding = np.array([[1.0, 0, 0], [-1e-16, 0, 0]])
        two = np.array([0, 0]), np.array([1, 1])
        assert turns(np.eye(3)[:2], rounding, *two) == pytest.approx([-1, 0], abs=1e-3)


class TestCloud:
    def test_by_hand(self) -> None:
        points = np.array([[10.0, 0, 0], [11, 0, 0], [13, 0, 2], [13, 0, 2]])
        found = gathered(points, chain(4))
        # Lengths 1, sqrt(8) and 0; pairs in one place have no say in the spacing.
        spacing = (1 + np.sqrt(8)) / 2
        np.testing.assert_allclose(found.unit, 0.92 * 2 * spacing)
        np.testing.assert_allclose(found.depth_step, np.array([1, np.sqrt(8), 0]) * 0.005 / spacing)
        np.testing.assert_allclose(found.points.mean(axis=0), 0, atol=1e-12)
        np.testing.assert_allclose(np.diff(found.points, axis=0), np.diff(points, axis=0))
        assert found.gap.tolist() == [0, 100, 0]  # most gaps are 0: any other is a border

    def test_gaps_in_medians_up_to_a_cap(self) -> None:
        points = np.c_[np.arange(6.0), np.zeros(6), np.cumsum([0, 1, 2, 4, 6, 900])]
        assert gathered(points, chain(6)).gap.tolist() == [0.25, 0.5, 1, 1.5, 100]

    @pytest.mark.parametrize("n", [1, 3])
    def test_all_in_one_place(self, n: int) -> None:
        found = gathered(np.full((n, 3), 5.0), chain(n))
        assert (found.gap == 0).all()
        assert (found.depth_step == 0).all()
        np.testing.assert_allclose(found.unit, 0.92 * np.sqrt(n))

    @given(st.integers(0, 2**20), st.floats(1e-6, 1e6))
    @law
    def test_scale_and_place_say_nothing(self, seed: int, scale: float) -> None:
        rng = np.random.default_rng(seed)
        points, normals = rng.normal(size=(2, 12, 3))
        one = gathered(points, chain(12), normals=normals)
        two = gathered(scale * (points + rng.normal(size=3)), chain(12), normals=normals)
        np.testing.assert_allclose(two.gap, one.gap, rtol=1e-9)
        np.testing.assert_allclose(two.depth_step, one.depth_step, rtol=1e-9)
        np.testing.assert_allclose(two.unit, scale * one.unit, rtol=1e-9)
        np.testing.assert_allclose(two.points, scale * one.points, atol=1e-9 * scale)


class TestGrid:
    def test_by_hand(self) -> None:
        depth = np.array([1.0, 2, 2, 4, 3])
        points = np.c_[np.arange(5.0), np.zeros(5), depth]
        found = gathered(points, chain(5), depth)
        np.testing.assert_allclose(found.depth_step, [1, 0, 1, 1 / 3])
        assert found.unit.tolist() == depth.tolist()
        # Gaps 1, 0, 2, 1 by (median nearer / nearer)^2 = (2/1)^2, 1, 1, (2/3)^2: median 11/9.
        typical = (4 / 9 + 2) / 2
        np.testing.assert_allclose(found.gap, np.array([4, 0, 2, 4 / 9]) / typical)

    def test_one_pixel(self) -> None:
        found = gathered(np.ones((1, 3)), chain(1), np.ones(1))
        assert found.gap.shape == found.depth_step.shape == (0,)
        assert found.unit.tolist() == [1]

    @given(st.integers(0, 2**20), st.floats(1e-6, 1e6))
    @law
    def test_scale_says_nothing(self, seed: int, scale: float) -> None:
        rng = np.random.default_rng(seed)
        points, normals = rng.uniform(1, 2, (2, 12, 3))
        one = gathered(points, chain(12), points[:, 2], normals)
        two = gathered(scale * points, chain(12), scale * points[:, 2], normals)
        np.testing.assert_allclose(two.gap, one.gap, rtol=1e-9)
        np.testing.assert_allclose(two.depth_step, one.depth_step, rtol=1e-9)
        np.testing.assert_allclose(two.unit, scale * one.unit)


@pytest.mark.parametrize(
    ("step", "octave"),
    [(0, 0), (0.49, 0), (0.51, 1), (1.49, 1), (1.51, 2), (3.51, 3), (7.51, 4), (31.6, 6), (64, 7)],
)
def test_texture_is_the_octave_of_the_mean_step(step: float, octave: int) -> None:
    lab = np.array([[0.0, 0, 0], [0.6 * step, 0.8 * step, 0], [0, 0, 0], [0, 0, 0]])
    found = gathered(np.eye(4, 3), np.array([[0, 1], [2, 3]]), lab=lab)
    assert found.texture.tolist() == [octave, octave, 0, 0]


def test_texture_of_a_point_with_several_neighbours_and_with_none() -> None:
    lab = np.array([[0.0, 0, 0], [4, 0, 0], [4, 3, 0], [90, 0, 0]])
    found = gathered(np.eye(4, 3), np.array([[0, 1], [1, 2]]), lab=lab)
    assert found.texture.tolist() == [3, 3, 2, 0]  # steps 4, 3.5, 3; none
