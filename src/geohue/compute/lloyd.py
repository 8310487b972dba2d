"""k-means as a small, repeatable step: used on eigenvectors and for landmarks.

scikit-learn's k-means sums over threads in any order and takes a second to import; SciPy's warns
through a filter that threads share. Neither can give the same labels at any number of threads.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.compute.arrays import Floats


def nearest_center(rows: Floats, centers: Floats) -> NDArray[np.int32]:
    """Label each row with its nearest centre (the first of equals).

    Parameters
    ----------
    rows : (M, D) float
    centers : (K, D) float

    Returns
    -------
    (M,) int32

    Examples
    --------
    >>> nearest_center(np.eye(2)[[0, 1, 1]], np.eye(2)).tolist()
    [0, 1, 1]
    """
    half_norms = 0.5 * (centers**2).sum(axis=1)
    scores = rows @ centers.T.astype(rows.dtype) - half_norms.astype(rows.dtype)
    return np.asarray(scores.argmax(axis=1), np.int32)


def lloyd(
    rows: NDArray[np.float64],
    centers: NDArray[np.float64],
    steps: int = 30,
    weights: NDArray[np.float64] | None = None,
) -> tuple[NDArray[np.float64], float]:
    """Move the centres to the means of their rows until no label changes.

    Parameters
    ----------
    rows : (M, D) float64
    centers : (K, D) float64
        Where to start; a centre that loses all its rows stays where it is.
    steps : int
        Most steps.
    weights : (M,) float64, optional
        As how many rows each counts; by default 1.

    Returns
    -------
    centers : (K, D) float64
    cost : float
        Weighted sum of the squared distances to the nearest centre.
    """
    from geohue.compute.centers import move_centers

    k, d = centers.shape
    moved = np.array(centers, np.float64)
    labels = np.full(len(rows), -1, np.int32)
    scratch = np.empty((k, d + 1))
    w = np.ones(len(rows)) if weights is None else weights
    cost = move_centers(np.ascontiguousarray(rows), w, moved, steps, labels, scratch)
    return moved, float(cost)


def spread_seeds(
    rows: NDArray[np.float64],
    k: int,
    rng: np.random.Generator,
    weights: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """Draw k rows far from each other: k-means++ (Arthur and Vassilvitskii 2007).

    A weight raises the chance of a row, but not of the first one, which is any.
    Takes the same number of draws from `rng` whatever the data are.
    """
    from geohue.compute.centers import draw_seeds

    chosen = np.full(k, rng.integers(len(rows)))
    w = np.ones(len(rows)) if weights is None else weights
    draw_seeds(np.ascontiguousarray(rows), w, rng.random(k - 1), np.empty(len(rows)), chosen)
    return rows[chosen]
