"""The points that stand for all others in the Nystrom approximation."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.compute.arrays import Floats
from geohue.compute.lloyd import lloyd
from geohue.errors import GeohueError
from geohue.settings.cut import LANDMARK_CHOICES, LandmarkChoice

SAMPLE = 8192
"""Points that the choices other than random look at."""


def choose_landmarks(
    vectors: Floats, n: int, choice: LandmarkChoice, rng: np.random.Generator
) -> NDArray[np.int64]:
    """Choose `n` points that represent all.

    Parameters
    ----------
    vectors : (N, D) float32
        The points.
    n : int
        How many; all points if there are fewer.
    choice : {"random", "kmeans", "farthest"}
        ``random`` is uniform, as in the paper. ``kmeans`` takes the point nearest to each k-means
        centre (Zhang, Tsang and Kwok 2008), which covers the data evenly and lowers the error of
        the approximation. ``farthest`` adds the point farthest from those chosen so far
        (Gonzalez 1985), which finds every small part and every outlier.
    rng : numpy.random.Generator
        The source of chance.

    Returns
    -------
    (n,) int64
        Rows of `vectors`, in increasing order, each once.

    Raises
    ------
    GeohueError
        For an unknown choice or `n` below 1.

    Examples
    --------
    >>> x = np.repeat([[0.0], [1.0], [5.0]], 4, axis=0).astype(np.float32)
    >>> rows = choose_landmarks(x, 3, "farthest", np.random.default_rng(0))
    >>> sorted(x[rows, 0].tolist())
    [0.0, 1.0, 5.0]
    """
    if n < 1:
        raise GeohueError(f"{n} landmarks: expected at least 1")
    if n >= len(vectors):
        return np.arange(len(vectors))
    if choice == "random":
        return np.sort(rng.choice(len(vectors), n, replace=False))
    sample = np.sort(rng.choice(len(vectors), min(len(vectors), SAMPLE), replace=False))
    if choice == "kmeans":
        rows = _nearest_to_centers(vectors[sample], n, rng)
    elif choice == "farthest":
        rows = _farthest_first(vectors[sample], n, rng)
    else:
        raise GeohueError(f"landmarks {choice!r}: choose one of {', '.join(LANDMARK_CHOICES)}")
    return sample[np.unique(rows)]


def _nearest_to_centers(vectors: Floats, n: int, rng: np.random.Generator) -> NDArray[np.int64]:
    from scipy.spatial import cKDTree

    start = vectors[np.sort(rng.choice(len(vectors), n, replace=False))].astype(np.float64)
    centers, _ = lloyd(vectors.astype(np.float64), start, steps=10)
    _, nearest = cKDTree(vectors).query(centers)
    return np.asarray(nearest, np.int64)


def _farthest_first(vectors: Floats, n: int, rng: np.random.Generator) -> NDArray[np.int64]:
    rows = np.empty(n, np.int64)
    rows[0] = rng.integers(len(vectors))
    distance = np.full(len(vectors), np.inf, np.float32)
    for i in range(1, n):
        step = vectors - vectors[rows[i - 1]]
        np.minimum(distance, np.einsum("ij,ij->i", step, step), out=distance)
        rows[i] = distance.argmax()
    return rows
