"""k-means and mean shift on p^f."""

from __future__ import annotations

import numpy as np
import pytest
from sklearn.cluster import KMeans, MeanShift

from geohue import Scene
from geohue.baselines.kmeans import best_centers
from geohue.baselines.meanshift import find_modes
from geohue.baselines.sampling import mixed_vectors, thinned
from geohue.compute.lloyd import nearest_center
from geohue.features import extract_features


def blobs(n: int = 60) -> np.ndarray:
    rng = np.random.default_rng(2)
    middle = np.array([[0, 0], [6, 0], [0, 6], [6, 7]])
    return np.concatenate([rng.normal(m, 0.8, (n, 2)) for m in middle])


def test_kmeans_costs_no_more_than_scikit_learn() -> None:
    rows = blobs()
    for k in (2, 3, 4, 6):
        centers = best_centers(rows, k, seed=0)
        cost = ((rows - centers[nearest_center(rows, centers)]) ** 2).sum()
        other = KMeans(k, n_init=10, random_state=0).fit(rows).inertia_
        assert cost <= other * 1.05


def test_kmeans_of_more_clusters_than_distinct_points() -> None:
    centers = best_centers(np.array([[1.0], [1.0], [2.0]]), 3, seed=0)
    assert set(centers[:, 0]) == {1.0, 2.0}


def test_mean_shift_is_scikit_learns_on_the_same_points() -> None:
    rows = blobs().astype(np.float32)
    modes = find_modes(rows, bandwidth=2.0)
    full = MeanShift(bandwidth=2.0).fit(rows)  # a start from every point, no bins
    assert len(modes) == len(full.cluster_centers_) == 4
    np.testing.assert_array_equal(nearest_center(rows, modes), full.labels_)


def test_mean_shift_derives_its_bandwidth() -> None:
    rows = blobs().astype(np.float32)
    assert len(find_modes(rows)) == 4
    assert len(find_modes(rows * 1000)) == 4


def test_mean_shift_of_one_value() -> None:
    assert find_modes(np.ones((9, 3), np.float32)).tolist() == [[1.0, 1.0, 1.0]]


def test_vectors_of_one_cue_ignore_the_weight() -> None:
    rgb = np.random.default_rng(0).integers(0, 255, (6, 7, 3)).astype(np.uint8)
    scene = Scene.from_rgbd(rgb, np.linspace(1, 2, 42).reshape(6, 7))
    geometry = extract_features(scene, "geometry")
    np.testing.assert_array_equal(mixed_vectors(geometry, 0.0), geometry.geometry)
    fusion = extract_features(scene)
    np.testing.assert_allclose(
        mixed_vectors(fusion, 2.0) * np.sqrt(5), fusion.vectors(2.0), atol=1e-5
    )
    np.testing.assert_allclose(mixed_vectors(fusion, np.inf)[:, 3:], fusion.geometry)


@pytest.mark.parametrize("hole", [False, True])
def test_thinning_keeps_points_that_have_the_cues(hole: bool) -> None:
    depth = np.full((40, 40), np.nan) if hole else np.ones((40, 40))
    depth[2, 2:8] = 1.5
    scene = Scene.from_rgbd(np.zeros((40, 40, 3), np.uint8), depth)
    features = extract_features(scene, "geometry")
    few = thinned(scene, features, 100, seed=0)
    assert len(few) == (6 if hole else 100)
