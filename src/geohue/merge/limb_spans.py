"""How long and how wide limbs are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

BANDS = 8
"""Slices across a limb in which its width is measured."""


@dataclass(frozen=True, slots=True, eq=False)
class Spans:
    """Where each limb begins and ends, and how wide it is.

    Attributes
    ----------
    nearest, farthest : (K,) float64
        Least and greatest reach of its points.
    widths : (K,) float64
        Across it: that of an even strip whose points are spread as far from the middles of
        `BANDS` slices, ``sqrt(12)`` times their root mean square distance.
    """

    nearest: Floats
    farthest: Floats
    widths: Floats

    @property
    def lengths(self) -> Floats:
        """From end to end along the surface, (K,)."""
        return self.farthest - self.nearest

    @classmethod
    def of(cls, points: Floats, owner: NDArray[np.int64], reach: Floats) -> Spans:
        """Measure limbs.

        Parameters
        ----------
        points : (n, 3) float64
            Positions.
        owner : (n,) int64
            The limb of each point, -1 for none.
        reach : (n,) float64
            Distance of each point from the centre along the surface.

        Returns
        -------
        Spans
            Of every limb up to the highest number.

        Examples
        --------
        >>> x, y = np.meshgrid(np.arange(80.0), np.arange(10.0))
        >>> strip = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
        >>> spans = Spans.of(strip, np.zeros(800, np.int64), x.ravel())
        >>> float(spans.lengths[0]), round(float(spans.widths[0]))
        (79.0, 14)
        """
        inside = np.flatnonzero(owner >= 0)
        owner, reach, points = owner[inside], reach[inside], points[inside]
        k = int(owner.max(initial=-1)) + 1
        nearest, farthest = np.full(k, np.inf), np.zeros(k)
        np.minimum.at(nearest, owner, reach)
        np.maximum.at(farthest, owner, reach)
        step = np.maximum((farthest - nearest)[owner] / BANDS, np.finfo(float).tiny)
        band = np.minimum((reach - nearest[owner]) / step, BANDS - 1).astype(np.int64)
        cell = owner * BANDS + band
        count = np.maximum(np.bincount(cell, minlength=k * BANDS), 1)
        sums = [np.bincount(cell, points[:, c], k * BANDS) for c in range(3)]
        away = points - (np.stack(sums, axis=1) / count[:, None])[cell]
        total = np.bincount(owner, (away**2).sum(axis=1), k)
        members = np.maximum(np.bincount(owner, minlength=k), 1)
        return cls(nearest, farthest, np.sqrt(12 * total / members))
