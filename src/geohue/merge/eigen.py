"""Eigenvalues of symmetric 3x3 matrices in closed form, for the planes of regions."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from geohue.compute.compiled import compiled_part

PARALLEL = 1e-7
"""Cross products of rows, over the squared size of a matrix, that are rounding: a double eigenvalue
is known to half of the digits only."""


@compiled_part
def covariance(
    table: NDArray[np.float64], row: int, mean: int, spread: int, n: float, out: NDArray[np.float64]
) -> None:
    """Write the covariance of the sums that a row of a table holds, as xx, xy, xz, yy, yz, zz."""
    x, y, z = table[row, mean] / n, table[row, mean + 1] / n, table[row, mean + 2] / n
    out[0] = table[row, spread] / n - x * x
    out[1] = table[row, spread + 1] / n - x * y
    out[2] = table[row, spread + 2] / n - x * z
    out[3] = table[row, spread + 3] / n - y * y
    out[4] = table[row, spread + 4] / n - y * z
    out[5] = table[row, spread + 5] / n - z * z


@compiled_part
def eigenvalue(m: NDArray[np.float64], which: int) -> float:
    """Return an eigenvalue of xx, xy, xz, yy, yz, zz: 0 the smallest, 2 the largest.

    The roots of the characteristic polynomial by cosines (Smith, 1961).
    """
    mean = (m[0] + m[3] + m[5]) / 3
    off = m[1] * m[1] + m[2] * m[2] + m[4] * m[4]
    a, d, f = m[0] - mean, m[3] - mean, m[5] - mean
    size = math.sqrt((a * a + d * d + f * f + 2 * off) / 6)
    if size <= 1e-150:
        return float(mean)
    a, d, f = a / size, d / size, f / size  # first of all: the cube of a small size would be 0
    b, c, e = m[1] / size, m[2] / size, m[4] / size
    half = (a * (d * f - e * e) - b * (b * f - e * c) + c * (b * e - d * c)) / 2
    angle = math.acos(min(1.0, max(-1.0, half))) / 3
    if which == 2:
        return float(mean + 2 * size * math.cos(angle))
    least = mean + 2 * size * math.cos(angle + 2 * math.pi / 3)
    if which == 0:
        return float(least)
    return float(3 * mean - least - (mean + 2 * size * math.cos(angle)))


@compiled_part
def eigenvector(
    m: NDArray[np.float64], value: float, out: NDArray[np.float64], row: int, at: int
) -> None:
    """Write a unit vector that a matrix stretches by `value`: across two rows of m - value I.

    Of the three pairs of rows that with the largest cross product; zeros if all rows are parallel
    but for rounding, where the eigenvalue is double and no direction is special.
    """
    most = m[0] * m[0] + m[3] * m[3] + m[5] * m[5]
    most += 2 * (m[1] * m[1] + m[2] * m[2] + m[4] * m[4])
    a, d, f = m[0] - value, m[3] - value, m[5] - value
    b, c, e = m[1], m[2], m[4]
    x0, y0, z0 = b * e - c * d, c * b - a * e, a * d - b * b
    x1, y1, z1 = b * f - c * e, c * c - a * f, a * e - b * c
    x2, y2, z2 = d * f - e * e, e * c - b * f, b * e - d * c
    n0, n1, n2 = (
        x0 * x0 + y0 * y0 + z0 * z0,
        x1 * x1 + y1 * y1 + z1 * z1,
        x2 * x2 + y2 * y2 + z2 * z2,
    )
    if n1 > n0:
        x0, y0, z0, n0 = x1, y1, z1, n1
    if n2 > n0:
        x0, y0, z0, n0 = x2, y2, z2, n2
    scale = 1 / math.sqrt(n0) if n0 > (PARALLEL * most) ** 2 else 0.0
    out[row, at], out[row, at + 1], out[row, at + 2] = x0 * scale, y0 * scale, z0 * scale
