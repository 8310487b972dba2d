"""Mean shift on the vectors p^f, without image coordinates (Fig. 3b; row 2 of Fig. 9).

scikit-learn shifts a flat ball over a part of the points, from the centres of a grid of bins;
balls that end within a bandwidth of a denser one are dropped, and every point then takes the mode
it is nearest to. The bandwidth is scikit-learn's estimate: the mean distance of a point to its
`QUANTILE` nearest share of the others. It adapts to the data, so the number of segments is found
rather than given.

Unclear: the paper names no bandwidth, nor whether a point belongs to the mode it converges to or
to the nearest one (scikit-learn's choice, and the same for all but a few points in between).

References
----------
D. Comaniciu, P. Meer, "Mean shift: a robust approach toward feature space analysis", IEEE Trans.
PAMI 24(5), 2002.
"""

from __future__ import annotations

from threading import Lock

import numpy as np
from numpy.typing import NDArray

from geohue.baselines.registry import Job
from geohue.baselines.sampling import mixed_vectors, thinned
from geohue.ncut.lloyd import nearest_center

QUANTILE = 0.15
"""Share of the points within a bandwidth of a point, on average.

Half of scikit-learn's own default of 0.3, with which the fusion of five test scenes out of six
becomes one segment.
"""

SAMPLE = 4_000
"""Points over which the ball is shifted."""


# scikit-learn changes the warning filters of the whole process while it works; two threads at once
# would restore each other's.
_ONE_AT_A_TIME = Lock()


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
    from sklearn.cluster import MeanShift, estimate_bandwidth

    points = rows.astype(np.float64)
    with _ONE_AT_A_TIME:
        if bandwidth is None:
            bandwidth = float(estimate_bandwidth(points, quantile=quantile, n_jobs=1))
        if bandwidth <= 0:  # most points coincide: nothing to tell apart
            return np.array([points.mean(axis=0)], np.float64)
        shift = MeanShift(bandwidth=bandwidth, bin_seeding=True, n_jobs=1).fit(points)
    centers: NDArray[np.float64] = np.asarray(shift.cluster_centers_, np.float64)
    return centers
