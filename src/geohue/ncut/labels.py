"""From eigenvectors to K labels."""

from __future__ import annotations

import numpy as np
import scipy  # its parts are loaded when they are used
from numpy.typing import NDArray

from geohue.compute.arrays import Floats
from geohue.compute.lloyd import lloyd, spread_seeds
from geohue.errors import GeohueError
from geohue.settings.cut import LABELLINGS, Labelling


def find_centers(
    rows: Floats,
    k: int,
    labelling: Labelling,
    rng: np.random.Generator,
    restarts: int = 4,
    weights: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """Find the direction of each of `k` segments in the space of eigenvectors.

    A point gets the label of the centre for which `nearest_center` says so.

    Parameters
    ----------
    rows : (M, k) float
        Row-normalised eigenvectors of a sample of the points (`NystromCut.rows`).
    k : int
        Number of segments, at least 1.
    labelling : {"kmeans", "rotation", "qr"}
        ``kmeans``: k-means on the rows (Ng, Jordan and Weiss 2002), started from k rows as
        orthogonal to each other as can be and from `restarts` random seeds; the best wins.
        ``rotation``: the rotation that brings the rows nearest to the axes (Yu and Shi 2003).
        ``qr``: the rotation that pivoted QR gives directly (Damle, Minden and Ying 2019).
    rng : numpy.random.Generator
        The source of chance for the restarts of k-means.
    restarts : int
        Number of those.
    weights : (M,) float64, optional
        As how many rows each counts; by default 1. Pivoted QR has no use for them.

    Returns
    -------
    (k, k) float64
        One centre a row.

    Raises
    ------
    GeohueError
        For an unknown labelling.
    """
    y = rows.astype(np.float64)
    w = np.ones(len(y)) if weights is None else weights
    if k == 1:
        return np.ones((1, y.shape[1]))
    if labelling == "qr":
        return _qr_rotation(y).T
    if labelling == "rotation":
        return _yu_shi(y, _qr_rotation(y), w).T
    if labelling == "kmeans":
        return _kmeans(y, k, _most_orthogonal(y, k, w), restarts, rng, w)
    raise GeohueError(f"labelling {labelling!r}: choose one of {', '.join(LABELLINGS)}")


def _most_orthogonal(
    rows: NDArray[np.float64], k: int, weights: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Pick k rows, each as orthogonal as possible to those before it.

    The first is the row most like the average, so that no stray point starts the choice.
    """
    chosen = [int((rows @ np.average(rows, axis=0, weights=weights)).argmax())]
    overlap = np.zeros(len(rows))
    for _ in range(1, k):
        overlap += (rows @ rows[chosen[-1]]) ** 2
        chosen.append(int(overlap.argmin()))
    return rows[chosen]


def _kmeans(
    rows: NDArray[np.float64],
    k: int,
    start: NDArray[np.float64],
    restarts: int,
    rng: np.random.Generator,
    weights: NDArray[np.float64],
) -> NDArray[np.float64]:
    best, best_cost = lloyd(rows, start, weights=weights)
    for _ in range(restarts):
        seeds = spread_seeds(rows, k, rng, weights)
        centers, cost = lloyd(rows, seeds, weights=weights)
        # A restart must win clearly, or the choice would flip with the last digit.
        if cost < best_cost * (1 - 1e-3):
            best, best_cost = centers, cost
    return best


def _qr_rotation(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    _, _, pivots = scipy.linalg.qr(rows.T, mode="economic", pivoting=True)
    left, _, right = scipy.linalg.svd(rows[pivots[: rows.shape[1]]].T)
    return np.asarray(left @ right)


def _yu_shi(
    rows: NDArray[np.float64], rotation: NDArray[np.float64], weights: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Alternate between the nearest labels and the nearest rotation until nothing moves."""
    last = -1.0
    for _ in range(30):
        labels = (rows @ rotation).argmax(axis=1)
        indicator = np.zeros_like(rows)
        indicator[np.arange(len(rows)), labels] = weights
        left, singular, right = scipy.linalg.svd(rows.T @ indicator)
        fit = float(singular.sum())
        if abs(fit - last) < 1e-9 * weights.sum():
            break
        last, rotation = fit, left @ right
    return rotation
