"""The normalized cut as an estimator of scikit-learn, for any vectors."""

from __future__ import annotations

import warnings
from numbers import Integral, Real
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geohue.errors import GeohueError, GeohueWarning

try:
    from joblib import effective_n_jobs
    from sklearn.base import (
        BaseEstimator,
        ClassNamePrefixFeaturesOutMixin,
        ClusterMixin,
        TransformerMixin,
    )
    from sklearn.utils import check_random_state
    from sklearn.utils.validation import check_is_fitted, validate_data
except ImportError as error:
    raise GeohueError(
        "NystromNormalizedCut needs scikit-learn 1.6 or newer: pip install 'geohue[sklearn]'"
    ) from error

from geohue.compute.arrays import Floats, Rows
from geohue.compute.parallel import workers
from geohue.settings.cut import LANDMARK_CHOICES, Labelling, LandmarkChoice
from geohue.spectral.fit import Settings, fit_spectral
from geohue.spectral.model import SpectralModel
from geohue.spectral.source import Streamed

_LABELLINGS: dict[str, Labelling] = {
    "kmeans": "kmeans",
    "discretize": "rotation",
    "cluster_qr": "qr",
}


class NystromNormalizedCut(
    ClassNamePrefixFeaturesOutMixin, TransformerMixin, ClusterMixin, BaseEstimator
):
    r"""Spectral clustering of many vectors: the normalized cut by the Nystrom method.

    What `sklearn.cluster.SpectralClustering` with ``affinity="rbf"`` computes from the N x N
    affinities, from those to a few landmarks: time and memory grow with N, not with its square,
    and new vectors get labels. Needs ``pip install "geohue[sklearn]"``.

    Vectors are taken as they are: standardize features of different units first.

    Parameters
    ----------
    n_clusters : int or "auto", default 8
        Number of clusters; "auto" takes the largest gap of the eigenvalues (`choose_k`), which
        is a guess: it finds 1 where the clusters overlap much.
    gamma : float or "auto", default "auto"
        The affinity of two vectors at the distance d is :math:`\exp(-\gamma d^2)`, that is
        :math:`\exp(-d^2 / (2 \sigma^2))` with :math:`\gamma = 1 / (2 \sigma^2)`. "auto": sigma is
        the distance within which a typical vector has 2 % of all, or a quarter of an average
        cluster if that is less (`neighbour_width`). A smaller gamma gives rounder clusters.
    n_landmarks : int, default 300
        Vectors that stand for all others, at least twice the number of clusters. With all of them
        the cut is the exact one.
    landmarks : {"kmeans", "random", "farthest"}, default "kmeans"
        How they are chosen, from a sample of 8,192 (`choose_landmarks`).
    assign_labels : {"kmeans", "discretize", "cluster_qr"}, default "kmeans"
        From eigenvectors to labels, as in SpectralClustering (`find_centers`).
    n_init : int, default 5
        Starts of k-means, the first of them not random.
    max_clusters : int, default 10
        Largest answer of ``n_clusters="auto"``.
    store_embedding : bool, default False
        Keep `embedding_`, N x n_clusters numbers.
    random_state : int, RandomState or None
        The source of chance.
    n_jobs : int or None
        Threads; None is 1, -1 all cores. It does not change the labels.

    Attributes
    ----------
    labels_ : (N,) int32
        Cluster of each vector of the fit; 0 is the largest.
    n_clusters_ : int
        Clusters found; fewer than asked for where too few vectors differ.
    gamma_ : float
        The gamma used.
    eigenvalues_ : (m,) float64
        Of the normalized affinity, the largest first.
    embedding_ : (N, K) float
        `transform` of the vectors of the fit, with `store_embedding`.
    n_features_in_, feature_names_in_
        As in every estimator of scikit-learn.

    Notes
    -----
    Up to 20,000 distinct vectors all is computed in double precision, and the order of the rows
    changes nothing. Of more, landmarks, gamma, "auto" and the centres come from a sample of
    20,000, drawn by a hash of the vectors, and the eigenvectors from all, in single precision
    where that is enough.

    `sample_weight` counts a row as so many equal rows, in the degrees, the eigenvectors and the
    centres. A row of weight 0 has no say, and gets a label.

    References
    ----------
    C. Fowlkes, S. Belongie, F. Chung, J. Malik, "Spectral grouping using the Nystrom method",
    PAMI 26(2), 2004; A. Ng, M. Jordan, Y. Weiss, "On spectral clustering", NIPS 2001.

    Examples
    --------
    >>> from sklearn.datasets import make_circles
    >>> X, ring = make_circles(1000, noise=0.05, factor=0.5, random_state=0)
    >>> model = NystromNormalizedCut(n_clusters=2, gamma=50, random_state=0).fit(X)
    >>> [len(set(ring[model.labels_ == i])) for i in range(2)]
    [1, 1]
    >>> bool(model.predict([[0.5, 0.0]]) == model.predict([[0.0, 0.5]]))
    True
    """

    def __init__(
        self,
        n_clusters: int | Literal["auto"] = 8,
        *,
        gamma: float | Literal["auto"] = "auto",
        n_landmarks: int = 300,
        landmarks: LandmarkChoice = "kmeans",
        assign_labels: Literal["kmeans", "discretize", "cluster_qr"] = "kmeans",
        n_init: int = 5,
        max_clusters: int = 10,
        store_embedding: bool = False,
        random_state: Any = None,
        n_jobs: int | None = None,
    ) -> None:
        self.n_clusters = n_clusters
        self.gamma = gamma
        self.n_landmarks = n_landmarks
        self.landmarks = landmarks
        self.assign_labels = assign_labels
        self.n_init = n_init
        self.max_clusters = max_clusters
        self.store_embedding = store_embedding
        self.random_state = random_state
        self.n_jobs = n_jobs

    def fit(
        self,
        X: ArrayLike,
        y: object = None,  # noqa: ARG002
        sample_weight: ArrayLike | None = None,
    ) -> NystromNormalizedCut:
        """Cluster vectors.

        Parameters
        ----------
        X : (N, D) float
            The vectors; float32 and float64 are not copied, a memory map is read in blocks.
        y : ignored
        sample_weight : (N,) float, optional
            As how many rows each counts.

        Returns
        -------
        NystromNormalizedCut
            Itself.

        Raises
        ------
        ValueError
            For vectors or weights that cannot be used; `GeohueError` for settings.
        """
        rows = validate_data(self, X, dtype=[np.float64, np.float32])
        return self._fit(rows, sample_weight, rows.dtype)

    def fit_large(
        self, X: Any, *, chunk_rows: int = 65_536, sample_weight: ArrayLike | None = None
    ) -> NystromNormalizedCut:
        """Cluster vectors that do not fit into memory.

        Gives the labels of `fit`, to the last one, for any `chunk_rows`. In memory are two chunks,
        the sample of 20,000 vectors and the labels.

        Parameters
        ----------
        X : (N, D) numbers on disk
            Whatever has ``shape``, ``dtype`` and rows by slice: `numpy.memmap`, an HDF5 or Zarr
            array. It is read four times, up to 20,000 distinct vectors twice.
        chunk_rows : int
            Rows to read at a time, rounded up to a multiple of 16,384.
        sample_weight : (N,) float, optional
            As how many rows each counts.

        Returns
        -------
        NystromNormalizedCut
            Itself.

        Raises
        ------
        GeohueError
            If X is no table of finite real numbers.
        """
        rows = Streamed(X, chunk_rows)
        first = validate_data(self, rows[0:1], dtype=[np.float64, np.float32])
        return self._fit(rows, sample_weight, first.dtype)

    def predict(self, X: ArrayLike) -> NDArray[np.int32]:
        """Return the cluster of each vector, (M,), by the Nystrom extension; X as in `fit`."""
        rows = self._checked(X)
        with workers(effective_n_jobs(self.n_jobs)) as team:
            return self._model.labels(rows, team)

    def transform(self, X: ArrayLike) -> Floats:
        """Return the entries of the leading eigenvectors, ``(M, n_clusters_)``, rows of length 1.

        The cluster is the nearest of a few directions in this space, if labels come from k-means
        the nearest centre. Points of one cluster lie close together.
        """
        rows = self._checked(X)
        with workers(effective_n_jobs(self.n_jobs)) as team:
            return self._model.embedding(rows, team, rows.dtype)

    @property
    def _n_features_out(self) -> int:
        return int(self._model.model.centers.shape[1])

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.transformer_tags.preserves_dtype = ["float64", "float32"]
        return tags

    def _checked(self, X: ArrayLike) -> Floats:
        check_is_fitted(self)
        rows: Floats = validate_data(self, X, dtype=[np.float64, np.float32], reset=False)
        return rows

    def _fit(
        self, rows: Rows, sample_weight: ArrayLike | None, dtype: np.dtype[Any]
    ) -> NystromNormalizedCut:
        settings = self._settings(len(rows))
        weights = _weights(sample_weight, len(rows))
        seed = int(check_random_state(self.random_state).randint(2**31 - 1))
        with workers(effective_n_jobs(self.n_jobs)) as team:
            model = fit_spectral(rows, weights, settings, seed, team)
            found = model.labels(rows, team)
            order, number = _by_size(found, weights, model.model.k)
            self._model: SpectralModel = model.renumbered(order)
            self.labels_: NDArray[np.int32] = number[found]
            if self.store_embedding:
                self.embedding_ = self._model.embedding(rows, team, dtype)
        self.n_clusters_ = len(order)
        self.gamma_ = 0.5 / model.width / model.width  # the square could be 0
        self.eigenvalues_ = model.cut.eigenvalues
        if settings.k != "auto" and self.n_clusters_ < settings.k:
            warnings.warn(
                f"found {self.n_clusters_} of {settings.k} clusters: the vectors hardly differ, or "
                "gamma is too small",
                GeohueWarning,
                stacklevel=3,
            )
        return self

    def _settings(self, n_rows: int) -> Settings:
        """Check the parameters, which scikit-learn wants done here."""
        k = self.n_clusters
        if k != "auto" and _whole("n_clusters", k) > n_rows:
            raise GeohueError(f"n_samples={n_rows} should be at least n_clusters={k}")
        gamma = self.gamma
        if gamma != "auto" and not (isinstance(gamma, Real) and 0 < gamma < np.inf):
            raise GeohueError(f'gamma is {gamma!r}: expected a positive number or "auto"')
        if self.landmarks not in LANDMARK_CHOICES:
            raise GeohueError(
                f"landmarks {self.landmarks!r}: choose one of {', '.join(LANDMARK_CHOICES)}"
            )
        if self.assign_labels not in _LABELLINGS:
            raise GeohueError(
                f"assign_labels {self.assign_labels!r}: choose one of {', '.join(_LABELLINGS)}"
            )
        return Settings(
            k=k,
            k_max=_whole("max_clusters", self.max_clusters),
            width=None if gamma == "auto" else float(np.sqrt(0.5 / gamma)),
            landmarks=_whole("n_landmarks", self.n_landmarks),
            choice=self.landmarks,
            labelling=_LABELLINGS[self.assign_labels],
            restarts=_whole("n_init", self.n_init) - 1,
        )


def _whole(name: str, value: object) -> int:
    if not isinstance(value, Integral) or isinstance(value, bool) or value < 1:
        also = ' or "auto"' if name == "n_clusters" else ""
        raise GeohueError(f"{name} is {value!r}: expected a whole number from 1 on{also}")
    return int(value)


def _weights(sample_weight: ArrayLike | None, n_rows: int) -> NDArray[np.float64] | None:
    if sample_weight is None:
        return None
    weights = np.array(sample_weight, np.float64)
    if weights.shape != (n_rows,):
        raise GeohueError(f"sample_weight has shape {weights.shape}: expected ({n_rows},)")
    if not (np.isfinite(weights) & (weights >= 0)).all():
        raise GeohueError("sample_weight: expected finite numbers, none of them negative")
    if not weights.any():
        raise GeohueError("sample_weight is zero everywhere: at least one row must count")
    return weights


def _by_size(
    labels: NDArray[np.int32], weights: NDArray[np.float64] | None, k: int
) -> tuple[NDArray[np.intp], NDArray[np.int32]]:
    """Return the labels in use, that of most weight first, and the new number of each label."""
    mass = np.bincount(labels, weights, k)
    used = np.bincount(labels, minlength=k) > 0
    order = np.argsort(-mass, kind="stable")
    order = order[used[order]]
    number = np.full(k, -1, np.int32)
    number[order] = np.arange(len(order))
    return order, number
