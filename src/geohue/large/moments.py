"""Means and deviations of many numbers, from those of their parts."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import reduce

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Moments:
    """Count, mean, spread and range of each column.

    Attributes
    ----------
    count : int
        Rows.
    mean, squares : (D,) float64
        Mean, and sum of the squared distances to it.
    low, high : (D,) float64
        Smallest and largest value; infinite if there are no rows.

    Examples
    --------
    >>> parts = [Moments.of(np.array([[1.0], [2.0]])), Moments.of(np.array([[6.0]]))]
    >>> whole = merge(parts)
    >>> whole.count, whole.mean.tolist(), whole.squares.tolist(), whole.high.tolist()
    (3, [3.0], [14.0], [6.0])
    """

    count: int
    mean: Vector
    squares: Vector
    low: Vector
    high: Vector

    @classmethod
    def of(cls, values: Vector) -> Moments:
        """Measure rows, (M, D); exact to rounding, also far from zero."""
        width = values.shape[1]
        if len(values) == 0:
            return cls(0, np.zeros(width), np.zeros(width), _full(width), -_full(width))
        mean = values.mean(axis=0)
        squares = ((values - mean) ** 2).sum(axis=0)
        return cls(len(values), mean, squares, values.min(axis=0), values.max(axis=0))

    @property
    def deviation(self) -> Vector:
        """Standard deviation of each column."""
        return np.sqrt(self.squares / max(self.count, 1))

    def numbers(self) -> list[float]:
        """Return all of it as a flat list, for `from_numbers`."""
        arrays = (self.mean, self.squares, self.low, self.high)
        return [self.count, *np.concatenate(arrays).tolist()]

    @classmethod
    def from_numbers(cls, numbers: Iterable[float]) -> Moments:
        """Return what `numbers` was made of."""
        count, *rest = numbers
        mean, squares, low, high = np.array(rest, np.float64).reshape(4, -1)
        return cls(int(count), mean, squares, low, high)


def merge(parts: Iterable[Moments]) -> Moments:
    """Join the moments of parts, one after the other (Chan, Golub and LeVeque 1983).

    The result depends on the parts and their order in the last digits: who wants the same digits
    again hands in the same parts.
    """
    return reduce(_merge_two, parts)


def _merge_two(a: Moments, b: Moments) -> Moments:
    if b.count == 0:
        return a
    if a.count == 0:
        return b
    count, step = a.count + b.count, b.mean - a.mean
    share = b.count / count
    return Moments(
        count,
        a.mean + step * share,
        a.squares + b.squares + step**2 * (a.count * share),
        np.minimum(a.low, b.low),
        np.maximum(a.high, b.high),
    )


def _full(width: int) -> Vector:
    return np.full(width, np.inf)
