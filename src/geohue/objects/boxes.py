"""Oriented boxes: flat on the segment's plane, turned so that they are smallest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.objects import loops
from geohue.objects.surfaces import Planes

Floats = NDArray[np.float64]

DIRECTIONS = 16
"""Directions over half a turn along which the outermost points are looked for."""

TURNS = 90
"""Turns of the box over a right angle that are tried."""

_BLOCK = 1000


@dataclass(frozen=True, slots=True, eq=False)
class Boxes:
    """A box around each segment.

    Attributes
    ----------
    center : (K, 3) float64
        NaN where no point has a position.
    size : (K, 3) float64
        Full lengths of its edges along `axes`.
    axes : (K, 3, 3) float64
        Rows: unit vectors along the longer and the shorter edge in the segment's plane, and its
        normal; right-handed.
    """

    center: Floats
    size: Floats
    axes: Floats

    @property
    def corners(self) -> Floats:
        """The eight corners of each box, (K, 8, 3)."""
        sign = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)])
        half = sign * self.size[:, None] / 2
        return np.asarray(self.center[:, None] + np.einsum("kci,kij->kcj", half, self.axes))

    @property
    def volume(self) -> Floats:
        """Volume of each box, (K,)."""
        return np.asarray(self.size.prod(axis=1))


def oriented_boxes(labels: NDArray[np.int32], points: NDArray[np.float32], planes: Planes) -> Boxes:
    """Box each segment: one side along its plane, turned to the least area within it.

    The turn is chosen, to a degree, on the outermost points along 16 directions; the box then holds
    every point.
    """
    k = len(planes.center)
    angle = np.arange(DIRECTIONS) * np.pi / DIRECTIONS
    directions = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    reach = np.full((k, 2 * DIRECTIONS), -np.inf)
    at = np.zeros((k, 2 * DIRECTIONS, 2))
    here = labels, points, planes.center
    loops.supports(*here, planes.axes, directions, reach, at)
    axes = _turned(planes.axes, _best_turn(at))
    low, high = np.full((k, 3), np.inf), np.full((k, 3), -np.inf)
    loops.extents(*here, axes, low, high)
    nowhere = ~np.isfinite(low[:, 0])
    low[nowhere], high[nowhere] = np.nan, np.nan
    size = high - low
    tall = size[:, 1] > size[:, 0]  # the longer edge comes first
    axes[tall] = np.stack([axes[tall, 1], -axes[tall, 0], axes[tall, 2]], axis=1)
    middle = (low + high) / 2
    middle[tall] = np.stack([middle[tall, 1], -middle[tall, 0], middle[tall, 2]], axis=1)
    size[tall] = size[tall][:, [1, 0, 2]]
    return Boxes(planes.center + np.einsum("ki,kij->kj", middle, axes), size, axes)


def _best_turn(at: Floats) -> Floats:
    """Angle of the rectangle of least area around the points (K, S, 2), 0 to a right angle."""
    angles = np.arange(TURNS) * (np.pi / 2 / TURNS)
    ways = np.stack([np.cos(angles), np.sin(angles)])  # (2, T)
    across = np.stack([-np.sin(angles), np.cos(angles)])
    best = np.empty(len(at))
    for i in range(0, len(at), _BLOCK):
        some = at[i : i + _BLOCK]
        area = np.ptp(some @ ways, axis=1) * np.ptp(some @ across, axis=1)
        best[i : i + _BLOCK] = angles[area.argmin(axis=1)]
    return best


def _turned(axes: Floats, angle: Floats) -> Floats:
    """Turn the first two axes about the third."""
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    u, v = axes[:, 0], axes[:, 1]
    return np.stack([c * u + s * v, c * v - s * u, axes[:, 2]], axis=1)
