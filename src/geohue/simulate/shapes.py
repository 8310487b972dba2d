"""Shapes that a ray meets at an exactly known distance.

Each has ``hit(origin, directions)``: the distance along every ray in units of its direction
(infinity for a miss) and the outward normal there. World frame: x right, y down, z forward,
metres.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Vector: TypeAlias = tuple[float, float, float]

_NEAREST = 1e-6


class Shape(Protocol):
    """What a ray can meet."""

    def hit(self, origin: Floats, directions: Floats) -> tuple[Floats, Floats]:
        """Return distances (M,) and normals (M, 3) of rays from one origin or (M, 3) origins."""
        ...


@dataclass(frozen=True, slots=True)
class Plane:
    """An endless plane through a point.

    Examples
    --------
    >>> Plane((0, 0, 2), (0, 0, -1)).hit(np.zeros(3), np.array([[0.0, 0.5, 1.0]]))[0]
    array([2.])
    """

    point: Vector
    normal: Vector

    def hit(self, origin: Floats, directions: Floats) -> tuple[Floats, Floats]:
        """Return distances and normals."""
        normal = np.array(self.normal, np.float64)
        normal /= np.linalg.norm(normal)
        speed = directions @ normal
        height = (np.array(self.point) - origin) @ normal
        with np.errstate(divide="ignore", invalid="ignore"):
            t = height / speed
        t = np.where(t > _NEAREST, t, np.inf)
        return t, np.broadcast_to(normal, directions.shape)


@dataclass(frozen=True, slots=True)
class Sphere:
    """A ball.

    Examples
    --------
    >>> Sphere((0, 0, 3), 1).hit(np.zeros(3), np.array([[0.0, 0.0, 1.0]]))[0]
    array([2.])
    """

    center: Vector
    radius: float

    def hit(self, origin: Floats, directions: Floats) -> tuple[Floats, Floats]:
        """Return distances and normals."""
        start = origin - np.array(self.center)
        t = _first_root(
            np.einsum("...j,...j->...", directions, directions),
            np.einsum("...j,...j->...", directions, start),
            np.einsum("...j,...j->...", start, start) - self.radius**2,
        )
        return t, _at(start, directions, t) / self.radius


@dataclass(frozen=True, slots=True)
class Cylinder:
    """An upright cylinder with a lid, standing on the centre of its base."""

    base: Vector
    radius: float
    height: float

    def hit(self, origin: Floats, directions: Floats) -> tuple[Floats, Floats]:
        """Return distances and normals."""
        start = origin - np.array(self.base)
        flat = np.array([1.0, 0.0, 1.0])
        side = _first_root(
            (directions**2 * flat).sum(axis=-1),
            (directions * start * flat).sum(axis=-1),
            (start**2 * flat).sum(axis=-1) - self.radius**2,
        )
        point = _at(start, directions, side)
        inside = (point[..., 1] <= 0) & (point[..., 1] >= -self.height)
        side = np.where(inside, side, np.inf)
        lid, normal = Plane((0, -self.height, 0), (0, -1, 0)).hit(start, directions)
        top = _at(start, directions, lid)
        lid = np.where((top**2 * flat).sum(axis=-1) <= self.radius**2, lid, np.inf)
        first = (side <= lid)[..., None]
        return np.minimum(side, lid), np.where(first, point * flat / self.radius, normal)


@dataclass(frozen=True, slots=True)
class Box:
    """A box, turned about the vertical by `turn` degrees."""

    center: Vector
    size: Vector
    turn: float = 0.0

    def hit(self, origin: Floats, directions: Floats) -> tuple[Floats, Floats]:
        """Return distances and normals."""
        c, s = np.cos(np.radians(self.turn)), np.sin(np.radians(self.turn))
        rotation = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
        start = (origin - np.array(self.center)) @ rotation
        ahead = directions @ rotation
        half = np.array(self.size) / 2
        with np.errstate(divide="ignore", invalid="ignore"):
            one, other = (-half - start) / ahead, (half - start) / ahead
        # A ray along a face's plane: inside it always or never.
        low = np.nan_to_num(np.minimum(one, other), nan=-np.inf)
        high = np.nan_to_num(np.maximum(one, other), nan=np.inf)
        enter, leave = low.max(axis=-1), high.min(axis=-1)
        t = np.where((enter <= leave) & (enter > _NEAREST), enter, np.inf)
        axis = low.argmax(axis=-1)
        normal = np.where(np.arange(3) == axis[..., None], -np.sign(ahead), 0.0)
        return t, normal @ rotation.T


def _first_root(a: Floats, half_b: Floats, c: Floats) -> Floats:
    """Return the smaller positive root of ``a t^2 + 2 half_b t + c``, infinity if none."""
    inside = half_b**2 - a * c
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (-half_b - np.sqrt(np.maximum(inside, 0))) / a
    return np.where((inside >= 0) & (t > _NEAREST), t, np.inf)


def _at(start: Floats, directions: Floats, t: Floats) -> Floats:
    return np.asarray(start + directions * np.where(np.isfinite(t), t, 0)[..., None])
