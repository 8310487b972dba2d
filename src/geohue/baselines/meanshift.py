"""Mean shift on the vectors p^f, without image coordinates (Fig. 3b; row 2 of Fig. 9).

A flat ball climbs over a part of the points from the centres of a grid of bins; balls that end
within a bandwidth of a denser one are dropped, and every point then takes the mode it is nearest
to. The bandwidth is scikit-learn's estimate: the mean distance of a point to its `QUANTILE`
nearest share of the others. It adapts to the data, so the number of segments is found rather than
given.

All as in scikit-learn, which the tests compare with. That runs one ball at a time through a tree
and changes the warning filters of the whole process, so threads could not share the weights; the
loop here is some five times faster.

Unclear: the paper names no bandwidth, nor whether a point belongs to the mode it converges to or
to the nearest one (scikit-learn's choice, and the same for all but a few points in between).

References
----------
D. Comaniciu, P. Meer, "Mean shift: a robust approach toward feature space analysis", IEEE Trans.
PAMI 24(5), 2002.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.baselines.kernels import compiled
from geohue.baselines.registry import Job
from geohue.baselines.sampling import mixed_vectors, thinned
from geohue.compute.lloyd import nearest_center

QUANTILE = 0.15
"""Share of the points within a bandwidth of a point, on average.

Half of scikit-learn's own default of 0.3, with which the fusion of five test scenes out of six
becomes one segment.
"""

SAMPLE = 4_000
"""Points over which the ball is shifted."""


MOST_STEPS = 300
"""Most moves of a ball."""

STILL = 1e-3
"""A ball rests when it moves no more than this share of the bandwidth."""


def run(job: Job) -> NDArray[np.int32]:
    """Segment a scene into the basins of the modes of its density."""
    few = mixed_vectors(thinned(job.scene, job.features, SAMPLE, job.seed), job.weight)
    modes = find_modes(few)
    vectors = mixed_vectors(job.features, job.weight)
    return job.features.to_scene(nearest_center(vectors, modes))


def find_modes(
    rows: NDArray[np.float32], bandwidth: float | None = None, quantile: float = QUANTILE
) -> NDArray[np.float64]:
    """Find the modes of the density of some points.

    Parameters
    ----------
    rows : (M, D) float
    bandwidth : float, optional
        Radius of the ball; None means estimated from the data.
    quantile : float
        Share of the points for the estimate.

    Returns
    -------
    (K, D) float64
        The densest first.

    Examples
    --------
    >>> rows = np.array([[0.0], [0.1], [0.2], [5.0], [5.2]], np.float32)
    >>> find_modes(rows, bandwidth=1.0)[:, 0].round(3).tolist()
    [0.1, 5.1]
    """
    points = np.ascontiguousarray(rows, np.float64)
    if bandwidth is None:
        bandwidth = estimate_bandwidth(points, quantile)
    if bandwidth <= 0:  # most points coincide: nothing to tell apart
        return np.array([points.mean(axis=0)], np.float64)
    bins = np.unique(np.round(points / bandwidth), axis=0)
    modes = bins * bandwidth
    counts = np.zeros(len(modes), np.int64)
    _climb(points, bandwidth, modes, counts)
    return _distinct(modes[counts > 0], counts[counts > 0], bandwidth)


def estimate_bandwidth(points: NDArray[np.float64], quantile: float = QUANTILE) -> float:
    """Return the mean distance of a point to the `quantile` of the points nearest to it."""
    from scipy.spatial.distance import cdist

    last = max(1, int(len(points) * quantile)) - 1
    total = 0.0
    for start in range(0, len(points), 500):
        squared = cdist(points[start : start + 500], points, "sqeuclidean")
        total += float(np.sqrt(np.partition(squared, last, axis=1)[:, last]).sum())
    return total / len(points)


def _distinct(
    modes: NDArray[np.float64], counts: NDArray[np.int64], bandwidth: float
) -> NDArray[np.float64]:
    """Keep the densest mode of those within a bandwidth, densest first."""
    order = np.lexsort((*modes.T[::-1], counts))[::-1]
    kept: list[NDArray[np.float64]] = []
    for mode in modes[order]:
        if all(((mode - other) ** 2).sum() > bandwidth**2 for other in kept):
            kept.append(mode)
    return np.array(kept)


@compiled
def _climb(
    points: NDArray[np.float64],
    bandwidth: float,
    modes: NDArray[np.float64],
    counts: NDArray[np.int64],
) -> None:
    """Move each ball to the mean of the points in it until it rests; count these points."""
    dimensions = points.shape[1]
    total = np.empty(dimensions)
    for ball in range(len(modes)):
        for _ in range(MOST_STEPS + 1):
            total[:] = 0.0
            inside = 0
            for i in range(len(points)):
                distance = 0.0
                for c in range(dimensions):
                    step = points[i, c] - modes[ball, c]
                    distance += step * step
                if distance <= bandwidth * bandwidth:
                    inside += 1
                    for c in range(dimensions):
                        total[c] += points[i, c]
            counts[ball] = inside
            if inside == 0:
                break
            moved = 0.0
            for c in range(dimensions):
                step = total[c] / inside - modes[ball, c]
                modes[ball, c] += step
                moved += step * step
            if moved <= (STILL * bandwidth) ** 2:
                break
