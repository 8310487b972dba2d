from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from sklearn.cluster import SpectralClustering
from sklearn.datasets import make_blobs, make_circles, make_moons
from sklearn.metrics import adjusted_rand_score
from sklearn.utils.estimator_checks import parametrize_with_checks

from geohue import GeohueError, GeohueWarning, NystromNormalizedCut
from geohue.spectral import fit
from twins import cut as twins

Array = NDArray[np.float64]


@parametrize_with_checks(  # type: ignore[untyped-decorator]
    [
        NystromNormalizedCut(),
        NystromNormalizedCut(n_clusters="auto", store_embedding=True),
        NystromNormalizedCut(n_landmarks=10, assign_labels="cluster_qr"),
        NystromNormalizedCut(landmarks="random", assign_labels="discretize"),
        NystromNormalizedCut(landmarks="farthest", gamma=0.5, n_jobs=2),
    ]
)
# Two of the checks fit four distinct points, of which eight clusters cannot be made.
@pytest.mark.filterwarnings("ignore:found 4 of 8 clusters:geohue.GeohueWarning")
def test_scikit_learn(estimator: Any, check: Any) -> None:
    check(estimator)


def blobs(n: int = 400, d: int = 3, k: int = 4, seed: int = 0) -> Array:
    x, _ = make_blobs(n, d, centers=k, cluster_std=1.5, random_state=seed)
    return np.asarray(x)


def cut(x: Any, **asked: Any) -> NystromNormalizedCut:
    asked = {"n_clusters": 4, "n_landmarks": 60, "random_state": 0} | asked
    return NystromNormalizedCut(**asked).fit(x)


@pytest.fixture
def small_sample(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make a few hundred rows a large data set."""
    monkeypatch.setattr(fit, "SAMPLE", 300)


class TestIsTheNormalizedCut:
    @pytest.mark.parametrize("d", [1, 2, 4, 7, 64])
    def test_all_landmarks_give_the_eigenvalues_of_the_definition(self, d: int) -> None:
        x, gamma = np.random.default_rng(d).normal(size=(80, d)), 2.0 / d
        model = cut(x, gamma=gamma, n_landmarks=80)
        w = np.exp(-gamma * ((x[:, None] - x[None]) ** 2).sum(axis=2))
        values, _ = twins.exact_cut(w, 4)
        # Numerically empty directions are left out, which costs the last digits.
        assert model.eigenvalues_ == pytest.approx(values, abs=1e-6)
        assert model.gamma_ == pytest.approx(gamma)

    @pytest.mark.parametrize("assign", ["kmeans", "cluster_qr", "discretize"])
    @pytest.mark.parametrize("make", [make_moons, make_circles])
    def test_agrees_with_spectral_clustering(self, make: Any, assign: Any) -> None:
        shape = {"factor": 0.5} if make is make_circles else {}
        x, truth = make(600, noise=0.04, random_state=1, **shape)
        ours = cut(x, n_clusters=2, gamma=60, n_landmarks=200, assign_labels=assign)
        theirs = SpectralClustering(2, gamma=60, random_state=0).fit(x)
        assert adjusted_rand_score(ours.labels_, theirs.labels_) == 1
        assert adjusted_rand_score(ours.labels_, truth) == 1

    def test_auto_finds_width_and_number(self) -> None:
        x, truth = make_blobs(2000, 10, centers=7, random_state=2)
        model = cut(x, n_clusters="auto", n_landmarks=300)
        assert model.n_clusters_ == 7
        assert adjusted_rand_score(truth, model.labels_) == 1
        assert cut(x, n_clusters="auto", max_clusters=5).n_clusters_ <= 5

    def test_the_embedding_has_directions_of_the_clusters(self) -> None:
        x, truth = make_blobs(900, 6, centers=4, random_state=3)
        model = cut(x, store_embedding=True)
        rows = model.transform(x)
        assert np.array_equal(model.embedding_, rows)
        assert np.linalg.norm(rows, axis=1) == pytest.approx(1)
        same = truth[:, None] == truth[None]
        cosines = rows @ rows.T
        assert cosines[same].min() > 0.95
        assert np.abs(cosines[~same]).max() < 0.3
        assert not hasattr(cut(x), "embedding_")


class TestLaws:
    @given(st.integers(0, 999))
    @settings(max_examples=15, deadline=None)
    def test_the_order_of_the_rows_is_nothing(self, seed: int) -> None:
        x = blobs(seed=seed)
        order = np.random.default_rng(seed).permutation(len(x))
        assert np.array_equal(cut(x[order]).labels_, cut(x).labels_[order])

    @pytest.mark.usefixtures("small_sample")
    def test_nor_where_there_are_more_rows_than_the_sample_holds(self) -> None:
        x = blobs(5000)
        order = np.random.default_rng(0).permutation(len(x))
        # In single precision, with sums in another order.
        assert (cut(x[order]).labels_ == cut(x).labels_[order]).mean() > 0.999

    @given(st.integers(0, 999), st.floats(1e-6, 1e6), st.floats(-1e3, 1e3))
    @settings(max_examples=15, deadline=None)
    def test_scale_and_place_are_nothing(self, seed: int, scale: float, shift: float) -> None:
        x = blobs(seed=seed)
        # Random landmarks: of two points that share a centre of k-means, rounding picks one.
        one, other = (cut(rows, landmarks="random") for rows in (x, scale * (x + shift)))
        assert other.gamma_ * scale**2 == pytest.approx(one.gamma_, rel=1e-6)
        assert adjusted_rand_score(one.labels_, other.labels_) > 0.99

    def test_a_gamma_that_is_given_is_in_the_units_of_the_data(self) -> None:
        x = blobs()
        one, other = cut(x, gamma=0.125), cut(8 * x, gamma=0.125 / 64)
        assert other.eigenvalues_ == pytest.approx(one.eigenvalues_, abs=1e-9)
        assert cut(x, gamma=0.25).eigenvalues_[1] > one.eigenvalues_[1]

    @pytest.mark.parametrize("n_jobs", [2, -1])
    def test_threads_are_nothing(self, n_jobs: int) -> None:
        x = blobs(30_000)
        one, many = cut(x), cut(x, n_jobs=n_jobs)
        assert np.array_equal(one.labels_, many.labels_)
        assert np.array_equal(one.transform(x[:9000]), many.transform(x[:9000]))

    @pytest.mark.parametrize("dtype", [np.float32, np.float64, np.int16])
    @pytest.mark.parametrize("n", [400, 30_000])
    def test_predict_gives_the_labels_of_the_fit(self, n: int, dtype: type) -> None:
        x: NDArray[Any] = (20 * blobs(n, d=4)).astype(dtype)
        model = cut(x)
        assert np.array_equal(model.predict(x), model.labels_)
        assert np.array_equal(model.predict(x[37:41]), model.labels_[37:41])
        sizes = np.bincount(model.labels_)
        assert (np.diff(sizes) <= 0).all()

    @given(st.integers(0, 999))
    @settings(max_examples=15, deadline=None)
    def test_a_weight_is_a_number_of_rows(self, seed: int) -> None:
        x = blobs(seed=seed)
        weights = np.random.default_rng(seed).integers(0, 4, len(x))
        weighted = NystromNormalizedCut(4, n_landmarks=60, random_state=0).fit(x, None, weights)
        repeated = cut(np.repeat(x, weights, axis=0))
        assert weighted.gamma_ == pytest.approx(repeated.gamma_)
        assert weighted.eigenvalues_ == pytest.approx(repeated.eigenvalues_, abs=1e-9)
        assert np.array_equal(weighted.predict(x), repeated.predict(x))

    @pytest.mark.usefixtures("small_sample")
    def test_nor_does_a_large_set_tell_weights_from_rows(self) -> None:
        x = blobs(3000)
        weights = np.random.default_rng(0).integers(0, 4, len(x))
        weighted = NystromNormalizedCut(4, n_landmarks=60, random_state=0).fit(x, None, weights)
        repeated = cut(np.repeat(x, weights, axis=0))
        assert weighted.eigenvalues_ == pytest.approx(repeated.eigenvalues_, abs=1e-4)
        assert (weighted.predict(x) == repeated.predict(x)).mean() > 0.999

    def test_the_unit_of_the_weights_is_nothing(self) -> None:
        x = blobs()
        weights = np.random.default_rng(0).uniform(0.5, 2, len(x))
        one, other = (NystromNormalizedCut(4, random_state=0) for _ in range(2))
        one.fit(x, sample_weight=weights)
        other.fit(x, sample_weight=1e-3 * weights)
        assert other.eigenvalues_ == pytest.approx(one.eigenvalues_, abs=1e-9)
        assert np.array_equal(one.labels_, other.labels_)


class TestLarge:
    @pytest.mark.parametrize("dtype", [np.float32, np.int16])
    @pytest.mark.parametrize("n", [5_000, 70_000])
    def test_a_memory_map_gives_the_very_labels(self, tmp_path: Path, n: int, dtype: type) -> None:
        x: NDArray[Any] = (20 * blobs(n)).astype(dtype)
        np.save(tmp_path / "x.npy", x)
        weights = np.random.default_rng(0).uniform(size=n)
        mapped = np.load(tmp_path / "x.npy", mmap_mode="r")
        for weight in (None, weights):
            whole = NystromNormalizedCut(4, random_state=0).fit(x, sample_weight=weight)
            for chunk_rows in (1, 20_000, 10**6):
                large = NystromNormalizedCut(4, random_state=0, n_jobs=2)
                large.fit_large(mapped, chunk_rows=chunk_rows, sample_weight=weight)
                assert np.array_equal(large.labels_, whole.labels_)
                assert np.array_equal(large.eigenvalues_, whole.eigenvalues_)
                assert np.array_equal(large.transform(x[:9]), whole.transform(x[:9]))

    def test_what_cannot_be_read(self) -> None:
        x = blobs(40_000)
        x[33_000, 1] = np.nan
        model = NystromNormalizedCut(4)
        with pytest.raises(GeohueError, match="row 33000 of X has NaN"):
            model.fit_large(x)
        with pytest.raises(GeohueError, match=r"X has shape \(5,\)"):
            model.fit_large(np.zeros(5))
        with pytest.raises(GeohueError, match=r"X has shape \(0, 3\)"):
            model.fit_large(np.zeros((0, 3)))
        with pytest.raises(GeohueError, match="type complex128: expected real"):
            model.fit_large(np.zeros((5, 2), complex))
        with pytest.raises(GeohueError, match="chunk_rows is 0"):
            model.fit_large(x, chunk_rows=0)

    @pytest.mark.usefixtures("small_sample")
    def test_a_wide_extent_is_computed_in_double_precision(self) -> None:
        # Two pairs of groups, 3 widths apart within a pair, the pairs 10^5 widths apart.
        truth = np.arange(4000) % 4
        x = np.array([0.0, 5, 1e5, 1e5 + 5])[truth] + np.random.default_rng(0).normal(0, 0.2, 4000)
        model = cut(x[:, None], gamma=0.5)
        assert adjusted_rand_score(truth, model.labels_) == 1

    @pytest.mark.usefixtures("small_sample")
    def test_small_distances_far_from_the_origin_survive(self) -> None:
        x = blobs(4000)
        assert adjusted_rand_score(cut(x + 1e7).labels_, cut(x).labels_) > 0.95


class TestEdges:
    def test_strays_and_numbers_near_the_largest(self) -> None:
        model = cut(blobs())
        far = np.array([[1e300, -1e300, 0], [1e9, 0, 0], [0, -1.7e308, 1.7e308]])
        assert set(model.predict(far)) <= set(range(4))
        assert np.isfinite(model.transform(far)).all()
        huge = cut(1e305 * blobs())
        assert np.array_equal(huge.labels_, cut(blobs()).labels_)
        tiny = cut(1e-300 * blobs())
        assert np.array_equal(tiny.labels_, huge.labels_)

    def test_fewer_distinct_rows_than_clusters(self) -> None:
        x = np.repeat([[0.0, 1], [5, 5]], 6, axis=0)
        with pytest.warns(GeohueWarning, match="found 2 of 4 clusters"):
            model = cut(x)
        assert model.labels_.tolist() == [0] * 6 + [1] * 6 or model.labels_[0] == 1
        assert model.transform(x).shape == (12, 2)

    def test_one_cluster(self) -> None:
        model = cut(blobs(), n_clusters=1)
        assert not model.labels_.any()
        assert model.transform(blobs()).shape == (400, 1)
        assert cut(np.zeros((5, 2)), n_clusters="auto").n_clusters_ == 1

    @pytest.mark.parametrize(
        ("asked", "message"),
        [
            ({"n_clusters": 0}, 'n_clusters is 0: .* or "auto"'),
            ({"n_clusters": 2.5}, "n_clusters is 2.5"),
            ({"n_clusters": 500}, "n_samples=400 should be at least n_clusters=500"),
            ({"gamma": 0}, "gamma is 0: expected a positive number"),
            ({"gamma": np.nan}, "gamma is nan"),
            ({"gamma": "scale"}, "gamma is 'scale'"),
            ({"n_landmarks": True}, "n_landmarks is True"),
            ({"n_init": 0}, "n_init is 0"),
            ({"max_clusters": -1}, "max_clusters is -1"),
            ({"landmarks": "best"}, "landmarks 'best': choose one of random"),
            ({"assign_labels": "rotation"}, "choose one of kmeans, discretize, cluster_qr"),
        ],
    )
    def test_bad_settings(self, asked: dict[str, Any], message: str) -> None:
        with pytest.raises(GeohueError, match=message):
            cut(blobs(), **asked)

    @pytest.mark.parametrize(
        ("weights", "message"),
        [
            (np.ones(399), r"shape \(399,\): expected \(400,\)"),
            (np.ones((400, 1)), r"shape \(400, 1\)"),
            (np.linspace(-1, 1, 400), "negative"),
            (np.full(400, np.nan), "finite"),
            (np.zeros(400), "zero everywhere"),
        ],
    )
    def test_bad_weights(self, weights: Array, message: str) -> None:
        with pytest.raises(GeohueError, match=message):
            NystromNormalizedCut(4).fit(blobs(), sample_weight=weights)


WITHOUT = """
import sys
sys.modules["sklearn"] = None
import geohue
from geohue import *
geohue.segment, geohue.Scene
try:
    geohue.NystromNormalizedCut
except geohue.GeohueError as error:
    print(error)
"""

WITH = """
import sys, geohue, geohue.cli
geohue.segment, geohue.Scene
print("sklearn" in sys.modules)
geohue.NystromNormalizedCut
print("sklearn" in sys.modules)
"""


@pytest.mark.parametrize(
    ("code", "said"),
    [
        (WITHOUT, "NystromNormalizedCut needs scikit-learn 1.6 or newer: pip install 'geohue[skl"),
        (WITH, "False\nTrue"),
    ],
)
def test_scikit_learn_is_loaded_by_the_estimator_alone(code: str, said: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=100
    )
    assert done.stdout.startswith(said)
