from __future__ import annotations

import numpy as np
import pytest
from sklearn.cluster import KMeans
from sklearn.metrics import adjusted_rand_score

from geohue import GeohueError
from geohue.compute.lloyd import lloyd, nearest_center, spread_seeds
from geohue.ncut.labels import find_centers
from geohue.ncut.landmarks import choose_landmarks
from geohue.settings.cut import LABELLINGS, LANDMARK_CHOICES, Labelling, LandmarkChoice


def turned_axes(k: int, noise: float, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Unit rows around k orthogonal directions that are not the axes."""
    rng = np.random.default_rng(seed)
    truth = rng.integers(k, size=50 * k)
    turn, _ = np.linalg.qr(rng.normal(size=(k, k)))
    rows = turn[truth] + rng.normal(0, noise, (len(truth), k))
    return rows / np.linalg.norm(rows, axis=1, keepdims=True), truth


class TestLabels:
    @pytest.mark.parametrize("labelling", LABELLINGS)
    @pytest.mark.parametrize("k", [2, 3, 7])
    def test_finds_orthogonal_groups(self, labelling: Labelling, k: int) -> None:
        rows, truth = turned_axes(k, 0.08)
        centers = find_centers(rows, k, labelling, np.random.default_rng(0))
        assert adjusted_rand_score(truth, nearest_center(rows, centers)) == 1

    def test_a_restart_that_is_clearly_better_wins(self) -> None:
        rows = np.random.default_rng(8).normal(size=(60, 3))
        rows /= np.linalg.norm(rows, axis=1, keepdims=True)

        def cost(restarts: int) -> float:
            rng = np.random.default_rng(0)
            centers = find_centers(rows, 5, "kmeans", rng, restarts)
            return float(((rows[:, None] - centers) ** 2).sum(axis=2).min(axis=1).sum())

        assert cost(10) < 0.85 * cost(0)
        assert cost(10) <= cost(3) <= cost(0)

    def test_one_segment(self) -> None:
        rows = np.ones((4, 1))
        centers = find_centers(rows, 1, "kmeans", np.random.default_rng(0))
        assert nearest_center(rows, centers).tolist() == [0, 0, 0, 0]

    def test_unknown_labelling(self) -> None:
        with pytest.raises(GeohueError, match=r"labelling 'x'.*kmeans, rotation, qr"):
            find_centers(np.eye(2), 2, "x", np.random.default_rng(0))  # type: ignore[arg-type]


class TestLloyd:
    def test_hand_worked(self) -> None:
        rows = np.array([[0.0], [1.0], [9.0], [11.0]])
        centers, cost = lloyd(rows, np.array([[0.0], [1.0]]))
        assert centers.ravel().tolist() == [0.5, 10.0]
        assert cost == pytest.approx(0.5 + 2)

    def test_a_centre_without_rows_stays(self) -> None:
        centers, _ = lloyd(np.array([[0.0], [1.0]]), np.array([[0.5], [99.0]]))
        assert centers.ravel().tolist() == [0.5, 99.0]

    def test_agrees_with_scikit_learn_from_the_same_start(self) -> None:
        rows = np.random.default_rng(3).normal(size=(300, 4))
        start = rows[:5]
        _, cost = lloyd(rows, start, steps=100)
        theirs = KMeans(5, init=start, n_init=1, max_iter=100, tol=0).fit(rows)
        assert cost == pytest.approx(theirs.inertia_, rel=1e-9)

    def test_seeds_are_rows_and_take_the_same_chance(self) -> None:
        rows = np.random.default_rng(1).normal(size=(40, 2))
        one, two = np.random.default_rng(5), np.random.default_rng(5)
        seeds = spread_seeds(rows, 3, one)
        spread_seeds(np.zeros((40, 2)), 3, two)
        assert one.random() == two.random()
        assert all((rows == seed).all(axis=1).any() for seed in seeds)


class TestLandmarks:
    @pytest.mark.parametrize("choice", LANDMARK_CHOICES)
    def test_are_distinct_rows_in_order(self, choice: LandmarkChoice) -> None:
        x = np.random.default_rng(0).normal(size=(500, 6)).astype(np.float32)
        rows = choose_landmarks(x, 40, choice, np.random.default_rng(0))
        assert (np.diff(rows) > 0).all()
        assert 30 <= len(rows) <= 40
        assert 0 <= rows[0] < rows[-1] < 500

    def test_farthest_finds_the_small_part(self) -> None:
        x = np.zeros((1000, 2), np.float32)
        x[:3] = 50
        rows = choose_landmarks(x, 2, "farthest", np.random.default_rng(0))
        assert rows[0] < 3 <= rows[1]

    def test_kmeans_covers_better_than_random(self) -> None:
        rng = np.random.default_rng(0)
        x = np.vstack([rng.normal(0, 0.01, (900, 2)), rng.normal(5, 1, (100, 2))])
        x = x.astype(np.float32)

        def reach(choice: LandmarkChoice) -> float:
            rows = choose_landmarks(x, 20, choice, np.random.default_rng(1))
            d = np.linalg.norm(x[:, None] - x[rows][None], axis=2).min(axis=1)
            return float((d**2).mean())

        assert reach("kmeans") < 0.5 * reach("random")

    def test_more_than_there_are(self) -> None:
        x = np.zeros((3, 2), np.float32)
        assert choose_landmarks(x, 9, "random", np.random.default_rng(0)).tolist() == [0, 1, 2]

    def test_bad_choices(self) -> None:
        x = np.zeros((3, 2), np.float32)
        with pytest.raises(GeohueError, match="0 landmarks"):
            choose_landmarks(x, 0, "random", np.random.default_rng(0))
        with pytest.raises(GeohueError, match="choose one of random, kmeans, farthest"):
            choose_landmarks(x, 2, "best", np.random.default_rng(0))  # type: ignore[arg-type]
