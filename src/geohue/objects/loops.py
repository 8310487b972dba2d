"""Sums over the points of each segment, one pass over the points each."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.compute.compiled import compiled

Floats = NDArray[np.float64]
Positions = NDArray[np.int64]

TERMS = 6
"""Of a quadric: 1, u, v, u^2, u v, v^2."""


@compiled
def add_up(
    labels: NDArray[np.int32],
    points: NDArray[np.float32],
    colors: NDArray[np.uint8],
    counts: Positions,
    color: Floats,
    place: Floats,
    low: Floats,
    high: Floats,
) -> None:
    """Count the points and the placed ones, add up colours and positions, and find the box.

    `counts` is (K, 2), the others (K, 3); all are changed in place.
    """
    for i in range(labels.size):
        k = labels[i]
        if k < 0:
            continue
        counts[k, 0] += 1
        for c in range(3):
            color[k, c] += colors[i, c]
        if not np.isfinite(points[i, 2]):
            continue
        counts[k, 1] += 1
        for c in range(3):
            x = np.float64(points[i, c])
            place[k, c] += x
            low[k, c] = min(low[k, c], x)
            high[k, c] = max(high[k, c], x)


@compiled
def add_spread(
    labels: NDArray[np.int32], points: NDArray[np.float32], center: Floats, out: Floats
) -> None:
    """Add up (p - c)(p - c)^T of each segment, (K, 6): xx, xy, xz, yy, yz, zz."""
    for i in range(labels.size):
        k = labels[i]
        if k < 0 or not np.isfinite(points[i, 2]):
            continue
        x, y, z = points[i, 0] - center[k, 0], points[i, 1] - center[k, 1], 0.0
        z = points[i, 2] - center[k, 2]
        out[k, 0] += x * x
        out[k, 1] += x * y
        out[k, 2] += x * z
        out[k, 3] += y * y
        out[k, 4] += y * z
        out[k, 5] += z * z


@compiled
def frame_box(labels: NDArray[np.int32], low: Positions, high: Positions) -> None:
    """Find the first and the last row and column of each segment, (K, 2) each."""
    for y in range(labels.shape[0]):
        for x in range(labels.shape[1]):
            k = labels[y, x]
            if k >= 0:
                low[k, 0], high[k, 0] = min(low[k, 0], y), max(high[k, 0], y)
                low[k, 1], high[k, 1] = min(low[k, 1], x), max(high[k, 1], x)


@compiled
def supports(
    labels: NDArray[np.int32],
    points: NDArray[np.float32],
    center: Floats,
    axes: Floats,
    directions: Floats,
    reach: Floats,
    at: Floats,
) -> None:
    """Find the two outermost points of each segment along each of D directions of its plane.

    `axes` is (K, 3, 3) with the plane's two directions as its first rows, `directions` (D, 2),
    `reach` (K, 2 D), lowest first, and `at` (K, 2 D, 2) the places of these points in the plane.
    """
    half = directions.shape[0]
    for i in range(labels.size):
        k = labels[i]
        if k < 0 or not np.isfinite(points[i, 2]):
            continue
        u, v = 0.0, 0.0
        for c in range(3):
            away = points[i, c] - center[k, c]
            u += away * axes[k, 0, c]
            v += away * axes[k, 1, c]
        for d in range(half):
            along = u * directions[d, 0] + v * directions[d, 1]
            if along > reach[k, d]:
                reach[k, d], at[k, d, 0], at[k, d, 1] = along, u, v
            if -along > reach[k, half + d]:
                reach[k, half + d], at[k, half + d, 0], at[k, half + d, 1] = -along, u, v


@compiled
def extents(
    labels: NDArray[np.int32],
    points: NDArray[np.float32],
    center: Floats,
    axes: Floats,
    low: Floats,
    high: Floats,
) -> None:
    """Find how far each segment reaches along its axes, from its centre; (K, 3) each."""
    for i in range(labels.size):
        k = labels[i]
        if k < 0 or not np.isfinite(points[i, 2]):
            continue
        x, y = points[i, 0] - center[k, 0], points[i, 1] - center[k, 1]
        z = points[i, 2] - center[k, 2]
        for a in range(3):
            along = x * axes[k, a, 0] + y * axes[k, a, 1] + z * axes[k, a, 2]
            low[k, a], high[k, a] = min(low[k, a], along), max(high[k, a], along)


@compiled
def add_quadric(
    labels: NDArray[np.int32],
    points: NDArray[np.float32],
    center: Floats,
    axes: Floats,
    unit: Floats,
    normal: Floats,
    right: Floats,
    square: Floats,
    terms: Floats,
) -> None:
    """Add up the normal equations of w = q(u, v), in units of `unit` (K,).

    `normal` is (K, 6, 6), its lower half filled, `right` (K, 6), `square` (K,) the sum of w^2;
    `terms` is room for 6 numbers.
    """
    for i in range(labels.size):
        k = labels[i]
        if k < 0 or not np.isfinite(points[i, 2]):
            continue
        u, v, w = 0.0, 0.0, 0.0
        for c in range(3):
            away = (points[i, c] - center[k, c]) / unit[k]
            u += away * axes[k, 0, c]
            v += away * axes[k, 1, c]
            w += away * axes[k, 2, c]
        terms[0], terms[1], terms[2] = 1.0, u, v
        terms[3], terms[4], terms[5] = u * u, u * v, v * v
        for a in range(TERMS):
            right[k, a] += terms[a] * w
            for b in range(a + 1):
                normal[k, a, b] += terms[a] * terms[b]
        square[k] += w * w
