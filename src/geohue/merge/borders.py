"""Labels of a draft for all pixels, with borders where colour and depth change."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from geohue.compute.compiled import compiled, compiled_part
from geohue.compute.parallel import Workers

Labels = NDArray[np.int32]
Floats = NDArray[np.float32]
Weights = NDArray[np.float64]

REACH = 1
"""Steps of the draft within which a pixel may take a label."""

AROUND = 3
"""Steps of the draft whose points tell what a label looks like here."""

INSIDE = 2
"""The same for a region among those of its segment: the borders count less, and it is quicker."""

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
    """Give each pixel the segment within reach that explains it best, and of that the best region.

    A segment is described by the points of the draft around the pixel that have it: the mean and
    variance of L, a, b and the logarithm of depth, weighted by distance. The pixel takes the
    segment with the highest likelihood times share of the weights. Among the regions of this
    segment it chooses in the same way, so that finer levels have borders as good.

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
    near_y, weights_y = _around(height, rows, max(step, 1))
    near_x, weights_x = _around(width, columns, max(step, 1))
    noise = np.array(NOISE)

    def draw(block: slice) -> None:
        scratch = np.empty((MOST, 10))
        names = np.empty(MOST, np.int32)
        label_rows(
            regions, labels, examples, near_y, near_x, weights_y, weights_x, values, noise,
            block.start, block.stop, names, scratch, out,
        )  # fmt: skip

    for _ in workers.map_blocks(draw, height, _ROWS):
        pass
    return out


def _around(n: int, kept: NDArray[np.int64], step: int) -> tuple[NDArray[np.int64], Weights]:
    """For each of 0..n-1 the place of the nearest in `kept`, increasing, and weights around it.

    The weights, (n, 2 * `AROUND` + 1), are those of the places up to `AROUND` before and after.
    """
    middle = (kept[1:] + kept[:-1] + 1) // 2
    near = np.searchsorted(middle, np.arange(n), "right")
    beside = near[:, None] + np.arange(-AROUND, AROUND + 1)
    inside = (beside >= 0) & (beside < len(kept))
    away = (kept[beside.clip(0, len(kept) - 1)] - np.arange(n)[:, None]) / step
    return near, np.where(inside, np.exp(-(away**2) / (2 * WIDTH**2)), 0.0)


@compiled
def label_rows(
    regions: Labels,
    labels: Labels,
    examples: Floats,
    near_y: NDArray[np.int64],
    near_x: NDArray[np.int64],
    weights_y: Weights,
    weights_x: Weights,
    values: Floats,
    noise: Weights,
    start: int,
    stop: int,
    names: Labels,
    sums: Weights,
    out: Labels,
) -> None:
    """Label the pixels of some rows."""
    for y in range(start, stop):
        last, count, n_regions = -1, 0, 0
        for x in range(values.shape[1]):
            at_y, at_x = near_y[y], near_x[x]
            if at_x != last:
                last = at_x
                n_regions = within_reach(regions, regions, -1, at_y, at_x, names)
                count = within_reach(labels, labels, -1, at_y, at_x, names)
            if n_regions == 1:
                out[y, x] = regions[at_y, at_x]
                continue
            label = labels[at_y, at_x]
            if count > 1:
                within_reach(labels, labels, -1, at_y, at_x, names)
                describe(
                    labels,
                    examples,
                    at_y,
                    at_x,
                    weights_y[y],
                    weights_x[x],
                    AROUND,
                    names,
                    count,
                    sums,
                )
                label = names[likeliest(values[y, x], sums, count, noise)]
            found = within_reach(regions, labels, label, at_y, at_x, names)
            if found > 1:
                describe(
                    regions,
                    examples,
                    at_y,
                    at_x,
                    weights_y[y],
                    weights_x[x],
                    INSIDE,
                    names,
                    found,
                    sums,
                )
                out[y, x] = names[likeliest(values[y, x], sums, found, noise)]
            else:
                out[y, x] = names[0]


@compiled_part
def within_reach(
    parts: Labels, labels: Labels, label: int, at_y: int, at_x: int, names: Labels
) -> int:
    """Write the parts around a point of the draft, its own first; return how many.

    Only those of a label count, unless it is -1.
    """
    count = 0
    if label < 0 or labels[at_y, at_x] == label:
        names[0] = parts[at_y, at_x]
        count = 1
    for y in range(max(at_y - REACH, 0), min(at_y + REACH + 1, labels.shape[0])):
        for x in range(max(at_x - REACH, 0), min(at_x + REACH + 1, labels.shape[1])):
            known = label >= 0 and labels[y, x] != label
            for k in range(count):
                known |= names[k] == parts[y, x]
            if not known and count < MOST:
                names[count] = parts[y, x]
                count += 1
    return count


@compiled_part
def describe(
    parts: Labels,
    examples: Floats,
    at_y: int,
    at_x: int,
    weights_y: Weights,
    weights_x: Weights,
    around: int,
    names: Labels,
    count: int,
    sums: Weights,
) -> None:
    """Add up weights, values and squares of each part's points around a pixel.

    Columns: the weight, four values and four squares, and the weight of those with a depth.
    """
    for k in range(count):
        for c in range(10):
            sums[k, c] = 0.0
    for i in range(max(at_y - around, 0), min(at_y + around + 1, parts.shape[0])):
        for j in range(max(at_x - around, 0), min(at_x + around + 1, parts.shape[1])):
            for k in range(count):
                if names[k] == parts[i, j]:
                    weight = weights_y[i - at_y + AROUND] * weights_x[j - at_x + AROUND]
                    sums[k, 0] += weight
                    for c in range(4):
                        value = examples[i, j, c]
                        if value == value:
                            sums[k, 1 + c] += weight * value
                            sums[k, 5 + c] += weight * value * value
                            if c == 3:
                                sums[k, 9] += weight
                    break


@compiled_part
def likeliest(pixel: Floats, sums: Weights, count: int, noise: Weights) -> int:
    """Return the part, of those described, that explains a pixel best; of equal ones the first."""
    best, most = 0, -np.inf
    for k in range(count):
        fit = log_likelihood(pixel, sums, k, noise)
        if fit > most:
            best, most = k, fit
    return best


@compiled_part
def log_likelihood(pixel: Floats, sums: Weights, k: int, noise: Weights) -> float:
    """Logarithm of the likelihood of a pixel's values under a part, times the part's share."""
    if sums[k, 0] <= 0:
        return -np.inf
    fit = math.log(sums[k, 0])
    for c in range(4):
        n = sums[k, 9] if c == 3 else sums[k, 0]
        value = pixel[c]
        if n <= 0 or value != value:
            continue
        mean = sums[k, 1 + c] / n
        variance = max(sums[k, 5 + c] / n - mean * mean, 0.0) + noise[c] * noise[c]
        fit -= ((value - mean) ** 2 / variance + math.log(variance)) / 2
    return fit
