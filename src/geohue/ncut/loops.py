"""The inner loops of the cut: affinities and what is made of them, a row at a time.

No affinity is stored that is not asked for. A row of them takes about ten instructions a landmark
for eight or sixteen landmarks at a time: computing it anew costs less than reading it back from
memory. `geohue.ncut.kernel` calls these, tests/twins/kernel.py says the same in NumPy.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numba import types
from numba.extending import overload
from numpy.typing import NDArray

from geohue.compute.arrays import Floats
from geohue.compute.compiled import vectorized, vectorized_part

Scalar = np.floating[Any]

SMALLEST = -80 / math.log(2)
"""Base-2 log-affinity below which all are alike: further down the numbers would be denormal."""

LARGE = 1e30
"""Above every sum; infinity has no place in reordered arithmetic."""

SQUARE = 1e-37
"""Least square of a length that is divided by."""


def exp2(y: Any) -> Any:
    """Two to a power from `SMALLEST` to 0."""
    return 2.0**y


@overload(exp2, inline="always")
def _exp2_by_type(y: Any) -> Callable[[Any], Any]:
    return _exp2_float32 if y == types.float32 else _exp2_float64


def _exp2_float32(y: Any) -> Any:
    """Split into a whole power, set in the exponent's bits, and a polynomial on -1/2..1/2.

    The relative error is below 3e-7: 9e-8 of the polynomial, which is 1 at 0 and elsewhere the one
    with the least largest error, the rest rounding. A call of the library's exp would keep the
    loop from becoming vector code.
    """
    whole = np.floor(y + np.float32(0.5))
    f = y - whole
    p = np.float32(1.3264727e-3)
    p = p * f + np.float32(9.6715128e-3)
    p = p * f + np.float32(5.5507337e-2)
    p = p * f + np.float32(2.4022242e-1)
    p = p * f + np.float32(6.9314698e-1)
    p = p * f + np.float32(1.0)
    bits = (np.int32(whole) + np.int32(127)) << np.int32(23)
    return p * np.int32(bits).view(np.float32)


def _exp2_float64(y: Any) -> Any:
    return math.pow(2.0, y)


@vectorized_part
def fill_row(
    x: Floats, i: int, lift: Scalar, gain: Scalar, z: Floats, half: Floats, out: Floats, r: int
) -> Scalar:
    """Write the affinities of point `i` to all landmarks into row `r` and return their sum.

    Their powers of two are raised by `lift`. `z` has a row a dimension, their number a multiple
    of three: three products at a time stay in registers. `half` is ``-|z|^2 / 2``.
    """
    d, n = z.shape
    number = x.dtype.type
    offset = number(0)
    for c in range(d):
        offset += (x[i, c] * gain) ** 2
    offset = lift - number(0.5) * offset
    for j in range(n):
        out[r, j] = half[j] + offset
    for c in range(0, d - 3, 3):
        u, v, w = x[i, c] * gain, x[i, c + 1] * gain, x[i, c + 2] * gain
        for j in range(n):
            out[r, j] += u * z[c, j] + v * z[c + 1, j] + w * z[c + 2, j]
    u, v, w = x[i, d - 3] * gain, x[i, d - 2] * gain, x[i, d - 1] * gain
    total = number(0)
    for j in range(n):
        power = out[r, j] + u * z[d - 3, j] + v * z[d - 2, j] + w * z[d - 1, j]
        # Rounding may pass 0 by a hair.
        out[r, j] = exp2(max(number(SMALLEST), min(number(0), power)))
        total += out[r, j]
    return total


@vectorized
def lifts(
    x: Floats, faintest: float, gain: Scalar, z: Floats, half: Floats, row: Floats, out: Floats
) -> None:
    """Write by what each point's powers of two must rise for the largest to be `faintest`."""
    number = x.dtype.type
    d, n = z.shape
    for i in range(len(x)):
        for j in range(n):
            row[0, j] = half[j]
        for c in range(d):
            v = x[i, c] * gain
            for j in range(n):
                row[0, j] += v * (z[c, j] - number(0.5) * v)
        largest = -number(LARGE)
        for j in range(n):
            largest = max(largest, row[0, j])
        out[i] = max(number(0), number(faintest) - largest)


@vectorized
def affinities(
    x: Floats, lift: Floats, gain: Scalar, z: Floats, half: Floats, totals: Floats, out: Floats
) -> None:
    """Write the affinities of all points, a row each, and the sums of the rows."""
    for i in range(len(x)):
        totals[i] = fill_row(x, i, lift[i], gain, z, half, out, i)


@vectorized
def add_columns(
    x: Floats, weights: Floats, gain: Scalar, z: Floats, half: Floats, row: Floats, out: Floats
) -> None:
    """Add each landmark's affinities to all points to `out`; `row` is room for one."""
    flat = x.dtype.type(0)
    for i in range(len(x)):
        fill_row(x, i, flat, gain, z, half, row, 0)
        for j in range(len(out)):
            out[j] += weights[i] * row[0, j]


@vectorized
def normalized(
    x: Floats,
    weights: Floats,
    gain: Scalar,
    z: Floats,
    half: Floats,
    to_degree: Floats,
    out: Floats,
) -> None:
    """Write the affinities times the square root of the point's weight over its degree."""
    flat = x.dtype.type(0)
    for i in range(len(x)):
        fill_row(x, i, flat, gain, z, half, out, i)
        degree = flat
        for j in range(out.shape[1]):
            degree += out[i, j] * to_degree[j]
        scale = np.sqrt(weights[i]) / np.sqrt(max(degree, weights[i]))
        for j in range(out.shape[1]):
            out[i, j] *= scale


@vectorized
def project(
    x: Floats,
    lift: Floats,
    gain: Scalar,
    z: Floats,
    half: Floats,
    basis: Floats,
    row: Floats,
    totals: Floats,
    out: Floats,
) -> None:
    """Write the affinities of each point times each row of `basis`."""
    for i in range(len(x)):
        totals[i] = fill_row(x, i, lift[i], gain, z, half, row, 0)
        _times_basis(row, basis, out, i)


@vectorized
def nearest(
    x: Floats,
    lift: Floats,
    gain: Scalar,
    z: Floats,
    half: Floats,
    basis: Floats,
    centers: Floats,
    offsets: Floats,
    row: Floats,
    entry: Floats,
    totals: Floats,
    out: NDArray[np.int32],
) -> None:
    """Write the centre nearest to each projection at length 1; `offsets` are ``|center|^2 / 2``."""
    number = x.dtype.type
    for i in range(len(x)):
        totals[i] = fill_row(x, i, lift[i], gain, z, half, row, 0)
        _times_basis(row, basis, entry, 0)
        square = number(0)
        for c in range(len(basis)):
            square += entry[0, c] ** 2
        scale = number(1) / np.sqrt(max(square, number(SQUARE)))
        best, label = -number(LARGE), 0
        for q in range(len(centers)):
            score = number(0)
            for c in range(len(basis)):
                score += entry[0, c] * centers[q, c]
            score = scale * score - offsets[q]
            if score > best:
                best, label = score, q
        out[i] = label


@vectorized_part
def _times_basis(row: Floats, basis: Floats, out: Floats, i: int) -> None:
    """Write one row of affinities times each row of `basis`, four of these at a time."""
    number = row.dtype.type
    for c in range(0, len(basis), 4):
        s, t, u, v = number(0), number(0), number(0), number(0)
        for j in range(row.shape[1]):
            w = row[0, j]
            s += w * basis[c, j]
            t += w * basis[c + 1, j]
            u += w * basis[c + 2, j]
            v += w * basis[c + 3, j]
        out[i, c], out[i, c + 1], out[i, c + 2], out[i, c + 3] = s, t, u, v
