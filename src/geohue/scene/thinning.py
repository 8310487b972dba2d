"""The few points that stand for a scene."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_FEW = 500
"""Points with geometry below which a thinned grid takes more of its rows and columns."""


def thin_grid(valid: NDArray[np.bool_], max_points: int) -> NDArray[np.int64]:
    """Choose every n-th row and column of a grid; flat positions, (h, w).

    Examples
    --------
    >>> thin_grid(np.ones((4, 6), bool), 6).tolist()
    [[7, 9, 11], [19, 21, 23]]
    """
    height, width = valid.shape
    step = max(1, int(np.ceil(np.sqrt(valid.size / max_points))))
    enough = min(int(valid.sum()), max_points // 10, _FEW)
    while True:
        rows, columns = (np.arange(min(step // 2, n - 1), n, step) for n in (height, width))
        found = valid[rows[:, None], columns].sum()
        large = len(rows) * len(columns) > 2 * max_points and found > 0
        if step == 1 or found >= enough or large:
            return np.asarray(rows[:, None] * width + columns, np.int64)
        step = (step + 1) // 2


def thin_cloud(
    colors: NDArray[np.uint8],
    points: NDArray[np.float32],
    unseen: NDArray[np.bool_] | None,
    max_points: int,
    rng: np.random.Generator,
) -> NDArray[np.int64]:
    """Draw points of a cloud, whatever their order in it; positions, (m,).

    Examples
    --------
    >>> colors, points = np.zeros((9, 3), np.uint8), np.eye(9, 3, dtype=np.float32)
    >>> len(thin_cloud(colors, points, None, 4, np.random.default_rng(0)))
    4
    """
    order = _canonical_order(colors, points)
    if unseen is not None:
        order = order[~unseen[order]]
    if len(order) > max_points:
        order = order[np.sort(rng.choice(len(order), max_points, replace=False))]
    return order


def _canonical_order(colors: NDArray[np.uint8], points: NDArray[np.float32]) -> NDArray[np.int64]:
    """Sort points by colour, then by distance from the centroid."""
    red, green, blue = (colors[:, c].astype(np.uint64) for c in range(3))
    finite = np.isfinite(points[:, 2])
    center = points[finite].mean(axis=0, dtype=np.float64) if finite.any() else np.zeros(3)
    with np.errstate(over="ignore"):  # what float32 cannot hold comes last, as inf
        distance = np.linalg.norm(points - center, axis=1).astype(np.float32)
    # The bits of a positive float sort like its value.
    bits = np.where(finite, distance, np.float32(np.inf)).view(np.uint32).astype(np.uint64)
    key = (red << np.uint64(48)) | (green << np.uint64(40)) | (blue << np.uint64(32)) | bits
    return np.argsort(key, kind="stable")
