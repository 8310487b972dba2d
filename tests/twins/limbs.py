"""The sweep with sets of points, and what is measured along limbs and paths, point by point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Pairs = list[tuple[int, int]]


@dataclass(eq=False)
class Part:
    """A set of points while the sweep runs."""

    points: set[int]
    core: bool = False
    closed: bool = False


def sweep(height: list[float], pairs: Pairs, shortest: float, cell: float) -> set[frozenset[int]]:
    """Return the limbs that a sweep from the highest points downwards closes."""
    part_of: dict[int, Part] = {}
    for v in sorted(range(len(height)), key=lambda v: -height[v]):
        beside = {a + b - v for a, b in pairs if v in (a, b) and a != b}
        parts = [part_of[u] for u in beside if u in part_of]
        live = list({id(part): part for part in parts if not part.closed}.values())

        def is_grown(part: Part, floor: float = height[v]) -> bool:
            length = max(height[u] for u in part.points) - floor
            return length > shortest and length**2 > cell * len(part.points)

        meeting = sum(part.core or is_grown(part) for part in live) >= 2
        new = Part({v}, core=meeting or (len(parts) > 0 and len(live) == 0))
        for part in live:
            if meeting and not part.core and is_grown(part):
                part.closed = True
            else:
                new.points |= part.points
                new.core |= part.core
        for u in new.points:
            part_of[u] = new
    return {frozenset(part.points) for part in part_of.values() if part.closed}


def width(points: NDArray[np.float64], reach: NDArray[np.float64], bands: int) -> float:
    """Measure the width of one limb, slice by slice."""
    step = (reach.max() - reach.min()) / bands
    total = 0.0
    for i in range(bands):
        low = reach.min() + i * step
        inside = (reach >= low) & ((reach < low + step) | (i == bands - 1))
        if inside.any():
            total += float(((points[inside] - points[inside].mean(axis=0)) ** 2).sum())
    return float(np.sqrt(12 * total / len(points)))


def limbs_beside(
    points: NDArray[np.float64], on_path: list[int], limbs: list[int], radius: float
) -> list[int]:
    """Count the limbs with a path within a radius of each point of the paths."""
    return [
        len({j for b, j in zip(on_path, limbs, strict=True) if _distance(points, a, b) <= radius})
        for a in on_path
    ]


def _distance(points: NDArray[np.float64], a: int, b: int) -> float:
    return float(np.sqrt(((points[a] - points[b]) ** 2).sum()))
