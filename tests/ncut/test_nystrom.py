from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.linalg import subspace_angles

from geohue.compute.parallel import Workers, workers
from geohue.ncut.affinity import FAINTEST, affinity
from geohue.ncut.nystrom import nystrom_cut
from twins import cut as twins

ALONE = Workers(None)


def blobs(n: int, seed: int, spread: float = 0.3) -> NDArray[np.float64]:
    """Three groups of points in 6-D."""
    rng = np.random.default_rng(seed)
    centers = np.zeros((3, 6))
    centers[1, 0], centers[2, 4] = 3, 3
    return centers[np.arange(n) % 3] + rng.normal(0, spread, (n, 6))


class TestAffinity:
    def test_equals_the_pairwise_definition(self) -> None:
        x, z = blobs(40, 0), blobs(7, 1)
        assert np.allclose(affinity(x, z, 0.7), twins.dense_affinity(x, z, 0.7), atol=1e-13)

    def test_float32_is_close_to_float64(self) -> None:
        x, z = blobs(300, 0), blobs(20, 1)
        single = affinity(x.astype(np.float32), z.astype(np.float32), 0.4)
        assert single.dtype == np.float32
        assert np.abs(single - affinity(x, z, 0.4)).max() < 2e-5

    def test_a_point_seen_by_nobody_keeps_the_ratios(self) -> None:
        z = np.array([[0.0], [1.0]])
        row = affinity(np.array([[100.0]]), z, scale=1.0)[0]
        assert row.max() == pytest.approx(np.exp(FAINTEST))
        assert row[1] > row[0] > 0
        near = affinity(np.array([[4.0]]), z, scale=1.0)[0]
        assert near == pytest.approx(np.exp([-8.0, -4.5]))

    @given(st.floats(-1e4, 1e4), st.floats(0.05, 5))
    def test_is_always_a_number_between_0_and_1(self, at: float, scale: float) -> None:
        w = affinity(np.array([[at]], np.float32), np.array([[0.0], [1.0]], np.float32), scale)
        assert ((w > 0) & (w <= 1)).all()


class TestNystrom:
    @pytest.mark.parametrize("seed", range(3))
    def test_one_shot_and_two_step_agree_with_the_fast_form(self, seed: int) -> None:
        x = blobs(60, seed)
        n, m, scale = 12, 4, 0.8
        w = twins.dense_affinity(x[:n], x, scale)
        a, b = w[:, :n], w[:, n:]
        # The forms are equal where A is well conditioned and no degree falls below its floor.
        assert np.linalg.cond(a) < 1e6
        assert (b.T @ np.linalg.solve(a, w.sum(axis=1))).min() > 1
        one, v_one = twins.one_shot_nystrom(a, b, m)
        two, v_two = twins.two_step_nystrom(a, b, m)
        assert np.abs(one - two).max() < 1e-10
        assert np.abs(twins.aligned(v_two, v_one) - v_one).max() < 1e-8
        cut = nystrom_cut(x, x[:n], ALONE, m, scale)
        assert np.abs(cut.eigenvalues - one).max() < 1e-10
        entries = twins.aligned(cut.entries(x, m).astype(float), v_one)
        assert np.abs(entries - v_one).max() < 1e-8

    def test_with_every_point_a_landmark_it_is_the_exact_cut(self) -> None:
        x = blobs(90, 3)
        values, vectors = twins.exact_cut(twins.dense_affinity(x, x, 0.5), 5)
        cut = nystrom_cut(x, x, ALONE, 5, 0.5)
        assert np.abs(cut.eigenvalues - values).max() < 1e-9
        entries = twins.aligned(cut.entries(x, 5).astype(float), vectors)
        assert np.abs(entries - vectors).max() < 1e-6

    def test_few_landmarks_come_close_to_the_exact_cut(self) -> None:
        x = blobs(600, 4)
        _, vectors = twins.exact_cut(twins.dense_affinity(x, x, 0.6), 3)
        cut = nystrom_cut(x, x[:60], ALONE, 3, 0.6)
        angle = np.degrees(subspace_angles(cut.entries(x, 3), vectors).max())
        assert angle < 2

    def test_coinciding_landmarks_change_nothing(self) -> None:
        x = blobs(60, 5)
        once = nystrom_cut(x, x[:10], ALONE, 3, 0.5)
        twice = nystrom_cut(x, np.vstack([x[:10], x[:10]]), ALONE, 3, 0.5)
        assert np.allclose(once.eigenvalues, twice.eigenvalues, atol=1e-9)
        assert np.allclose(once.rows(x, 3), twice.rows(x, 3), atol=1e-6)

    def test_one_point_only(self) -> None:
        x = np.zeros((5, 6), np.float32)
        cut = nystrom_cut(x, x, ALONE, 3)
        assert cut.eigenvalues == pytest.approx([1.0], abs=1e-5)
        assert np.isfinite(cut.rows(x, 1)).all()

    def test_strays_get_the_direction_of_their_nearest_group(self) -> None:
        x = blobs(300, 6).astype(np.float32)
        far = x[:1].copy()
        far[0, 0] = -500.0
        cut = nystrom_cut(np.vstack([x, far]), x[:30], ALONE, 3, 0.4)
        rows = cut.rows(np.vstack([x, far]), 3)
        assert np.isfinite(rows).all()
        assert np.linalg.norm(rows[-1]) == pytest.approx(1, abs=1e-4)

    @given(st.integers(0, 2**16))
    @settings(max_examples=20, deadline=None)
    def test_threads_change_not_one_bit(self, seed: int) -> None:
        x = np.random.default_rng(seed).normal(size=(9000, 6)).astype(np.float32)
        with workers(1) as one, workers(3) as three:
            cuts = [
                nystrom_cut(x, x[:20], one, 4),
                nystrom_cut(x, x[:20], three, 4),
            ]
        for other in cuts[1:]:
            assert np.array_equal(cuts[0].basis, other.basis)
            assert np.array_equal(cuts[0].eigenvalues, other.eigenvalues)
