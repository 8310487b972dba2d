"""Values of a cue brought to a common size (eq. 3, 4)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

SAME_COLOR = "all colours are equal: colour says nothing here"
SAME_PLACE = "all points lie in one place: geometry says nothing here"

FLOOR = 1e-6
"""A spread below this share of the numbers is rounding of these, not structure."""


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
    means, deviations = np.empty(columns), np.empty(columns)
    column, square = np.empty(n), np.empty(n)
    # Column by column: numpy's loops are slow over short rows.
    for j in range(columns):
        column[:] = values[:, j]
        means[j] = column.mean()
        column -= means[j]
        deviations[j] = np.sqrt(np.multiply(column, column, out=square).mean())
    sigma = float(deviations.mean())
    floor = FLOOR * max(float(values.max(initial=0)), -float(values.min(initial=0)))
    if sigma <= floor:
        return np.zeros(values.shape, np.float32), True
    scaled = np.empty(values.shape, np.float32)
    for j in range(columns):
        np.subtract(values[:, j], means[j], out=column)
        np.divide(column, sigma, out=scaled[:, j], casting="same_kind")
    return scaled, False
