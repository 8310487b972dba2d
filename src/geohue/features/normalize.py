"""Values of a cue brought to a common size (eq. 3, 4)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

SAME_COLOR = "all colours are equal: colour says nothing here"
SAME_PLACE = "all points lie in one place: geometry says nothing here"

FLOOR = 1e-6
"""A spread below this share of the numbers is rounding of these, not structure."""

_BLOCK = 16_384  # rows that stay in the cache between one step and the next


def normalized(values: NDArray[np.float32]) -> tuple[NDArray[np.float32], bool]:
    """Divide by the mean of the standard deviations of the columns (eq. 3, 4), centred.

    Only differences matter later; centring first keeps them exact in float32.

    Parameters
    ----------
    values : (M, C) float32
        L, a, b, or x, y, z in one unit, or whatever else is measured in one.

    Returns
    -------
    values : (M, C) float32
        Zeros if there is no spread.
    constant : bool
        Whether there is none.

    Examples
    --------
    >>> scaled, constant = normalized(np.float32([[1, 0], [3, 0]]))
    >>> scaled.tolist(), constant
    ([[-2.0, 0.0], [2.0, 0.0]], False)
    """
    n, columns = values.shape
    means, deviations = np.zeros(columns), np.zeros(columns)
    # Column by column: numpy's loops are slow over short rows.
    for j in range(columns if n else 0):
        means[j] = _sum(values[:, j]) / n
        deviations[j] = np.sqrt(_sum(values[:, j], means[j]) / n)
    sigma = float(deviations.mean())
    floor = FLOOR * max(float(values.max(initial=0)), -float(values.min(initial=0)))
    if sigma <= floor:
        return np.zeros(values.shape, np.float32), True
    scaled = np.empty(values.shape, np.float32)
    column = np.empty(min(n, _BLOCK))
    for first in range(0, n, _BLOCK):
        rows = slice(first, first + _BLOCK)
        for j in range(columns):
            here = np.subtract(values[rows, j], means[j], out=column[: len(values[rows])])
            np.divide(here, sigma, out=scaled[rows, j], casting="same_kind")
    return scaled, False


def _sum(column: NDArray[np.float32], center: float | None = None) -> float:
    """Sum in double precision, of the squares of what a center leaves if there is one.

    Halves of halves are added, as by `numpy.sum` and so to the same bits, but made in the cache.
    """
    n = len(column)
    if n > _BLOCK:
        half = n // 2 - n // 2 % 8
        return _sum(column[:half], center) + _sum(column[half:], center)
    part = column.astype(np.float64)
    if center is not None:
        part -= center
        part *= part
    return float(part.sum())
