"""How many segments: the paper's "automatic selector of the number of clusters"."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy  # its parts are loaded when they are used
from numpy.typing import NDArray

from geohue.compute.arrays import Floats
from geohue.errors import GeohueError
from geohue.ncut.nystrom import NystromCut
from geohue.settings.cut import K_MAX, SELECTORS, Selector

DIFFUSION_STEPS = 16
"""Steps of the random walk of `eigengap`."""

ONE_SEGMENT = 0.035
"""A scene whose best normalized cut in two costs more than this is one segment."""


def eigengap(
    eigenvalues: NDArray[np.float64], k_max: int = K_MAX, steps: int = DIFFUSION_STEPS
) -> int:
    """Choose the K after which the eigenvalues fall the most.

    K groups without affinity to each other give K eigenvalues of 1; the fall after them tells
    how clear the groups are (von Luxburg 2007). The eigenvalues are those of a random walk after
    some steps (Azran and Ghahramani 2006): what is left of each group by then. A few steps make
    the coarse parts of a scene count more than the many finer ones inside them.

    Parameters
    ----------
    eigenvalues : (m,) float64
        Of the normalized affinity, in decreasing order; those beyond m count as 0.
    k_max : int
        Largest answer.
    steps : int
        Power to which the eigenvalues are taken; 1 is the plain eigengap.

    Returns
    -------
    int
        1 to `k_max`.

    Examples
    --------
    >>> eigengap(np.array([1.0, 0.98, 0.97, 0.7, 0.2]), steps=1), eigengap(np.array([1.0, 0.9]))
    (4, 1)
    """
    padded = np.append(np.clip(eigenvalues, 0, 1), 0.0)[: k_max + 1] ** steps
    return int(np.argmax(padded[:-1] - padded[1:])) + 1


def elongated_kmeans(
    entries: NDArray[np.float64], sharpness: float = 0.2, tolerance: float = 0.01
) -> int:
    """Choose K by elongated k-means (Sanguinetti, Laidler and Lawrence 2005).

    In the first q eigenvectors, not row-normalised, each of K > q groups that are not yet
    told apart by an axis of its own gathers at the origin. So k-means runs with q centres whose
    distance is stretched along the ray from the origin,
    ``M = (I - cc'/c'c) / s + s cc'/c'c``, and one centre at the origin with the plain distance;
    while that one captures points, q grows by one. Of many equal groups the rays may crowd in
    the first dimensions so that none is left for the origin: the answer is then too small.

    Parameters
    ----------
    entries : (M, m) float64
        Eigenvector entries of a sample of points, in order of the eigenvalues; m is the largest
        answer.
    sharpness : float
        The s above.
    tolerance : float
        Share of the points that the origin may capture: noisy pixels lie there always.

    Returns
    -------
    int
        2 to m (1 if m is 1).

    References
    ----------
    G. Sanguinetti, J. Laidler, N. Lawrence, "Automatic determination of the number of clusters
    using spectral algorithms", IEEE MLSP 2005.

    Examples
    --------
    >>> elongated_kmeans(np.repeat(np.eye(3), 20, axis=0))
    3
    """
    k_max = int(entries.shape[1])
    for q in range(2, k_max):
        if _share_at_origin(entries[:, :q], sharpness) <= tolerance:
            return q
    return k_max


def _share_at_origin(y: NDArray[np.float64], sharpness: float) -> float:
    """Run elongated k-means in q dimensions; returns the share that the origin captures."""
    q = y.shape[1]
    # Pivoted QR takes the row that sticks out the most from those taken before.
    _, _, pivots = scipy.linalg.qr(y.T, mode="economic", pivoting=True)
    centers = y[pivots[:q]]
    owner = np.full(len(y), -1)
    for _ in range(50):
        new = _elongated_distances(y, centers, sharpness).argmin(axis=1)
        if np.array_equal(new, owner):
            break
        owner = new
        centers = np.array(
            [y[owner == j].mean(axis=0) if (owner == j).any() else centers[j] for j in range(q)]
        )
    return float((owner == q).mean())


def _elongated_distances(
    y: NDArray[np.float64], centers: NDArray[np.float64], sharpness: float
) -> NDArray[np.float64]:
    """Distance to each centre by its own M, and in the last column to the origin."""
    distance = np.empty((len(y), len(centers) + 1))
    for j, c in enumerate(centers):
        difference = y - c
        along = (difference @ c) ** 2 / max(float(c @ c), 1e-300)
        across = np.einsum("ij,ij->i", difference, difference) - along
        distance[:, j] = across / sharpness + sharpness * along
    distance[:, -1] = np.einsum("ij,ij->i", y, y)
    return distance


def rotation_cost(rows: NDArray[np.float64], steps: int = 60) -> float:
    r"""Cost of aligning the rows with the axes (Zelnik-Manor and Perona 2004).

    .. math:: J = \frac{1}{M} \sum_i \sum_j \frac{Z_{ij}^2}{\max_j Z_{ij}^2},\quad Z = Y R

    minimised over rotations R by gradient descent; 1 when every row lies on an axis.

    Parameters
    ----------
    rows : (M, k) float64
        The first k eigenvectors at a sample of points.
    steps : int
        Most steps of the descent.

    Returns
    -------
    float
        1 to k.

    Examples
    --------
    >>> turn = np.array([[0.8, -0.6], [0.6, 0.8]])
    >>> round(rotation_cost(np.repeat(np.eye(2), 9, axis=0) @ turn), 3)
    1.0
    """
    k = rows.shape[1]
    if k == 1:
        return 1.0
    _, _, pivots = scipy.linalg.qr(rows.T, mode="economic", pivoting=True)
    left, _, right = scipy.linalg.svd(rows[pivots[:k]].T)
    rotation = left @ right
    cost, slope = _alignment(rows, rotation)
    rate = 1.0
    for _ in range(steps):
        step = rotation @ scipy.linalg.expm(-rate * slope)
        new_cost, new_slope = _alignment(rows, step)
        if new_cost < cost:
            small = cost - new_cost < 1e-5
            rotation, cost, slope, rate = step, new_cost, new_slope, rate * 1.5
            if small:
                break
        else:
            rate /= 3
            if rate < 1e-4:
                break
    return cost


def _alignment(
    rows: NDArray[np.float64], rotation: NDArray[np.float64]
) -> tuple[float, NDArray[np.float64]]:
    """Cost, and its gradient on the rotations as a skew-symmetric matrix."""
    z = rows @ rotation
    top = np.abs(z).argmax(axis=1)
    index = np.arange(len(z))
    peak = np.maximum(z[index, top] ** 2, 1e-300)
    sums = np.einsum("ij,ij->i", z, z)
    gradient = 2 * z / peak[:, None]
    gradient[index, top] -= 2 * z[index, top] * sums / peak**2
    euclidean = z.T @ gradient / len(z)
    return float((sums / peak).mean()), (euclidean - euclidean.T) / 2


def self_tuning(
    rows_of: Callable[[int], NDArray[np.float64]], k_max: int, slack: float = 0.01
) -> int:
    """Choose the largest K whose eigenvectors align with the axes (nearly) best.

    Parameters
    ----------
    rows_of : callable
        The eigenvector rows for a given K (`rotation_cost`).
    k_max : int
        Largest answer.
    slack : float
        How far above the least cost still counts as best.

    Returns
    -------
    int
        2 to `k_max` (1 if `k_max` is 1).

    References
    ----------
    L. Zelnik-Manor, P. Perona, "Self-tuning spectral clustering", NIPS 2004.
    """
    if k_max < 2:
        return 1
    costs = np.array([rotation_cost(rows_of(k)) for k in range(2, k_max + 1)])
    return int(np.flatnonzero(costs <= costs.min() + slack)[-1]) + 2


def choose_k(cut: NystromCut, sample: Floats, selector: Selector, k_max: int = K_MAX) -> int:
    """Choose the number of segments.

    First of all, is there anything to split? ``1 - eigenvalues[1]`` bounds from below the
    normalized cut of any split in two. Where it exceeds `ONE_SEGMENT`, as for a single cloud of
    points or a bare wall, the answer is 1; else the selector's.

    Parameters
    ----------
    cut : NystromCut
        With at least ``k_max + 1`` eigenvectors, or all there are.
    sample : (M, D) float
        Points to look at.
    selector : {"eigengap", "elongated", "rotation"}
        See `eigengap`, `elongated_kmeans`, `self_tuning`.
    k_max : int
        Largest answer.

    Returns
    -------
    int
        1 to `k_max`.

    Raises
    ------
    GeohueError
        For an unknown selector.
    """
    if selector not in SELECTORS:
        raise GeohueError(f"k selector {selector!r}: choose one of {', '.join(SELECTORS)}")
    most = min(k_max, len(cut.eigenvalues))
    if most < 2 or 1 - cut.eigenvalues[1] > ONE_SEGMENT:
        return 1
    if selector == "eigengap":
        return max(2, eigengap(cut.eigenvalues, most))
    if selector == "elongated":
        return elongated_kmeans(cut.entries(sample, most).astype(np.float64))
    return self_tuning(lambda k: cut.rows(sample, k).astype(np.float64), most)
