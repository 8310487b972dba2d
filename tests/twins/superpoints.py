"""Measures of over-segmentations, region by region and pair by pair."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Labels = NDArray[np.int64]


def literal_levinshtein(pred: Labels, gt: Labels) -> float:
    errors = []
    for region in np.unique(gt):
        inside = gt == region
        touching = np.isin(pred, np.unique(pred[inside]))
        errors.append((int(touching.sum()) - int(inside.sum())) / int(inside.sum()))
    return float(np.mean(errors))


def literal_compactness(labels: Labels) -> float:
    height, width = labels.shape
    total = 0.0
    for segment in np.unique(labels[labels != -1]):
        area = perimeter = 0
        for y, x in np.argwhere(labels == segment):
            area += 1
            for v, u in ((y - 1, x), (y + 1, x), (y, x - 1), (y, x + 1)):
                outside = not (0 <= v < height and 0 <= u < width)
                perimeter += outside or labels[v, u] != segment
        total += area * 4 * math.pi * area / perimeter**2
    return total / int((labels != -1).sum())


def literal_pair_recall(
    these: Labels, those: Labels, pairs: list[tuple[int, int]], slack: int
) -> float:
    """Share of the border pairs of these labels that are near one of those."""
    mine = [pair for pair in pairs if these[pair[0]] != these[pair[1]]]
    theirs = [pair for pair in pairs if those[pair[0]] != those[pair[1]]]
    found = 0
    for pair in mine:
        reached = set(pair)
        for _ in range(slack - 1):
            reached |= {b for a, b in pairs if a in reached} | {a for a, b in pairs if b in reached}
        found += pair in theirs if slack == 0 else any(reached & set(other) for other in theirs)
    return found / len(mine) if mine else 1.0
