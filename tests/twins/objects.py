"""Object measures, mask by mask, with every assignment tried."""

from __future__ import annotations

from collections.abc import Collection
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

Labels = NDArray[np.int64]
Mask = NDArray[np.bool_]


def literal_objects(
    pred: Labels, gt: Labels, background: Collection[int], given: bool
) -> tuple[list[Mask], list[Mask], list[tuple[int, int]]]:
    """Masks of the predicted and the true objects, and their pairs; nothing is ignored."""
    true = [gt == label for label in np.unique(gt) if label not in background]
    floor = np.isin(gt, list(background))
    predicted = []
    for label in np.unique(pred[pred != -1]):
        mask = pred == label
        best = max((int((mask & t).sum()) for t in true), default=0)
        if not (given and int((mask & floor).sum()) > best):
            predicted.append(mask)
    return predicted, true, best_pairs(predicted, true)


def best_pairs(predicted: list[Mask], true: list[Mask]) -> list[tuple[int, int]]:
    """The pairs of the assignment with the largest sum of F; the largest overlap breaks ties."""
    places = [*range(len(true)), *[-1] * len(predicted)]
    best: tuple[tuple[float, int], list[tuple[int, int]]] = ((-1.0, 0), [])
    for chosen in set(permutations(places, len(predicted))):
        pairs = [(i, j) for i, j in enumerate(chosen) if j >= 0 and (predicted[i] & true[j]).any()]
        overlap = sum(int((predicted[i] & true[j]).sum()) for i, j in pairs)
        worth = (round(value(predicted, true, pairs), 9), overlap)
        best = max(best, (worth, pairs), key=lambda found: found[0])
    return best[1]


def value(predicted: list[Mask], true: list[Mask], pairs: list[tuple[int, int]]) -> float:
    """Sum of the pairs' F."""
    return sum(
        2 * int((predicted[i] & true[j]).sum()) / int(predicted[i].sum() + true[j].sum())
        for i, j in pairs
    )


def literal_overlap(
    predicted: list[Mask], true: list[Mask], pairs: list[tuple[int, int]]
) -> tuple[float, float]:
    """Precision and recall of the pixels."""
    found = sum(int((predicted[i] & true[j]).sum()) for i, j in pairs)
    return _share(found, sum(int(m.sum()) for m in predicted)), _share(
        found, sum(int(m.sum()) for m in true)
    )


def literal_outline(mask: Mask) -> Mask:
    """Pixels whose right, lower or lower right neighbour is on the other side."""
    found = np.zeros(mask.shape, bool)
    height, width = mask.shape
    for y in range(height):
        for x in range(width):
            for v, u in ((y, x + 1), (y + 1, x), (y + 1, x + 1)):
                if v < height and u < width and mask[v, u] != mask[y, x]:
                    found[y, x] = True
    return found


def literal_outlines(
    predicted: list[Mask], true: list[Mask], pairs: list[tuple[int, int]], slack: float
) -> tuple[float, float]:
    """Precision and recall of the outlines."""
    mine, theirs = ([literal_outline(m) for m in masks] for masks in (predicted, true))
    hits = sum(_near(mine[i], theirs[j], slack) for i, j in pairs)
    found = sum(_near(theirs[j], mine[i], slack) for i, j in pairs)
    return _share(hits, sum(int(m.sum()) for m in mine)), _share(
        found, sum(int(m.sum()) for m in theirs)
    )


def _near(these: Mask, those: Mask, slack: float) -> int:
    return sum(
        any(np.hypot(*(p - q)) <= slack for q in np.argwhere(those)) for p in np.argwhere(these)
    )


def _share(part: int, whole: int) -> float:
    return part / whole if whole else 1.0
