"""The borders of a carried frame, in plain loops over pixels."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from geohue.merge.borders import AROUND, NOISE, REACH, WIDTH
from geohue.scene import Scene
from geohue.video.borders import lab8

Labels = NDArray[np.int32]


def carry_borders(labels: Labels, positions: NDArray[np.int64], scene: Scene) -> Labels:
    """Each pixel takes the most likely label of the cell of the draft that it lies in."""
    height, width = scene.shape
    rows, columns = positions[:, 0] // width, positions[0] % width
    step = int(rows[1] - rows[0])
    lab = lab8(scene.colors).astype(float) / (2.55, 1, 1) - (0, 128, 128)
    with np.errstate(invalid="ignore"):
        values = np.dstack([lab, np.log(scene.depth)])  # type: ignore[arg-type]
    out = np.empty((height, width), np.int32)
    for y in range(height):
        for x in range(width):
            # Of two points of the draft as near, the later one.
            i = len(rows) - 1 - int(np.abs(rows - y)[::-1].argmin())
            j = len(columns) - 1 - int(np.abs(columns - x)[::-1].argmin())
            out[y, x] = _best(labels, values, rows, columns, i, j, y, x, step)
    return out


def _window(labels: Labels, i: int, j: int, reach: int) -> list[tuple[int, int]]:
    return [
        (a, b)
        for a in range(max(i - reach, 0), min(i + reach + 1, labels.shape[0]))
        for b in range(max(j - reach, 0), min(j + reach + 1, labels.shape[1]))
    ]


def _best(
    labels: Labels,
    values: NDArray[np.float64],
    rows: NDArray[np.int64],
    columns: NDArray[np.int64],
    i: int,
    j: int,
    y: int,
    x: int,
    step: int,
) -> int:
    names = {int(labels[i, j]): None} | {int(labels[p]): None for p in _window(labels, i, j, REACH)}
    fits = {}
    for name in names:
        members = [p for p in _window(labels, i, j, AROUND) if labels[p] == name]
        fit = math.log(
            sum(
                math.exp(
                    -((a + (rows[i] - y) / step - i) ** 2 + (b + (columns[j] - x) / step - j) ** 2)
                    / (2 * WIDTH**2)
                )
                for a, b in members
            )
        )
        for c in range(4):
            there = [
                (values[rows[a], columns[b], c], math.exp(-((a - i) ** 2 + (b - j) ** 2) / 4.5))
                for a, b in members
                if not np.isnan(values[rows[a], columns[b], c])
            ]
            if not there or np.isnan(values[y, x, c]):
                continue
            v, w = np.array(there).T
            mean = (v * w).sum() / w.sum()
            variance = max((v * v * w).sum() / w.sum() - mean**2, 0) + NOISE[c] ** 2
            fit -= ((values[y, x, c] - mean) ** 2 / variance + math.log(variance)) / 2
        fits[name] = fit
    return max(fits, key=fits.__getitem__)
