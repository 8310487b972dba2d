"""Joining by votes one border at a time, and spreading labels pixel by pixel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.features import Features

Pairs = list[tuple[int, int, float]]


def join(pairs: Pairs, n: int, least: float) -> list[int]:
    """Join the two regions with the fewest mean votes between them until none has too few."""
    region = list(range(n))
    while True:
        borders: dict[tuple[int, int], list[float]] = {}
        for one, other, share in pairs:
            a, b = sorted((region[one], region[other]))
            if a != b:
                borders.setdefault((a, b), []).append(share)
        means = {pair: float(np.mean(shares)) for pair, shares in borders.items()}
        if not means or min(means.values()) >= least:
            return region
        a, b = min(means, key=means.__getitem__)
        region = [a if r == b else r for r in region]


def spread(
    labels: NDArray[np.int32], draft: NDArray[np.int64], features: Features
) -> NDArray[np.int32]:
    """Compare each pixel with the kept pixels in the two nearest kept rows and columns."""
    height, width = features.shape
    rows, columns = draft[:, 0] // width, draft[0] % width
    vectors = features.to_scene(np.arange(len(features), dtype=np.int32)), features.mixed(1.0)
    out = np.empty((height, width), np.int32)
    for y in range(height):
        for x in range(width):
            best = np.inf
            for i in np.lexsort((-rows, np.abs(rows - y)))[:2]:
                for j in np.lexsort((-columns, np.abs(columns - x)))[:2]:
                    here = vectors[1][vectors[0][y, x]]
                    there = vectors[1][vectors[0][rows[i], columns[j]]]
                    distance = float(((here - there) ** 2).sum())
                    if distance < best:
                        best, out[y, x] = distance, labels[i, j]
    return out
