"""Five textured scenes with exactly known segments.

Each asks for something else: one colour at two depths, two colours on one plane, round and slanted
surfaces, strong texture, a bare background.
"""

from __future__ import annotations

from collections.abc import Callable

from geohue.simulate.materials import Material
from geohue.simulate.shapes import Box, Cylinder, Plane, Shape, Sphere, Vector
from geohue.simulate.world import Solid, World

WALL = Material((196, 188, 172), grain=0.10, cell=0.05)
BARE_WALL = Material((200, 194, 182), grain=0.015, cell=0.3)
WOOD = Material((148, 104, 66), grain=0.30, cell=0.03)
CARPET = Material((92, 98, 110), grain=0.45, cell=0.02)
RED = Material((190, 52, 44), grain=0.22, cell=0.03)
GREEN = Material((60, 138, 74), grain=0.22, cell=0.03)
BLUE = Material((52, 88, 170), grain=0.22, cell=0.03)
YELLOW = Material((222, 182, 56), grain=0.18, cell=0.03)
CARDBOARD = Material((172, 132, 88), grain=0.22, cell=0.02)
STRIPED = Material((40, 60, 120), grain=0.12, cell=0.02, stripes=0.035, second=(226, 222, 210))
NEWSPRINT = Material((168, 166, 160), grain=0.75, cell=0.012)

_UP: Vector = (0, -1, 0)
_TOWARDS: Vector = (0, 0, -1)


def boxes() -> World:
    """Boxes on a table: two of one colour, one behind the other."""
    return _room(
        WOOD,
        WALL,
        1.75,
        [
            (Box((-0.30, -0.14, 1.15), (0.26, 0.28, 0.2), 25), RED),
            (Box((0.24, -0.11, 1.0), (0.24, 0.22, 0.18), -20), CARDBOARD),
            (Box((0.08, -0.21, 1.42), (0.4, 0.42, 0.16), 8), CARDBOARD),
        ],
    )


def balls() -> World:
    """Round things: shading and slant, but no plane."""
    return _room(
        CARPET,
        WALL,
        1.9,
        [
            (Sphere((-0.32, -0.17, 1.2), 0.17), YELLOW),
            (Sphere((0.10, -0.12, 1.0), 0.12), BLUE),
            (Cylinder((0.40, 0, 1.35), 0.11, 0.42), GREEN),
            (Sphere((-0.02, -0.2, 1.55), 0.2), RED),
        ],
    )


def posters() -> World:
    """Posters on the wall that only colour tells, and a box that only depth tells from it."""
    return _room(
        WOOD,
        BARE_WALL,
        1.7,
        [
            (Box((-0.42, -0.62, 1.69), (0.36, 0.44, 0.02)), BLUE),
            (Box((0.34, -0.6, 1.69), (0.44, 0.32, 0.02)), STRIPED),
            (Box((0.0, -0.17, 1.22), (0.3, 0.34, 0.24), 12), Material((200, 194, 182), 0.05)),
            (Cylinder((-0.42, 0, 1.15), 0.09, 0.26), RED),
        ],
    )


def shelf() -> World:
    """Things of all kinds of texture before a bare wall: stripes, print, plain paint."""
    return _room(
        CARPET,
        BARE_WALL,
        1.85,
        [
            (Box((-0.36, -0.2, 1.3), (0.3, 0.4, 0.2), 15), STRIPED),
            (Box((0.02, -0.1, 1.05), (0.28, 0.2, 0.2), -30), NEWSPRINT),
            (Cylinder((0.38, 0, 1.2), 0.12, 0.34), NEWSPRINT),
            (Box((0.12, -0.26, 1.6), (0.34, 0.52, 0.16), 0), GREEN),
        ],
    )


def corner() -> World:
    """A corner of a room: long slanted planes, a cupboard of the walls' colour and a ball."""
    things: list[tuple[Shape, Material]] = [
        (Plane((0.95, 0, 0), (-1, 0, -0.2)), Material((176, 190, 196), 0.08, 0.05)),
        (Box((-0.42, -0.35, 1.6), (0.4, 0.7, 0.4), 0), Material((206, 196, 176), 0.08, 0.05)),
        (Sphere((0.18, -0.14, 1.15), 0.14), RED),
        (Box((-0.1, -0.05, 1.0), (0.22, 0.1, 0.16), 35), BLUE),
    ]
    return _room(CARPET, WALL, 2.1, things)


def _room(
    ground: Material, wall: Material, depth: float, things: list[tuple[Shape, Material]]
) -> World:
    """Ground, a wall at some depth, and things, each a segment; seen from above."""
    solids = [
        Solid(Plane((0, 0, 0), _UP), ground, 0),
        Solid(Plane((0, 0, depth), _TOWARDS), wall, 1),
        *(Solid(shape, material, 2 + i) for i, (shape, material) in enumerate(things)),
    ]
    return World(tuple(solids), eye=(0.0, -0.75, 0.0), pitch=20.0)


WORLDS: dict[str, Callable[[], World]] = {
    "boxes": boxes,
    "balls": balls,
    "posters": posters,
    "shelf": shelf,
    "corner": corner,
}
"""The scenes by name."""
