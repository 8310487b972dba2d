from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geohue import GeohueError
from geohue.compute.parallel import Workers
from geohue.ncut.nystrom import NystromCut, nystrom_cut
from geohue.ncut.selectors import (
    choose_k,
    eigengap,
    elongated_kmeans,
    rotation_cost,
    self_tuning,
)
from geohue.settings.cut import SELECTORS, Selector


def cut_of(x: np.ndarray, m: int = 11) -> NystromCut:
    rng = np.random.default_rng(0)
    landmarks = x[rng.choice(len(x), min(80, len(x)), replace=False)]
    return nystrom_cut(x, landmarks, Workers(None), m)


def groups(k: int, spread: float = 0.12, n: int = 1500) -> np.ndarray:
    rng = np.random.default_rng(k)
    centers = 2.2 * np.vstack([np.zeros(6), np.eye(6), -np.eye(6)])[:k]
    return (centers[np.arange(n) % k] + rng.normal(0, spread, (n, 6))).astype(np.float32)


@pytest.mark.parametrize(
    ("selector", "k"),
    [(s, k) for s in SELECTORS for k in (2, 3, 5, 8) if (s, k) != ("elongated", 8)],
)
def test_counts_separate_groups(selector: Selector, k: int) -> None:
    x = groups(k)
    assert choose_k(cut_of(x), x, selector) == k


@pytest.mark.parametrize("selector", SELECTORS)
def test_one_cloud_is_one_segment(selector: Selector) -> None:
    rng = np.random.default_rng(0)
    blob = rng.normal(0, 0.7, (3000, 6)).astype(np.float32)
    assert choose_k(cut_of(blob), blob, selector) == 1
    point = np.zeros((10, 6), np.float32)
    assert choose_k(cut_of(point), point, selector) == 1


def test_eigengap_by_hand() -> None:
    assert eigengap(np.array([1.0, 1.0, 0.9, 0.2]), steps=1) == 3
    # After two steps 0.9 is 0.81 and 0.6 is 0.36: the fall is after the third either way; but
    # 1 -> 0.7 -> 0.39 becomes 1 -> 0.49 -> 0.15, and the first fall wins.
    assert eigengap(np.array([1.0, 0.7, 0.39]), steps=1, k_max=2) == 2
    assert eigengap(np.array([1.0, 0.7, 0.39]), steps=2, k_max=2) == 1
    assert eigengap(np.array([1.0])) == 1
    assert eigengap(np.ones(12), k_max=4) == 1  # no fall within reach


def test_elongated_groups_along_rays_count_once() -> None:
    rng = np.random.default_rng(1)
    lengths = rng.uniform(0.2, 1.0, 400)  # radially spread, as rows are that are not normalised
    rows = np.eye(4)[np.arange(400) % 4] * lengths[:, None]
    padded = np.hstack([rows, np.zeros((400, 3))])
    assert elongated_kmeans(padded + rng.normal(0, 0.005, padded.shape)) == 4


@given(st.integers(2, 5), st.integers(0, 1000))
@settings(max_examples=15, deadline=None)
def test_rotation_cost_is_1_on_turned_axes_and_more_otherwise(k: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(rng.normal(size=(k, k)))
    on_axes = np.repeat(np.eye(k), 20, axis=0) @ turn
    assert rotation_cost(on_axes) == pytest.approx(1, abs=1e-3)
    anywhere = rng.normal(size=(400, k))
    assert 1.03 < rotation_cost(anywhere) <= k


@given(st.integers(0, 1000))
@settings(max_examples=15, deadline=None)
def test_rotation_cost_in_the_plane_is_the_least_of_all_angles(seed: int) -> None:
    rng = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(rng.normal(size=(2, 2)))
    # Groups of different sizes and spreads: the best axes are not those of any of the rows.
    rows = np.repeat(np.eye(2), [40, 15], axis=0) @ turn
    rows += rng.normal(0.1, 0.15, rows.shape)
    angles = np.radians(np.arange(0, 90, 0.1))
    axes = np.stack([np.cos(angles), np.sin(angles)])
    along = np.stack([rows @ axes, rows @ np.stack([-axes[1], axes[0]])]) ** 2
    least = (along.sum(axis=0) / along.max(axis=0)).mean(axis=0).min()
    assert rotation_cost(rows) == pytest.approx(least, abs=3e-4)


def test_self_tuning_does_not_take_what_aligns_worse() -> None:
    two = np.repeat(np.eye(2), 50, axis=0)
    three = np.random.default_rng(0).normal(size=(100, 3))
    assert self_tuning(lambda k: two if k == 2 else three, 3) == 2


def test_self_tuning_prefers_the_largest_of_equals() -> None:
    rows = np.repeat(np.eye(6), 10, axis=0)
    assert self_tuning(lambda k: rows[: 10 * k, :k], 6) == 6
    assert self_tuning(lambda k: rows[:, :k], 1) == 1


def test_unknown_selector() -> None:
    x = groups(2)
    with pytest.raises(GeohueError, match="eigengap, elongated, rotation"):
        choose_k(cut_of(x), x, "guess")  # type: ignore[arg-type]
