from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geohue.compute.arrays import Floats
from geohue.compute.lloyd import lloyd, spread_seeds
from geohue.ncut import loops
from geohue.ncut.affinity import FAINTEST, affinity
from geohue.ncut.kernel import Kernel
from twins import kernel as twins


def points(seed: int, n: int, d: int, dtype: type = np.float64, spread: float = 1.0) -> Floats:
    return (spread * np.random.default_rng(seed).normal(size=(n, d))).astype(dtype)


SIZES = st.tuples(st.integers(0, 999), st.integers(1, 9), st.integers(1, 70), st.integers(1, 40))


class TestExp2:
    def test_float32_within_3e_7_over_its_whole_range(self) -> None:
        # One landmark at the origin, points along a line: w = 2^(-x^2 / 2).
        x = np.sqrt(np.linspace(0, 2 * 110, 40001))[:, None].astype(np.float32)
        out = np.empty((len(x), 1), np.float32)
        padded = np.pad(x, ((0, 0), (0, 2)))
        z, half = np.zeros((3, 1), np.float32), np.zeros(1, np.float32)
        lift, totals = np.zeros((2, len(x)), np.float32)
        loops.affinities(padded, lift, np.float32(1), z, half, totals, out)
        assert np.array_equal(totals, out[:, 0])
        power = -0.5 * (x[:, 0] * x[:, 0]).astype(np.float64)  # the power as float32 has it
        error = np.abs(out[:, 0] / 2.0**power - 1)
        assert error.max() < 3e-7

    def test_is_a_power_of_two_in_python_too(self) -> None:
        assert loops.exp2(-3.0) == 0.125


class TestKernel:
    @given(SIZES)
    @settings(max_examples=40, deadline=None)
    def test_float64_is_the_definition(self, sizes: tuple[int, int, int, int]) -> None:
        seed, d, n_points, n = sizes
        x, z = points(seed, n_points, d), points(seed + 1, n, d)
        kernel, w = Kernel.of(z, 0.5), affinity(x, z, 0.5)
        assert kernel(x) == pytest.approx(w, rel=1e-9)
        assert kernel.column_sums(x) == pytest.approx(w.sum(axis=0), rel=1e-9)
        to_degree = points(seed + 2, n, 1)[:, 0]
        assert kernel.gram(x, to_degree) == pytest.approx(twins.gram(w, to_degree), rel=1e-8)

    @given(SIZES, st.integers(1, 9), st.integers(1, 9))
    @settings(max_examples=40, deadline=None)
    def test_projects_and_labels_as_the_definition(
        self, sizes: tuple[int, int, int, int], k: int, n_centers: int
    ) -> None:
        seed, d, n_points, n = sizes
        x, z = points(seed, n_points, d), points(seed + 1, n, d)
        basis, centers = points(seed + 2, n, k), points(seed + 3, n_centers, k)
        kernel, w = Kernel.of(z, 0.8), affinity(x, z, 0.8)
        projected = kernel.project(x, basis)
        assert projected == pytest.approx(w @ basis, rel=1e-9, abs=1e-9 * np.abs(w @ basis).max())
        rows = projected / np.linalg.norm(projected, axis=1)[:, None]
        distance = ((rows[:, None] - centers[None]) ** 2).sum(axis=2)
        labels = kernel.nearest(x, basis, centers)
        chosen = distance[np.arange(len(x)), labels]
        assert (chosen <= distance.min(axis=1) + 1e-6).all()  # ties may fall either way

    def test_float32_is_within_1e_4_of_float64(self) -> None:
        x, z = points(0, 3000, 6), points(1, 100, 6)
        w = affinity(x, z, 0.4)
        close = Kernel.of(z.astype(np.float32), 0.4)(x.astype(np.float32))
        seen = w > math.exp(FAINTEST)
        assert np.abs(close[seen] / w[seen] - 1).max() < 1e-4

    def test_labels_of_float32_are_those_of_the_definition(self) -> None:
        x, z = points(0, 5000, 6, spread=0.5), points(1, 60, 6, spread=0.5)
        basis, centers = points(2, 60, 5), points(3, 5, 5)
        expected = twins.nearest(affinity(x, z, 0.4), basis, centers)
        found = Kernel.of(z.astype(np.float32), 0.4).nearest(x.astype(np.float32), basis, centers)
        assert (found != expected).mean() < 1e-3

    @pytest.mark.parametrize("dtype", [np.float32, np.float64])
    def test_a_point_seen_by_nobody_is_raised(self, dtype: type) -> None:
        z: Floats = np.array([[0.0], [1.0]], dtype)
        x: Floats = np.array([[100.0], [0.0]], dtype)
        w = Kernel.of(z, 1.0)(x)
        assert w[0].max() == pytest.approx(math.exp(FAINTEST), rel=1e-2)
        assert w[0, 1] > w[0, 0] > 0
        assert w[1] == pytest.approx([1.0, math.exp(-0.5)], rel=1e-6)

    def test_the_block_that_a_point_is_in_changes_not_one_bit(self) -> None:
        x = points(0, 500, 6, np.float32)
        x[250] = 60.0  # faint: its block is run twice
        kernel = Kernel.of(x[:33], 0.4)
        alone = np.concatenate([kernel(x[i : i + 1]) for i in range(len(x))])
        assert np.array_equal(kernel(x), alone)


class TestLloyd:
    @given(st.integers(0, 999), st.integers(1, 6), st.integers(1, 5), st.integers(0, 12))
    @settings(max_examples=40, deadline=None)
    def test_equals_its_twin(self, seed: int, k: int, d: int, steps: int) -> None:
        rows, start = np.random.default_rng(seed).normal(size=(2, 50, d))
        start = start[:k]
        centers, cost = lloyd(rows, start, steps)
        expected, expected_cost = twins.lloyd(rows, start, steps)
        assert centers == pytest.approx(expected, abs=1e-12)
        assert cost == pytest.approx(expected_cost)

    @given(st.integers(0, 999), st.integers(1, 8))
    @settings(max_examples=40, deadline=None)
    def test_seeds_equal_their_twin(self, seed: int, k: int) -> None:
        rows = np.random.default_rng(seed).normal(size=(40, 3))
        rng = np.random.default_rng(seed)
        expected = twins.spread_seeds(rows, int(rng.integers(40)), rng.random(k - 1))
        assert np.array_equal(spread_seeds(rows, k, np.random.default_rng(seed)), expected)
