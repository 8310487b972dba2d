"""The inner loops of k-means; `geohue.compute.lloyd` says what they do."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.compute.compiled import compiled, compiled_part


@compiled_part
def squared_distance(a: NDArray[np.float64], i: int, b: NDArray[np.float64], j: int) -> float:
    """Squared distance between two rows."""
    total = 0.0
    for c in range(a.shape[1]):
        step = a[i, c] - b[j, c]
        total += step * step
    return total


@compiled_part
def assign(
    rows: NDArray[np.float64],
    weights: NDArray[np.float64],
    centers: NDArray[np.float64],
    labels: NDArray[np.int32],
    sums: NDArray[np.float64],
) -> tuple[bool, float]:
    """Label each row with its nearest centre and add it to that centre's sums, weight first.

    Returns whether a label changed, and the weighted sum of the squared distances.
    """
    sums[:] = 0.0
    changed, cost = False, 0.0
    for i in range(len(rows)):
        least, nearest = np.inf, 0
        for q in range(len(centers)):
            distance = squared_distance(rows, i, centers, q)
            if distance < least:
                least, nearest = distance, q
        changed |= labels[i] != nearest
        labels[i] = nearest
        cost += weights[i] * least
        sums[nearest, 0] += weights[i]
        for c in range(rows.shape[1]):
            sums[nearest, c + 1] += weights[i] * rows[i, c]
    return changed, cost


@compiled
def move_centers(
    rows: NDArray[np.float64],
    weights: NDArray[np.float64],
    centers: NDArray[np.float64],
    steps: int,
    labels: NDArray[np.int32],
    sums: NDArray[np.float64],
) -> float:
    """Move the centres until no label changes; returns the cost. `labels` begin as -1."""
    _, cost = assign(rows, weights, centers, labels, sums)
    for _ in range(steps):
        for q in range(len(centers)):
            if sums[q, 0] > 0:
                for c in range(rows.shape[1]):
                    centers[q, c] = sums[q, c + 1] / sums[q, 0]
        changed, cost = assign(rows, weights, centers, labels, sums)
        if not changed:
            break
    return cost


@compiled
def draw_seeds(
    rows: NDArray[np.float64],
    weights: NDArray[np.float64],
    draws: NDArray[np.float64],
    distance: NDArray[np.float64],
    chosen: NDArray[np.int64],
) -> None:
    """Add to ``chosen[0]`` a row for each draw, with chances as the weighted squared distances."""
    distance[:] = np.inf
    for n in range(len(draws)):
        total = 0.0
        for i in range(len(rows)):
            distance[i] = min(distance[i], squared_distance(rows, i, rows, chosen[n]))
            total += weights[i] * distance[i]
        left = draws[n] * total
        chosen[n + 1] = len(rows) - 1
        for i in range(len(rows)):
            left -= weights[i] * distance[i]
            if left < 0:
                chosen[n + 1] = i
                break
