"""Colour, normals and positions averaged within regions, to compare the two sides of a border."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.compute.compiled import compiled
from geohue.merge.evidence import Evidence, gaps, turns

ROUNDS = 6
"""Times that each point takes the mean of itself and its neighbours in the same region."""


@dataclass(frozen=True, slots=True, eq=False)
class Smooth:
    """Points whose noise is averaged away without mixing the two sides of a border.

    Attributes
    ----------
    lab, normals, points : (n, 3) float64
        Means around each point; the normals of unit length.
    """

    lab: NDArray[np.float64]
    normals: NDArray[np.float64]
    points: NDArray[np.float64]

    def steps(
        self, one: NDArray[np.int64], other: NDArray[np.int64], unit: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return the step of colour, the convexity and the gap of each pair.

        Parameters
        ----------
        one, other : (E,) int64
            Pairs of neighbours.
        unit : (n,) float64
            The length that the gap is measured in.

        Returns
        -------
        color, convexity, gap : (E,) float64
        """
        away = self.points[other] - self.points[one]
        color = np.sqrt(((self.lab[one] - self.lab[other]) ** 2).sum(axis=1))
        gap = gaps(self.normals, away, one, other) / np.minimum(unit[one], unit[other])
        return color, turns(self.normals, away, one, other), gap


def smooth_within(evidence: Evidence, inside: NDArray[np.bool_]) -> Smooth:
    """Average each point with its neighbours in the same region, `ROUNDS` times.

    Parameters
    ----------
    evidence : Evidence
        Points and pairs of neighbours.
    inside : (E,) bool
        Which pairs lie within one region.

    Returns
    -------
    Smooth
    """
    values = np.hstack([evidence.lab, evidence.normals, evidence.points])
    one, other = evidence.one[inside], evidence.other[inside]
    n = len(values)
    share = 1.0 / (1 + np.bincount(one, minlength=n) + np.bincount(other, minlength=n))
    into = np.empty_like(values)
    for _ in range(ROUNDS):
        average(values, one, other, share, into)
        values, into = into, values
    normals = values[:, 3:6]
    length = np.sqrt((normals**2).sum(axis=1, keepdims=True))
    return Smooth(values[:, :3], normals / np.maximum(length, 1e-9), values[:, 6:])


@compiled
def average(
    values: NDArray[np.float64],
    one: NDArray[np.int64],
    other: NDArray[np.int64],
    share: NDArray[np.float64],
    into: NDArray[np.float64],
) -> None:
    """Write the mean of each row and its neighbours' rows, where `share` is 1 / how many."""
    n, columns = values.shape
    for i in range(n):
        for c in range(columns):
            into[i, c] = values[i, c]
    for e in range(one.size):
        a, b = one[e], other[e]
        for c in range(columns):
            into[a, c] += values[b, c]
            into[b, c] += values[a, c]
    for i in range(n):
        for c in range(columns):
            into[i, c] *= share[i]
