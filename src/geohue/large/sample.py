"""The random sample on which everything is decided."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

SAMPLE = 100_000
"""Points in the sample, or all where there are fewer."""

SAMPLE_ROW = np.dtype([("xyz", "<f8", 3), ("rgb", "u1", 3)])


def sample_positions(n_points: int, size: int, seed: int) -> NDArray[np.int64]:
    """Draw which points of a cloud are in the sample, before the cloud is read.

    Parameters
    ----------
    n_points : int
        Points in the cloud.
    size : int
        How many to draw; all if there are not more.
    seed : int
        The source of chance.

    Returns
    -------
    (m,) int64
        Positions in increasing order, each once; every set is equally likely.

    Examples
    --------
    >>> sample_positions(3, 5, 0).tolist()
    [0, 1, 2]
    >>> len(sample_positions(10**12, 1000, 0))
    1000
    """
    if n_points <= size:
        return np.arange(n_points)
    # NumPy draws few of very many without a list of all; shuffling is not needed, as it is sorted.
    rng = np.random.default_rng((seed, 3))
    return np.sort(rng.choice(n_points, size, replace=False, shuffle=False))
