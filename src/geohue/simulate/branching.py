"""Clouds with exact parts: thin branching things, and scenes that do not branch.

Each is a few curved patches, sampled evenly by area like a laser scan from all sides, with noise.

>>> points, truth = branching_cloud("maize", n=3000, seed=1)
>>> points.shape, truth.shape, int(truth.max())
((3000, 3), (3000,), 8)
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.simulate.patches import Patch, box, ellipsoid, ribbon, sample, sheet, tube
from geohue.simulate.shapes import Floats


def branching_cloud(
    name: str, n: int = 8000, seed: int = 0
) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Sample a cloud and its true parts.

    Parameters
    ----------
    name : str
        One of `BRANCHING` (maize, tree, cables, animal, hand) or `COMPACT` (statue, room, table,
        terrain, houses, boxes).
    n : int
        How many points.
    seed : int
        The source of chance of the shape, of the places of its points and of their noise.

    Returns
    -------
    points : (n, 3) float32
        Metres.
    truth : (n,) int32
        Parts from 0; the first is what the others grow from or stand on.

    Raises
    ------
    GeohueError
        For an unknown name or a negative number of points.
    """
    shapes = BRANCHING | COMPACT
    if name not in shapes:
        raise GeohueError(f"cloud {name!r}: choose one of {', '.join(shapes)}")
    if n < 0:
        raise GeohueError(f"n is {n}: expected 0 or more points")
    rng = np.random.default_rng(seed)
    patches = shapes[name](rng)
    return sample(patches, n, rng)


def _bow(
    start: Floats, turn: float, length: float, rise: float, droop: float, steps: int = 25
) -> Floats:
    """A path that leaves `start` upwards at some bearing and droops under its weight."""
    t = np.linspace(0, 1, steps)[:, None]
    out = np.array([np.cos(turn), np.sin(turn), 0.0])
    up = np.array([0.0, 0.0, 1.0])
    return np.asarray(start + length * (t * out + (rise * t - droop * t**2) * up))


def maize(rng: np.random.Generator) -> list[Patch]:
    """A stem and five to nine leaves, folded ribbons at alternate sides."""
    stem = np.linspace([0, 0, 0], [0.02, 0.01, rng.uniform(0.5, 0.9)], 30)
    patches = [tube(stem, np.linspace(0.016, 0.009, 30), 0)]
    n = int(rng.integers(5, 10))
    for i in range(n):
        at = stem[int(5 + 24 * i / (n - 1))]
        turn = np.pi * i + rng.normal(0, 0.35)
        length = rng.uniform(0.3, 0.6) * (0.6 if i in (0, n - 1) else 1.0)
        path = _bow(at, turn, length, rng.uniform(0.5, 1.6), rng.uniform(0.5, 1.8))
        t = np.linspace(0, 1, len(path))
        width = rng.uniform(0.04, 0.06) * (0.35 + 2.6 * t * (1 - t)) * (1 - t**8)
        patches.append(ribbon(path, width, i + 1))
    return patches


def tree(rng: np.random.Generator) -> list[Patch]:
    """A bare trunk with boughs, each a part of its own."""
    trunk = np.linspace([0, 0, 0], [0.2, 0.1, 5.0], 40)
    patches = [tube(trunk, np.linspace(0.16, 0.06, 40), 0)]
    for i in range(int(rng.integers(6, 11))):
        at = trunk[int(rng.uniform(12, 40))]
        path = _bow(
            at, rng.uniform(0, 2 * np.pi), rng.uniform(1.2, 2.4), rng.uniform(0.4, 1.3), 0.2
        )
        patches.append(tube(path, np.linspace(0.06, 0.02, len(path)), i + 1))
    return patches


def cables(rng: np.random.Generator) -> list[Patch]:
    """Cables that leave one plug and wind over a floor that was not scanned."""
    patches = box((0, 0, 0), (0.06, 0.04, 0.03), 0)
    n = int(rng.integers(3, 7))
    for i in range(n):
        t = np.linspace(0, 1, 60)[:, None]
        turn = 2 * np.pi * i / n + rng.normal(0, 0.1)
        out = np.array([np.cos(turn), np.sin(turn), 0.0])
        across = np.array([-out[1], out[0], 0.0])
        wave = rng.uniform(0.03, 0.08) * np.sin(rng.uniform(3, 8) * t + rng.uniform(0, 1)) * t
        path = rng.uniform(0.5, 1.0) * t * out + wave * across
        patches.append(tube(path, 0.008, i + 1))
    return patches


def animal(rng: np.random.Generator) -> list[Patch]:
    """A body on four legs, with neck and head, and a tail."""
    long, thin = rng.uniform(0.45, 0.6), rng.uniform(0.03, 0.05)
    patches = [ellipsoid((0, 0, 0.75), (long, 0.17, 0.19), 0)]
    for i, (x, y) in enumerate([(0.3, 0.1), (0.3, -0.1), (-0.3, 0.1), (-0.3, -0.1)]):
        leg = np.linspace([x, y, 0.65], [x + rng.normal(0, 0.08), y, 0.0], 15)
        patches.append(tube(leg, np.linspace(1.6 * thin, thin, 15), i + 1))
    neck = np.linspace([long - 0.12, 0, 0.82], [long + 0.2, 0, 1.25], 15)
    patches.append(tube(neck, np.linspace(0.1, 0.06, 15), 5))
    patches.append(ellipsoid((long + 0.28, 0, 1.28), (0.17, 0.07, 0.08), 5))
    tail = _bow(np.array([-long + 0.03, 0.0, 0.8]), np.pi, 0.35, 0.2, 1.3)
    patches.append(tube(tail, 0.02, 6))
    return patches


def hand(rng: np.random.Generator) -> list[Patch]:
    """A palm with a wrist and five fingers."""
    patches = [ellipsoid((0, 0, 0), (0.045, 0.05, 0.015), 0)]
    patches.append(tube(np.linspace([-0.03, 0, 0], [-0.12, 0, 0], 10), 0.025, 1))
    for i in range(5):
        turn = -1.0 + 0.42 * i + rng.normal(0, 0.04)
        out = np.array([np.cos(turn), np.sin(turn), 0.0])
        length = (0.07, 0.085, 0.09, 0.08, 0.06)[i]
        patches.append(tube(np.linspace(0.035 * out, (0.035 + length) * out, 12), 0.009, i + 2))
    return patches


def statue(rng: np.random.Generator) -> list[Patch]:
    """A figure, its arms at its body, on a pedestal."""
    patches = box((0, 0, 0.4), (0.8, 0.8, 0.8), 0)
    patches.append(ellipsoid((0, 0, 1.3), (0.3, 0.22, 0.55), 1))
    patches.append(ellipsoid((0, 0, 1.95), (0.13, 0.15, rng.uniform(0.16, 0.2)), 2))
    for side, part in ((-1, 3), (1, 4)):
        x = side * rng.uniform(0.3, 0.36)
        arm = np.linspace([x * 0.8, 0, 1.65], [x, 0.12, 1.05], 12)
        patches.append(tube(arm, 0.07, part))
    return patches


def room(rng: np.random.Generator) -> list[Patch]:
    """Floor, three walls, a table with legs, chairs and a cupboard."""
    wide, deep = rng.uniform(3, 5), rng.uniform(3, 5)
    patches = [
        sheet((0, 0, 0), (wide, 0, 0), (0, deep, 0), 0),
        sheet((0, 0, 0), (0, 0, 2.5), (0, deep, 0), 1),
        sheet((0, 0, 0), (wide, 0, 0), (0, 0, 2.5), 2),
        sheet((wide, 0, 0), (0, 0, 2.5), (0, deep, 0), 3),
    ]
    patches += _furniture(wide / 2, deep / 2, 1.4, 0.75, 4)
    for i in range(int(rng.integers(2, 5))):
        x, y = wide / 2 + rng.uniform(-1, 1), deep / 2 + (0.75 if i % 2 else -0.75)
        patches += _furniture(x, y, 0.42, 0.45, 5 + i)
        patches += box((x, y + (0.2 if i % 2 else -0.2), 0.75), (0.42, 0.04, 0.6), 5 + i)
    return patches + box((0.4, 0.5, 0.9), (0.6, 0.8, 1.8), 10)


def table(rng: np.random.Generator) -> list[Patch]:
    """A table top with boxes, balls and cans."""
    patches = [sheet((-0.6, -0.4, 0), (1.2, 0, 0), (0, 0.8, 0), 0)]
    for i in range(int(rng.integers(4, 9))):
        x, y, size = rng.uniform(-0.5, 0.5), rng.uniform(-0.3, 0.3), rng.uniform(0.05, 0.1)
        if i % 3 == 0:
            patches += box((x, y, size / 2), (size, 1.4 * size, size), i + 1)
        elif i % 3 == 1:
            patches.append(ellipsoid((x, y, size), (size, size, size), i + 1))
        else:
            can = np.linspace([x, y, 0], [x, y, 2.2 * size], 5)
            patches.append(tube(can, size / 2, i + 1))
    return patches


def terrain(rng: np.random.Generator) -> list[Patch]:
    """Hills."""
    x, y = np.meshgrid(np.linspace(0, 100, 60), np.linspace(0, 80, 60), indexing="ij")
    height = np.zeros_like(x)
    for scale in (60, 30, 15, 8):
        a, b, c = rng.uniform(0, 2 * np.pi, 3)
        height += scale / 9 * np.sin(2 * np.pi / scale * (x * np.cos(a) + y * np.sin(a)) + b + c)
    return [Patch(np.stack([x, y, height], axis=-1), 0)]


def houses(rng: np.random.Generator) -> list[Patch]:
    """Hills with houses on them."""
    patches = terrain(rng)
    ground = patches[0].corners
    for i in range(8):
        x, y, z = ground[int(rng.integers(5, 55)), int(rng.integers(5, 55))]
        patches += box((x, y, z + 3), (rng.uniform(8, 14), rng.uniform(6, 10), 8), i + 1)
    return patches


def boxes(rng: np.random.Generator) -> list[Patch]:
    """A pile of boxes."""
    patches: list[Patch] = []
    for i in range(6):
        at = (rng.uniform(-0.5, 0.5), rng.uniform(-0.5, 0.5), rng.uniform(0.2, 0.5))
        patches += box(at, (rng.uniform(0.3, 0.7), rng.uniform(0.3, 0.7), 0.5), i)
    return patches


def _furniture(x: float, y: float, size: float, height: float, part: int) -> list[Patch]:
    """A board on four legs."""
    patches = box((x, y, height), (size, 0.6 * size, 0.04), part)
    for dx in (-0.45, 0.45):
        for dy in (-0.25, 0.25):
            foot = (x + dx * size, y + dy * size)
            patches.append(tube(np.linspace([*foot, 0], [*foot, height], 5), 0.025, part))
    return patches


Builder = Callable[[np.random.Generator], list[Patch]]

BRANCHING: dict[str, Builder] = {
    "maize": maize,
    "tree": tree,
    "cables": cables,
    "animal": animal,
    "hand": hand,
}
"""Things of thin parts by name."""

COMPACT: dict[str, Builder] = {
    "statue": statue,
    "room": room,
    "table": table,
    "terrain": terrain,
    "houses": houses,
    "boxes": boxes,
}
"""Scenes and things that do not branch by name."""
