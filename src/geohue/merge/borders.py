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

_SIDE = 2 * AROUND + 1
_MOMENTS = 10
_ROWS = 4


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
    height, width = values.shape[:2]
    out = np.empty((height, width), np.int32)
    moments = _moments(values[rows[:, None], columns])
    step = int(rows[1] - rows[0]) if len(rows) > 1 else int(np.diff(columns[:2], append=1)[0])
    edges_y, weights_y = _around(height, rows, max(step, 1))
    edges_x, weights_x = _around(width, columns, max(step, 1))
    labels, noise = segments[regions], np.square(NOISE)

    def draw(block: slice) -> None:
        names, which = np.empty((2, MOST), np.int32), np.empty((2, _SIDE, _SIDE), np.int32)
        draw_cells(
            regions, labels, segments, moments, edges_y, edges_x, weights_y, weights_x, values,
            noise, block.start, block.stop, names, which, np.empty((2, MOST, _SIDE, _MOMENTS)), out,
        )  # fmt: skip

    for _ in workers.map_blocks(draw, len(rows), _ROWS):
        pass
    return out


def _moments(examples: Floats) -> Weights:
    """For each point its weight of 1, four values and their squares, and 1 where it has a depth."""
    known = np.isfinite(examples)
    values = np.where(known, examples, 0.0).astype(np.float64)
    one = np.ones((*examples.shape[:2], 1))
    return np.concatenate([one, values, values**2, known[..., 3:]], axis=-1)


def _around(n: int, kept: NDArray[np.int64], step: int) -> tuple[NDArray[np.int64], Weights]:
    """Where those of 0..n-1 begin that are nearest to each in `kept`, increasing, and weights.

    The weights, (n, 2 * `AROUND` + 1), are those of the places up to `AROUND` before and after the
    nearest.
    """
    edges = np.concatenate([[0], (kept[1:] + kept[:-1] + 1) // 2, [n]])
    near = np.repeat(np.arange(len(kept)), np.diff(edges))
    beside = near[:, None] + np.arange(-AROUND, AROUND + 1)
    inside = (beside >= 0) & (beside < len(kept))
    away = (kept[beside.clip(0, len(kept) - 1)] - np.arange(n)[:, None]) / step
    return edges, np.where(inside, np.exp(-(away**2) / (2 * WIDTH**2)), 0.0)


@compiled
def draw_cells(
    regions: Labels,
    labels: Labels,
    segments: Labels,
    moments: Weights,
    edges_y: NDArray[np.int64],
    edges_x: NDArray[np.int64],
    weights_y: Weights,
    weights_x: Weights,
    values: Floats,
    noise: Weights,
    start: int,
    stop: int,
    names: Labels,
    which: Labels,
    sums: Weights,
    out: Labels,
) -> None:
    """Label the pixels around some rows of the draft.

    What depends on the cell alone, or on the row in it, is found once for all its pixels.
    """
    for i in range(start, stop):
        for j in range(regions.shape[1]):
            n_regions = within_reach(regions, i, j, names[1])
            if n_regions > 1:
                count = within_reach(labels, i, j, names[0])
                locate(labels, i, j, AROUND, names[0], count, which[0])
                locate(regions, i, j, INSIDE, names[1], n_regions, which[1])
            for y in range(edges_y[i], edges_y[i + 1]):
                if n_regions == 1:
                    out[y, edges_x[j] : edges_x[j + 1]] = names[1, 0]
                    continue
                if count > 1:
                    add_rows(moments, i, j, weights_y[y], AROUND, count, which[0], sums[0])
                if n_regions > count:
                    add_rows(moments, i, j, weights_y[y], INSIDE, n_regions, which[1], sums[1])
                for x in range(edges_x[j], edges_x[j + 1]):
                    pixel, along = values[y, x], weights_x[x]
                    label = names[0, 0]
                    if count > 1:
                        label = likeliest(
                            pixel, sums[0], along, AROUND, names[0], count, segments, -1, noise
                        )
                    out[y, x] = likeliest(
                        pixel, sums[1], along, INSIDE, names[1], n_regions, segments, label, noise
                    )


@compiled_part
def within_reach(parts: Labels, at_y: int, at_x: int, names: Labels) -> int:
    """Write the parts around a point of the draft, its own first; return how many."""
    names[0], count = parts[at_y, at_x], 1
    for y in range(max(at_y - REACH, 0), min(at_y + REACH + 1, parts.shape[0])):
        for x in range(max(at_x - REACH, 0), min(at_x + REACH + 1, parts.shape[1])):
            known = False
            for k in range(count):
                known |= names[k] == parts[y, x]
            if not known and count < MOST:
                names[count] = parts[y, x]
                count += 1
    return count


@compiled_part
def locate(
    parts: Labels, at_y: int, at_x: int, around: int, names: Labels, count: int, which: Labels
) -> None:
    """Write the number of the part at each point around one of the draft; -1 for other parts."""
    for a in range(AROUND - around, AROUND + around + 1):
        for b in range(AROUND - around, AROUND + around + 1):
            y, x = at_y + a - AROUND, at_x + b - AROUND
            which[a, b] = -1
            if 0 <= y < parts.shape[0] and 0 <= x < parts.shape[1]:
                for k in range(count):
                    if names[k] == parts[y, x]:
                        which[a, b] = k


@compiled_part
def add_rows(
    moments: Weights,
    at_y: int,
    at_x: int,
    weights: Weights,
    around: int,
    count: int,
    which: Labels,
    sums: Weights,
) -> None:
    """Add up the moments of each part in each column of the window.

    The weight of a point is the product of one for its row and one for its column, so that for all
    pixels of a row the sums along the columns are the same.
    """
    sums[:count] = 0.0
    for a in range(AROUND - around, AROUND + around + 1):
        for b in range(AROUND - around, AROUND + around + 1):
            if which[a, b] >= 0:
                point = moments[at_y + a - AROUND, at_x + b - AROUND]
                for c in range(_MOMENTS):
                    sums[which[a, b], b, c] += weights[a] * point[c]


@compiled_part
def likeliest(
    pixel: Floats,
    sums: Weights,
    weights: Weights,
    around: int,
    names: Labels,
    count: int,
    segments: Labels,
    segment: int,
    noise: Weights,
) -> int:
    """Return the part that explains a pixel best, of equal ones the first.

    Only those of a segment count, unless it is -1.
    """
    best, most, candidates = -1, -np.inf, 0
    for k in range(count):
        candidates += segment < 0 or segments[names[k]] == segment
    for k in range(count):
        if segment >= 0 and segments[names[k]] != segment:
            continue
        best = k if best < 0 else best
        if candidates == 1:
            break
        fit = log_likelihood(pixel, sums[k], weights, around, noise)
        if fit > most:
            best, most = k, fit
    return names[best]


@compiled_part
def log_likelihood(
    pixel: Floats, sums: Weights, weights: Weights, around: int, noise: Weights
) -> float:
    """Twice the logarithm of the likelihood of a pixel's values under a part times its share."""
    n = n_depth = light = a = b = depth = light2 = a2 = b2 = depth2 = 0.0
    for at in range(AROUND - around, AROUND + around + 1):
        weight, column = weights[at], sums[at]
        n += weight * column[0]
        light += weight * column[1]
        a += weight * column[2]
        b += weight * column[3]
        depth += weight * column[4]
        light2 += weight * column[5]
        a2 += weight * column[6]
        b2 += weight * column[7]
        depth2 += weight * column[8]
        n_depth += weight * column[9]
    if n <= 0:
        return -np.inf
    # The sum of (value - mean)^2 / variance over the values as one quotient: fit / spread.
    spread, fit, part = 1.0, 0.0, 1.0 / n
    if pixel[0] == pixel[0]:
        colors = (light, light2), (a, a2), (b, b2)
        for c in range(3):
            total, squares = colors[c]
            mean = total * part
            variance = max(squares * part - mean * mean, 0.0) + noise[c]
            fit = fit * variance + (pixel[c] - mean) ** 2 * spread
            spread *= variance
    if n_depth > 0 and pixel[3] == pixel[3]:
        part = 1.0 / n_depth
        mean = depth * part
        variance = max(depth2 * part - mean * mean, 0.0) + noise[3]
        fit = fit * variance + (pixel[3] - mean) ** 2 * spread
        spread *= variance
    part = 1.0 / spread
    return math.log(n * n * part) - fit * part
