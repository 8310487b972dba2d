"""Contrast and distances of segmentations, pair by pair."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue import Scene
from geohue.features import lab_of
from geohue.measures import variation_of_information

Labels = NDArray[np.int32]


def contrast(scene: Scene, labels: Labels) -> float:
    """The mean Lab step across borders, over that between any labelled 4-neighbours."""
    lab = lab_of(scene.colors).astype(np.float64)
    height, width = scene.shape
    steps, across = [], []
    for y in range(height):
        for x in range(width):
            for v, u in ((y, x + 1), (y + 1, x)):
                if v >= height or u >= width or not (scene.valid[y, x] and scene.valid[v, u]):
                    continue
                if labels[y, x] < 0 or labels[v, u] < 0:
                    continue
                steps.append(float(np.linalg.norm(lab[y, x] - lab[v, u])))
                if labels[y, x] != labels[v, u]:
                    across.append(steps[-1])
    return float(np.mean(across) / np.mean(steps)) if across else float("nan")


def distances(maps: list[Labels]) -> NDArray[np.float64]:
    """Variation of information over the points that both maps label; 0 where there are none."""
    table = np.zeros((len(maps), len(maps)))
    for i, one in enumerate(maps):
        for j, other in enumerate(maps):
            both = (one >= 0) & (other >= 0)
            if both.any():
                found = variation_of_information(one[both], other[both], ignore=None)
                table[i, j] = found.total
    return table
