"""The merging of superpoints, slowly: every cost anew at every step."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.superpoint.ward import COLOR, EDGE, LONG, POWER, SAME, TURN

Floats = NDArray[np.float64]


def slow_cost(a: Floats, b: Floats, border: Floats, spacing: float, weights: Floats) -> float:
    """Cost of the union of two regions, from the sums of each."""
    n, m = a[0], b[0]
    one, other = a / n, b / m
    color = ((one[1:4] - other[1:4]) ** 2).sum()
    index = [[0, 1, 2], [1, 3, 4], [2, 4, 5]]
    turn = ((one[4:10][index] - other[4:10][index]) ** 2).sum()
    long = ((one[10:] - other[10:]) ** 2).sum() / (spacing**2 * (n + m))
    unlike = weights[COLOR] * color + weights[TURN] * turn + weights[SAME] + weights[LONG] * long
    step = border[1] / border[0]
    return float((n * m / (n + m)) ** weights[POWER] * unlike * (weights[EDGE] + step))


def slow_merges(
    region: Floats, border: Floats, pairs: NDArray[np.int64], spacing: float, weights: Floats
) -> list[tuple[tuple[int, int], float]]:
    """Merge the cheapest pair of neighbours again and again; each pair and its cost."""
    sums = {i: row.copy() for i, row in enumerate(region)}
    borders = {
        tuple(map(int, pair)): row.astype(float) for pair, row in zip(pairs, border, strict=True)
    }
    found = []
    while borders:
        costs = {
            (i, j): slow_cost(sums[i], sums[j], row, spacing, weights)
            for (i, j), row in borders.items()
        }
        kept, gone = min(costs, key=costs.__getitem__)
        found.append(((kept, gone), costs[kept, gone]))
        del borders[kept, gone]
        sums[kept] = sums[kept] + sums.pop(gone)
        after: dict[tuple[int, ...], Floats] = {}
        for (i, j), row in borders.items():
            ends = (kept if i == gone else i, kept if j == gone else j)
            name = ends if ends in after or ends[::-1] not in after else ends[::-1]
            after[name] = after[name] + row if name in after else row
        borders = after
    return found
