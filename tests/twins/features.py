"""Eq. 3 and 4 as whole-array operations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def normalized(values: NDArray[np.float32]) -> tuple[NDArray[np.float32], bool]:
    """Centre, and divide by the mean of the standard deviations of the columns."""
    centred = values - values.mean(axis=0, dtype=np.float64)
    sigma = float(centred.std(axis=0).mean())
    if sigma <= 1e-6 * float(np.abs(values).max(initial=0)):
        return np.zeros(values.shape, np.float32), True
    return (centred / sigma).astype(np.float32), False


def mixed(
    color: NDArray[np.float32], geometry: NDArray[np.float32], weight: float
) -> NDArray[np.float32]:
    """The vectors of eq. 5 or 19 over ``sqrt(v + weight^2)`` for v views, in double precision."""
    views = color.shape[1] / 3
    vectors = np.hstack([color.astype(np.float64), weight * geometry.astype(np.float64)])
    return np.asarray(vectors / np.sqrt(views + weight**2), np.float32)
