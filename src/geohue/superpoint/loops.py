"""Compiled passes over the points of a graph and its pairs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.compute.compiled import compiled
from geohue.merge.eigen import covariance, eigenvalue, eigenvector
from geohue.regions.pieces import find_root

Floats = NDArray[np.float64]
Positions = NDArray[np.int64]

_CELLS = 2**21 - 1


def curve(points: Floats) -> NDArray[np.uint64]:
    """Place of each point on the Z-order curve through the box of the points.

    Examples
    --------
    >>> curve(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 1]])).argsort().tolist()
    [0, 1, 2]
    """
    low = points.min(axis=0)
    scale = _CELLS / (float((points - low).max()) or 1.0)
    key = np.zeros(len(points), np.uint64)
    for axis in range(3):
        cell = ((points[:, axis] - low[axis]) * scale).astype(np.uint64)
        key |= _spread(cell) << np.uint64(axis)
    return key


def _spread(x: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Put two zeros between the bits of 21-bit numbers."""
    for shift, mask in (
        (32, 0x1F00000000FFFF),
        (16, 0x1F0000FF0000FF),
        (8, 0x100F00F00F00F00F),
        (4, 0x10C30C30C30C30C3),
        (2, 0x1249249249249249),
    ):
        x = (x | (x << np.uint64(shift))) & np.uint64(mask)
    return x


@compiled
def pair_up(near: Positions, distance: Floats, far: float, pairs: Positions) -> int:
    """List the pairs of points and their neighbours, each once; return how many.

    `near` and `distance` (n, k) have the point itself somewhere; pairs beyond `far` are left out.
    """
    n = 0
    for i in range(near.shape[0]):
        for a in range(near.shape[1]):
            j = near[i, a]
            if j == i or distance[i, a] > far:
                continue
            mutual = False
            for b in range(near.shape[1]):
                mutual |= near[j, b] == i
            if i < j or not mutual:
                pairs[n, 0], pairs[n, 1] = i, j
                n += 1
    return n


def csr(one: Positions, other: Positions, n: int) -> tuple[Positions, Positions]:
    """List the neighbours of each of n points: where each list begins (n + 1,), and all lists."""
    start = np.zeros(n + 1, np.int64)
    beside = np.empty(2 * len(one), np.int64)
    fill_lists(one, other, start, beside)
    return start, beside


@compiled
def fill_lists(one: Positions, other: Positions, start: Positions, beside: Positions) -> None:
    """Count the neighbours of each point, then write them; `start` comes in as zeros."""
    n = start.size - 1
    for e in range(one.size):
        start[one[e]] += 1
        start[other[e]] += 1
    total = 0
    for i in range(n):
        total += start[i]
        start[i] = total
    start[n] = total
    for e in range(one.size - 1, -1, -1):
        start[one[e]] -= 1
        beside[start[one[e]]] = other[e]
        start[other[e]] -= 1
        beside[start[other[e]]] = one[e]


@compiled
def moments(points: Floats, out: Floats) -> None:
    """Write 1, x, y, z, xx, xy, xz, yy, yz, zz of each point."""
    for i in range(points.shape[0]):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = 1.0, x, y, z
        out[i, 4], out[i, 5], out[i, 6] = x * x, x * y, x * z
        out[i, 7], out[i, 8], out[i, 9] = y * y, y * z, z * z


@compiled
def gather(
    values: Floats, start: Positions, beside: Positions, out: Floats, begin: int, end: int
) -> None:
    """Add the rows of its neighbours to the row of each point from `begin` to `end`."""
    for i in range(begin, end):
        for c in range(values.shape[1]):
            out[i, c] = values[i, c]
        for at in range(start[i], start[i + 1]):
            j = beside[at]
            for c in range(values.shape[1]):
                out[i, c] += values[j, c]


@compiled
def least_spread(sums: Floats, normals: Floats, room: Floats, begin: int, end: int) -> None:
    """Write the direction of least spread of each row of moments; zeros where there is none."""
    for i in range(begin, end):
        covariance(sums, i, 1, 4, sums[i, 0], room)
        eigenvector(room, eigenvalue(room, 0), normals, i, 0)


@compiled
def pair_steps(
    points: Floats,
    lab: Floats,
    normals: Floats,
    one: Positions,
    other: Positions,
    spacing: float,
    weights: Floats,
    out: Floats,
) -> None:
    """Write the step between two neighbours: of colour, of the normal, and off the surface.

    The root of ``w0 |dLab|^2 + w1 (1 - (n1 . n2)^2) + w2 (gap / spacing)^2``, where the gap is the
    mean distance of each from the tangent plane of the other.
    """
    for e in range(one.size):
        a, b = one[e], other[e]
        color, dot, gap_a, gap_b = 0.0, 0.0, 0.0, 0.0
        for c in range(3):
            color += (lab[a, c] - lab[b, c]) ** 2
            dot += normals[a, c] * normals[b, c]
            away = points[b, c] - points[a, c]
            gap_a += away * normals[a, c]
            gap_b += away * normals[b, c]
        gap = (abs(gap_a) + abs(gap_b)) / (2 * spacing)
        turn = 1.0 - min(dot * dot, 1.0)
        out[e] = np.sqrt(weights[0] * color + weights[1] * turn + weights[2] * min(gap, 3.0) ** 2)


@compiled
def join_capped(
    one: Positions,
    other: Positions,
    order: Positions,
    parent: NDArray[np.int32],
    size: Floats,
    cap: float,
) -> None:
    """Join neighbours, those with the least step first, as long as no set outgrows `cap`."""
    for at in range(order.size):
        e = order[at]
        a, b = find_root(parent, one[e]), find_root(parent, other[e])
        if a != b and size[a] + size[b] <= cap:
            low, high = min(a, b), max(a, b)
            parent[high] = low
            size[low] += size[high]


@compiled
def number_sets(parent: NDArray[np.int32], labels: NDArray[np.int32]) -> int:
    """Number the sets 0..R-1 in the order of their first members; return R."""
    n = 0
    for i in range(parent.size):
        root = find_root(parent, i)
        if root == i:
            labels[i] = n
            n += 1
        else:
            labels[i] = labels[root]
    return n


def mean_area(points: Floats, normals: Floats, one: Positions, other: Positions) -> float:
    """Area of the surface around a point, on average.

    A point's neighbours fill a disc in its tangent plane: d of them at a root mean square distance
    r fill pi 2 r^2 with themselves and the point, ``2 pi r^2 / (d + 1.5)`` each, to a fifth.

    Examples
    --------
    >>> y, x = np.mgrid[:20, :20].reshape(2, -1)
    >>> plane = np.stack([x, y, 0 * x], axis=1).astype(float)
    >>> i = np.arange(400)
    >>> right, down = i[x < 19], i[y < 19]
    >>> one, other = np.append(right, down), np.append(right + 1, down + 20)
    >>> round(mean_area(plane, np.zeros_like(plane), one, other), 2)
    1.19
    """
    n = len(points)
    away = points[other] - points[one]
    square = (away**2).sum(axis=1)
    typical = np.median(square) if len(square) else 0.0
    near = square <= 9 * typical  # not across gaps
    total, degree = np.zeros(n), np.zeros(n)
    for side in (one, other):
        flat = square[near] - ((away * normals[side]).sum(axis=1)[near]) ** 2
        total += np.bincount(side[near], flat, n)
        degree += np.bincount(side[near], minlength=n)
    known = degree > 0
    mean = total[known] / degree[known]
    return float((2 * np.pi * mean / (degree[known] + 1.5)).mean()) if known.any() else 0.0
