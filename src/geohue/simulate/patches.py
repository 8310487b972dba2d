"""Curved surfaces as grids of corners, and clouds sampled from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.simulate.shapes import Floats, Vector

NOISE = 0.15
"""Standard deviation of a point's place, in mean distances of neighbours."""


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """A curved surface: a grid of corners, (R, C, 3), and the part it belongs to."""

    corners: Floats
    part: int


def sample(
    patches: list[Patch], n: int, rng: np.random.Generator
) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Sample patches evenly by area, with noise; points (n, 3) and their parts (n,).

    Examples
    --------
    >>> square = Patch(np.array([[[0, 0, 0], [1, 0, 0]], [[0, 1, 0], [1, 1, 0]]], float), 4)
    >>> points, parts = sample([square], 5, np.random.default_rng(0))
    >>> parts.tolist()
    [4, 4, 4, 4, 4]
    """
    triangles = [_triangles(patch.corners) for patch in patches]
    part = np.repeat([patch.part for patch in patches], [len(t) for t in triangles])
    corner = np.concatenate(triangles)
    sides = corner[:, 1:] - corner[:, :1]
    area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2
    chosen = rng.choice(len(area), n, p=area / area.sum())
    u, v = rng.random((2, n, 1))
    over = u + v > 1
    u, v = np.where(over, 1 - u, u), np.where(over, 1 - v, v)
    points = corner[chosen, 0] + u * sides[chosen, 0] + v * sides[chosen, 1]
    points += rng.normal(0, NOISE * np.sqrt(area.sum() / max(n, 1)), points.shape)
    return points.astype(np.float32), part[chosen].astype(np.int32)


def _triangles(corners: Floats) -> Floats:
    """Cut each cell of a grid into two triangles, (T, 3, 3)."""
    a, b, c, d = corners[:-1, :-1], corners[1:, :-1], corners[:-1, 1:], corners[1:, 1:]
    both = np.concatenate([np.stack([a, b, c], axis=2), np.stack([d, c, b], axis=2)])
    return np.asarray(both.reshape(-1, 3, 3))


def tube(path: Floats, radius: float | Floats, part: int) -> Patch:
    """A round surface of some radius along a path (m, 3)."""
    side, up = _frames(path)
    angle = np.linspace(0, 2 * np.pi, 17)[:, None, None]
    thick = np.broadcast_to(np.asarray(radius, np.float64), len(path))[:, None]
    around = path + thick * (np.cos(angle) * side + np.sin(angle) * up)
    return Patch(around, part)


def ribbon(path: Floats, width: Floats, part: int, fold: float = 0.4) -> Patch:
    """A strip of some width along a path (m, 3), folded along it like a leaf."""
    side, up = _frames(path)
    across = np.linspace(-0.5, 0.5, 9)[:, None, None]
    bend = fold * np.abs(across) * up
    return Patch(path + width[:, None] * (across * side + bend), part)


def box(center: Vector, size: Vector, part: int) -> list[Patch]:
    """The six sides of a box."""
    return [
        Patch(np.array(center) + np.array(size) * face, part)
        for axis in range(3)
        for at in (-0.5, 0.5)
        for face in [_face(axis, at)]
    ]


def _face(axis: int, at: float) -> Floats:
    """A side of the unit box around the origin, (2, 2, 3)."""
    face = np.stack(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [at], indexing="ij"), -1)[:, :, 0]
    return np.asarray(np.roll(face, axis + 1, axis=2))


def ellipsoid(center: Vector, radii: Vector, part: int) -> Patch:
    """A closed round surface."""
    a, b = np.meshgrid(np.linspace(0, np.pi, 17), np.linspace(0, 2 * np.pi, 25), indexing="ij")
    ball = np.stack([np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)], axis=-1)
    return Patch(np.array(center) + np.array(radii) * ball, part)


def _frames(path: Floats) -> tuple[Floats, Floats]:
    """Two directions across a path at each of its points."""
    along = np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    least = np.eye(3)[np.abs(along).max(axis=0).argmin()]
    side = np.cross(along, least)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    return side, np.cross(side, along)


def sheet(
    at: Vector,
    one: Vector,
    other: Vector,
    part: int,
) -> Patch:
    """A flat patch with a corner at a place, and two sides."""
    a, b, c = np.array(at, float), np.array(one, float), np.array(other, float)
    return Patch(np.array([[a, a + b], [a + c, a + b + c]]), part)
