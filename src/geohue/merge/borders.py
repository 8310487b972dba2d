"""Labels of a draft for all pixels, with borders where colour and depth change."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from geohue.compute.compiled import compiled, compiled_part
from geohue.compute.parallel import Workers

Labels = NDArray[np.int32]
Floats = NDArray[np.float32]

REACH = 1
"""Steps of the draft within which a pixel may take a label."""

AROUND = 3
"""Steps of the draft whose points tell what a label looks like here."""

WIDTH = 1.5
"""Standard deviation, in steps, of the weight of these points."""

NOISE = (2.0, 2.0, 2.0, 0.01)
"""Least standard deviation of L, a, b and the logarithm of depth within a label."""

MOST = 16
"""Labels within reach that are compared."""

_ROWS = 16


def draw_borders(
    regions: Labels,
    segments: Labels,
    rows: NDArray[np.int64],
    columns: NDArray[np.int64],
    values: Floats,
    workers: Workers,
) -> Labels:
    """Give each pixel a region within reach, of the segment that explains it best.

    A segment is described by the points of the draft around the pixel that have it: the mean and
    variance of L, a, b and the logarithm of depth, weighted by distance. The pixel takes the
    segment with the highest likelihood times share of the weights, and the nearest region of it.

    Parameters
    ----------
    regions : (h, w) int32
        Fine regions of the draft, none missing.
    segments : (R,) int32
        The segment of each region.
    rows, columns : (h,) and (w,) int64
        Its rows and columns among those of the image, evenly spaced.
    values : (H, W, 4) float32
        L, a, b and the logarithm of depth; NaN where there is no depth.
    workers : Workers
        Threads to use.

    Returns
    -------
    (H, W) int32
        A region for each pixel.
    """
    labels = segments[regions]
    height, width = values.shape[:2]
    out = np.empty((height, width), np.int32)
    examples = np.ascontiguousarray(values[rows[:, None], columns])
    step = int(rows[1] - rows[0]) if len(rows) > 1 else int(np.diff(columns[:2], append=1)[0])
    near_y, near_x = _nearest(height, rows), _nearest(width, columns)
    noise = np.array(NOISE)

    def draw(block: slice) -> None:
        scratch = np.empty((MOST, 10))
        names = np.empty(MOST, np.int32)
        label_rows(
            regions, labels, examples, rows, columns, near_y, near_x, values, noise,
            max(step, 1), block.start, block.stop, names, scratch, out,
        )  # fmt: skip

    for _ in workers.map_blocks(draw, height, _ROWS):
        pass
    return out


def _nearest(n: int, kept: NDArray[np.int64]) -> NDArray[np.int64]:
    """The place in `kept`, increasing, of the one nearest to each of 0..n-1."""
    middle = (kept[1:] + kept[:-1] + 1) // 2
    return np.searchsorted(middle, np.arange(n), "right")


@compiled
def label_rows(
    regions: Labels,
    labels: Labels,
    examples: Floats,
    rows: NDArray[np.int64],
    columns: NDArray[np.int64],
    near_y: NDArray[np.int64],
    near_x: NDArray[np.int64],
    values: Floats,
    noise: NDArray[np.float64],
    step: int,
    start: int,
    stop: int,
    names: Labels,
    scratch: NDArray[np.float64],
    out: Labels,
) -> None:
    """Label the pixels of some rows."""
    for y in range(start, stop):
        for x in range(values.shape[1]):
            count = within_reach(labels, near_y[y], near_x[x], names)
            if count == 1:
                out[y, x] = regions[near_y[y], near_x[x]]
                continue
            for k in range(count):
                for c in range(10):
                    scratch[k, c] = 0.0
            describe(
                labels,
                examples,
                rows,
                columns,
                near_y[y],
                near_x[x],
                y,
                x,
                step,
                names,
                count,
                scratch,
            )
            best, most = 0, -np.inf
            for k in range(count):
                fit = log_likelihood(values, y, x, scratch, k, noise)
                if fit > most:
                    best, most = k, fit
            out[y, x] = nearest_region(
                regions, labels, rows, columns, near_y[y], near_x[x], y, x, names[best]
            )


@compiled_part
def within_reach(labels: Labels, at_y: int, at_x: int, names: Labels) -> int:
    """Write the labels around a point of the draft, its own first; return how many."""
    names[0] = labels[at_y, at_x]
    count = 1
    for y in range(max(at_y - REACH, 0), min(at_y + REACH + 1, labels.shape[0])):
        for x in range(max(at_x - REACH, 0), min(at_x + REACH + 1, labels.shape[1])):
            known = False
            for k in range(count):
                known |= names[k] == labels[y, x]
            if not known and count < MOST:
                names[count] = labels[y, x]
                count += 1
    return count


@compiled_part
def nearest_region(
    regions: Labels,
    labels: Labels,
    rows: NDArray[np.int64],
    columns: NDArray[np.int64],
    at_y: int,
    at_x: int,
    y: int,
    x: int,
    label: int,
) -> int:
    """Return the region of the nearest point of the draft within reach that has a label."""
    best, least = regions[at_y, at_x], -1
    for i in range(max(at_y - REACH, 0), min(at_y + REACH + 1, labels.shape[0])):
        for j in range(max(at_x - REACH, 0), min(at_x + REACH + 1, labels.shape[1])):
            away = (rows[i] - y) ** 2 + (columns[j] - x) ** 2
            if labels[i, j] == label and (least < 0 or away < least):
                best, least = regions[i, j], away
    return int(best)


@compiled_part
def describe(
    labels: Labels,
    examples: Floats,
    rows: NDArray[np.int64],
    columns: NDArray[np.int64],
    at_y: int,
    at_x: int,
    y: int,
    x: int,
    step: int,
    names: Labels,
    count: int,
    sums: NDArray[np.float64],
) -> None:
    """Add up weights, values and squares of each label's points around a pixel.

    Columns: the weight, four values and four squares, and the weight of those with a depth.
    """
    for i in range(max(at_y - AROUND, 0), min(at_y + AROUND + 1, labels.shape[0])):
        for j in range(max(at_x - AROUND, 0), min(at_x + AROUND + 1, labels.shape[1])):
            for k in range(count):
                if names[k] == labels[i, j]:
                    away = float((rows[i] - y) ** 2 + (columns[j] - x) ** 2) / (step * step)
                    weight = math.exp(-away / (2 * WIDTH * WIDTH))
                    sums[k, 0] += weight
                    for c in range(4):
                        value = examples[i, j, c]
                        if value == value:
                            sums[k, 1 + c] += weight * value
                            sums[k, 5 + c] += weight * value * value
                            if c == 3:
                                sums[k, 9] += weight


@compiled_part
def log_likelihood(
    values: Floats,
    y: int,
    x: int,
    sums: NDArray[np.float64],
    k: int,
    noise: NDArray[np.float64],
) -> float:
    """Logarithm of the likelihood of a pixel's values under a label, times the label's share."""
    if sums[k, 0] <= 0:
        return -np.inf
    fit = math.log(sums[k, 0])
    for c in range(4):
        n = sums[k, 9] if c == 3 else sums[k, 0]
        value = values[y, x, c]
        if n <= 0 or value != value:
            continue
        mean = sums[k, 1 + c] / n
        variance = max(sums[k, 5 + c] / n - mean * mean, 0.0) + noise[c] * noise[c]
        fit -= ((value - mean) ** 2 / variance + math.log(variance)) / 2
    return fit
