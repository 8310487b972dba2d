"""The loops of the cut as array operations: slow, and plain to read."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]


def gram(c: Array, to_degree: Array, weights: Array | None = None) -> Array:
    """C^T W D^-1 C with the degrees max(C @ to_degree, weights)."""
    w = np.ones(len(c)) if weights is None else weights
    degree = np.maximum(c @ to_degree, w)
    return np.asarray((c * (w / degree)[:, None]).T @ c)


def nearest(c: Array, basis: Array, centers: Array) -> NDArray[np.int64]:
    """The centre nearest to each row of C @ basis, brought to length 1."""
    rows = c @ basis
    rows = rows / np.linalg.norm(rows, axis=1)[:, None]
    return np.asarray(((rows[:, None] - centers[None]) ** 2).sum(axis=2).argmin(axis=1))


def lloyd(rows: Array, centers: Array, steps: int) -> tuple[Array, float]:
    """k-means: each centre to the mean of its rows, until no label changes."""
    labels = np.full(len(rows), -1)
    for _ in range(steps + 1):
        distance = ((rows[:, None] - centers[None]) ** 2).sum(axis=2)
        if np.array_equal(distance.argmin(axis=1), labels):
            break
        labels = distance.argmin(axis=1)
        cost = float(distance.min(axis=1).sum())
        means = [rows[labels == q].mean(axis=0) for q in range(len(centers)) if (labels == q).any()]
        new = centers.copy()
        new[np.unique(labels)] = means
        last, centers = centers, new
    else:
        return last, cost
    return centers, float(distance.min(axis=1).sum())


def spread_seeds(rows: Array, first: int, draws: Array) -> Array:
    """k-means++: each next row with a chance that grows with its squared distance."""
    chosen = [first]
    for draw in draws:
        distance = ((rows[:, None] - rows[chosen][None]) ** 2).sum(axis=2).min(axis=1)
        below = np.cumsum(distance) <= draw * distance.sum()
        chosen.append(min(int(below.sum()), len(rows) - 1))
    return np.asarray(rows[chosen])
