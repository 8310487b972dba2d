"""k-means on the vectors p^f (Fig. 3a; row 1 of Fig. 9).

Own code on `geohue.compute.lloyd` rather than scikit-learn: scikit-learn adds up the clusters' sums
over threads in any order, so its labels may change with the number of threads; and a start on a
part of the points costs a tenth. Tests compare the two.

References
----------
S. Lloyd, "Least squares quantization in PCM", IEEE Trans. Inf. Theory 28(2), 1982.
D. Arthur, S. Vassilvitskii, "k-means++: the advantages of careful seeding", SODA 2007.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.baselines.registry import Job
from geohue.baselines.sampling import mixed_vectors, thinned
from geohue.compute.lloyd import lloyd, nearest_center, spread_seeds

STARTS = 10
"""Starts of which the one with the least cost is taken: the usual number."""

SAMPLE = 20_000
"""Points on which the starts are tried; the best one goes on with all points."""

STEPS = 300
"""Most steps on all points."""


def run(job: Job) -> NDArray[np.int32]:
    """Segment a scene into `job.k` clusters (fewer where points coincide)."""
    vectors = mixed_vectors(job.features, job.weight).astype(np.float64)
    few = mixed_vectors(thinned(job.scene, job.features, SAMPLE, job.seed), job.weight)
    centers = best_centers(few.astype(np.float64), job.k, job.seed)
    centers, _ = lloyd(vectors, centers, STEPS)
    return job.features.to_scene(nearest_center(vectors, centers))


def best_centers(
    rows: NDArray[np.float64], k: int, seed: int, starts: int = STARTS
) -> NDArray[np.float64]:
    """Find the k centres of least cost over some k-means++ starts.

    Parameters
    ----------
    rows : (M, D) float64
    k : int
    seed : int
    starts : int
        Equal costs go to the earlier start.

    Returns
    -------
    (k, D) float64

    Examples
    --------
    >>> best_centers(np.array([[0.0], [1], [10], [11]]), 2, seed=0)[:, 0].round(3).tolist()
    [0.5, 10.5]
    """
    rng = np.random.default_rng(seed)
    tries = [lloyd(rows, spread_seeds(rows, k, rng), STEPS) for _ in range(starts)]
    best, _ = min(tries, key=lambda attempt: attempt[1])
    return best[np.lexsort(best.T[::-1])]
