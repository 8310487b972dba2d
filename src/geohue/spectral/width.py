"""The width of the affinity, where none is given."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

SHARE = 0.02
"""Share of all points that a typical one has within the width."""

CLUSTER_SHARE = 0.25
"""The same as a share of an average cluster, where their number is known: the lesser counts."""

NEIGHBOURS = 3
"""Least number of distinct points within the width."""

NARROWEST = 1e-6
"""Least width as a share of the extent: double precision tells no finer steps."""

_LOOKED_FROM, _LOOKED_AT = 500, 4000


def neighbour_width(
    vectors: NDArray[np.float64], weights: NDArray[np.float64], k: int | None
) -> float:
    """Return the distance within which a typical point has a fixed share of the others.

    The median, over the points, of the distance up to which there are `SHARE` of all points, or
    `CLUSTER_SHARE` of an average cluster if that is less. It moves and grows with the data, and
    asks nothing of their dimension.

    Parameters
    ----------
    vectors : (M, D) float64
        Distinct points, in a meaningful order: every n-th is looked at.
    weights : (M,) float64
        As how many points each counts, positive.
    k : int or None
        Number of clusters, if known.

    Returns
    -------
    float
        Positive; 1 for a single point.

    References
    ----------
    U. von Luxburg, "A tutorial on spectral clustering", Statistics and Computing 17, 2007,
    sec. 8.2, on rules of this kind.

    Examples
    --------
    >>> line = np.arange(1000.0)[:, None]
    >>> round(neighbour_width(line, np.ones(1000), k=2), 9)
    10.0
    """
    from scipy.spatial.distance import cdist

    extent = float(np.abs(vectors - vectors[0]).max())
    if extent == 0:
        return 1.0
    seen, mass = _every(vectors, _LOOKED_AT), _every(weights, _LOOKED_AT)
    share = SHARE if k is None else min(SHARE, CLUSTER_SHARE / k)
    # In units of the extent, so that no square overflows.
    distances = cdist(_every(vectors, _LOOKED_FROM) / extent, seen / extent)
    order = np.argsort(distances, axis=1, kind="stable")
    within = np.cumsum(mass[order], axis=1) < share * mass.sum()
    rank = np.clip(within.sum(axis=1), min(NEIGHBOURS, len(seen) - 1), len(seen) - 1)
    reached = distances[np.arange(len(order)), order[np.arange(len(order)), rank]]
    return max(float(np.median(reached)), NARROWEST) * extent


def _every(values: NDArray[np.float64], most: int) -> NDArray[np.float64]:
    """Every n-th row, so that there are at most so many."""
    return values[:: -(-len(values) // most)]
