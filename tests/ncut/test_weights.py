"""A point of weight w counts as w points, in every sum of the cut."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geohue.compute.lloyd import lloyd, spread_seeds
from geohue.compute.parallel import Workers
from geohue.ncut.affinity import affinity
from geohue.ncut.kernel import Kernel
from geohue.ncut.labels import find_centers
from geohue.ncut.nystrom import nystrom_cut
from geohue.settings.cut import LABELLINGS, Labelling
from twins import kernel as twins

ALONE = Workers(None)


@given(st.integers(0, 999), st.integers(1, 20), st.integers(1, 50))
@settings(max_examples=30, deadline=None)
def test_the_kernel_equals_its_twin(seed: int, d: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    x, z, weights = rng.normal(size=(40, d)), rng.normal(size=(n, d)), rng.uniform(0.1, 5, 40)
    kernel, w = Kernel.of(z, 0.9), affinity(x, z, 0.9)
    assert kernel.column_sums(x, weights) == pytest.approx(weights @ w, rel=1e-9)
    to_degree = rng.normal(size=n)
    expected = twins.gram(w, to_degree, weights)
    assert kernel.gram(x, to_degree, weights) == pytest.approx(expected, rel=1e-8)


def test_the_cut_is_that_of_repeated_points() -> None:
    rng = np.random.default_rng(1)
    x = rng.normal(size=(60, 5))
    weights = rng.integers(1, 5, 60)
    weighted = nystrom_cut(x, x[:20], ALONE, 4, 1.5, weights.astype(float))
    repeated = nystrom_cut(np.repeat(x, weights, axis=0), x[:20], ALONE, 4, 1.5)
    assert weighted.eigenvalues == pytest.approx(repeated.eigenvalues, abs=1e-9)
    assert weighted.entries(x, 4) == pytest.approx(repeated.entries(x, 4), abs=1e-7)


@given(st.integers(0, 999), st.integers(1, 5), st.integers(0, 8))
@settings(max_examples=30, deadline=None)
def test_k_means_is_that_of_repeated_rows(seed: int, k: int, steps: int) -> None:
    rng = np.random.default_rng(seed)
    rows, weights = rng.normal(size=(50, 3)), rng.integers(1, 5, 50)
    start = rows[:k]
    centers, cost = lloyd(rows, start, steps, weights.astype(float))
    expected, expected_cost = lloyd(np.repeat(rows, weights, axis=0), start, steps)
    assert centers == pytest.approx(expected, abs=1e-9)
    assert cost == pytest.approx(expected_cost)


def test_seeds_follow_the_weights() -> None:
    rows, weights = np.arange(4.0)[:, None], np.array([1, 0, 0, 0.0])
    weights[2] = 1e12  # the row of all the mass is the second seed, unless it is the first
    for seed in range(20):
        assert 2.0 in spread_seeds(rows, 2, np.random.default_rng(seed), weights)[:, 0]


@pytest.mark.parametrize("labelling", LABELLINGS)
def test_centers_are_those_of_repeated_rows(labelling: Labelling) -> None:
    rng = np.random.default_rng(2)
    rows = np.eye(3)[rng.integers(3, size=80)] + rng.normal(0, 0.25, (80, 3))
    rows /= np.linalg.norm(rows, axis=1)[:, None]
    weights = rng.integers(1, 9, 80)
    found = find_centers(rows, 3, labelling, rng, 0, weights.astype(float))
    expected = find_centers(np.repeat(rows, weights, axis=0), 3, labelling, rng, 0)
    assert found == pytest.approx(expected, abs=1e-6)
    if labelling != "qr":
        assert np.abs(found - find_centers(rows, 3, labelling, rng, 0)).max() > 1e-4
