"""Labels of a draft for all pixels of a frame, in about a tenth of the time of `draw_borders`.

The rule is that of `geohue.merge.borders`, with what each label looks like found once for a cell
of the draft instead of for each pixel, and colours of 8 bits.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from geohue.compute.compiled import compiled
from geohue.compute.parallel import Workers
from geohue.merge.borders import AROUND, MOST, NOISE, WIDTH, within_reach
from geohue.scene import Scene

Labels = NDArray[np.int32]

_SIDE = 2 * AROUND + 1
_ROWS = 4


def lab8(colors: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Convert sRGB to CIELab in 8 bits: L times 2.55, a and b plus 128.

    Parameters
    ----------
    colors : (..., 3) uint8

    Returns
    -------
    (..., 3) uint8

    Examples
    --------
    >>> lab8(np.array([[255, 255, 255]], np.uint8)).tolist()
    [[255, 128, 128]]
    """
    import cv2

    flat = np.ascontiguousarray(colors).reshape(1, -1, 3)
    return np.asarray(cv2.cvtColor(flat, cv2.COLOR_RGB2Lab), np.uint8).reshape(colors.shape)


def carry_borders(
    labels: Labels, positions: NDArray[np.int64], scene: Scene, workers: Workers
) -> Labels:
    """Give each pixel a label of the draft around it, with borders where colour and depth change.

    A pixel without depth goes by its colour.

    Parameters
    ----------
    labels : (h, w) int32
        Labels of the draft, none missing.
    positions : (h, w) int64
        Its places in the scene (`Scene.thinning`).
    scene : Scene
        The frame.
    workers : Workers
        Threads to use; the labels do not depend on them.

    Returns
    -------
    (H, W) int32
    """
    height, width = scene.shape
    rows, columns = positions[:, 0] // width, positions[0] % width
    depth = scene.points[..., 2] if scene.depth is None else scene.depth
    out = np.empty((height, width), np.int32)
    here = lab8(scene.colors)
    examples = np.empty((*labels.shape, 4))
    examples[..., 0] = here[rows[:, None], columns, 0] / 2.55
    examples[..., 1:3] = here[rows[:, None], columns, 1:] - 128.0
    with np.errstate(invalid="ignore", divide="ignore"):
        examples[..., 3] = np.log(depth[rows[:, None], columns])
    edges_y, edges_x = _edges(height, rows), _edges(width, columns)
    step = int(rows[1] - rows[0]) if len(rows) > 1 else int(np.diff(columns[:2], append=1)[0])
    noise = np.array(NOISE)

    def draw(block: slice) -> None:
        names, which = np.empty(MOST, np.int32), np.empty((_SIDE, _SIDE), np.int32)
        sums, model = np.empty((MOST, 10)), np.empty((MOST, 9))
        across, along = np.empty((MOST, _SIDE)), np.empty(_SIDE)
        draw_cells(
            labels, examples, here, depth, rows, columns, edges_y, edges_x, max(step, 1), noise,
            block.start, block.stop, names, which, sums, model, across, along, out,
        )  # fmt: skip

    for _ in workers.map_blocks(draw, len(rows), _ROWS):
        pass
    return out


def _edges(n: int, kept: NDArray[np.int64]) -> NDArray[np.int64]:
    """Where the pixels begin that are nearest to each place kept, and the end."""
    return np.concatenate([[0], (kept[1:] + kept[:-1] + 1) // 2, [n]])


@compiled
def draw_cells(
    labels: Labels,
    examples: NDArray[np.float64],
    lab: NDArray[np.uint8],
    depth: NDArray[np.float32],
    rows: NDArray[np.int64],
    columns: NDArray[np.int64],
    edges_y: NDArray[np.int64],
    edges_x: NDArray[np.int64],
    step: int,
    noise: NDArray[np.float64],
    start: int,
    stop: int,
    names: Labels,
    which: Labels,
    sums: NDArray[np.float64],
    model: NDArray[np.float64],
    across: NDArray[np.float64],
    along: NDArray[np.float64],
    out: Labels,
) -> None:
    """Label the pixels around some rows of the draft."""
    for i in range(start, stop):
        for j in range(labels.shape[1]):
            top, end, left, right = edges_y[i], edges_y[i + 1], edges_x[j], edges_x[j + 1]
            count = within_reach(labels, i, j, names)
            if count == 1:
                for y in range(top, end):
                    for x in range(left, right):
                        out[y, x] = names[0]
                continue
            describe_cell(labels, examples, i, j, names, count, noise, which, sums, model)
            for y in range(top, end):
                draw_row(
                    lab, depth, y, left, right, y - rows[i], columns[j], step,
                    names, count, which, model, across, along, out,
                )  # fmt: skip


@compiled
def describe_cell(
    labels: Labels,
    examples: NDArray[np.float64],
    i: int,
    j: int,
    names: Labels,
    count: int,
    noise: NDArray[np.float64],
    which: Labels,
    sums: NDArray[np.float64],
    model: NDArray[np.float64],
) -> None:
    """Find what each label looks like around a point of the draft.

    `which` gets the label's number at each place of the window, -1 for another label; `model` the
    means of four values, their inverse variances, and half the sum of the variances' logarithms,
    that of depth left out where no point of the label has one (the inverse variance is then 0).
    """
    for k in range(count):
        for c in range(10):
            sums[k, c] = 0.0
    for a in range(_SIDE):
        for b in range(_SIDE):
            y, x = i + a - AROUND, j + b - AROUND
            which[a, b] = -1
            if 0 <= y < labels.shape[0] and 0 <= x < labels.shape[1]:
                for k in range(count):
                    if names[k] == labels[y, x]:
                        which[a, b] = k
                        away = float((a - AROUND) ** 2 + (b - AROUND) ** 2)
                        add_example(examples, y, x, math.exp(-away / (2 * WIDTH * WIDTH)), k, sums)
    finish(sums, count, noise, model)


@compiled
def finish(
    sums: NDArray[np.float64], count: int, noise: NDArray[np.float64], model: NDArray[np.float64]
) -> None:
    """Turn sums into means, inverse variances and logarithms."""
    for k in range(count):
        model[k, 8] = 0.0
        for c in range(4):
            n = sums[k, 9] if c == 3 else sums[k, 8]
            model[k, c], model[k, 4 + c] = 0.0, 0.0
            if n > 0:
                mean = sums[k, c] / n
                variance = max(sums[k, 4 + c] / n - mean * mean, 0.0) + noise[c] * noise[c]
                model[k, c], model[k, 4 + c] = mean, 1 / variance
                model[k, 8] += math.log(variance) / 2 if c < 3 else 0.0


@compiled
def add_example(
    examples: NDArray[np.float64],
    y: int,
    x: int,
    weight: float,
    k: int,
    sums: NDArray[np.float64],
) -> None:
    """Add a point of the draft to its label: values, squares, and weights with and of depth."""
    sums[k, 8] += weight
    for c in range(4):
        value = examples[y, x, c]
        if value == value:
            sums[k, c] += weight * value
            sums[k, 4 + c] += weight * value * value
            sums[k, 9] += weight if c == 3 else 0.0


@compiled
def draw_row(
    lab: NDArray[np.uint8],
    depth: NDArray[np.float32],
    y: int,
    left: int,
    right: int,
    down: int,
    column: int,
    step: int,
    names: Labels,
    count: int,
    which: Labels,
    model: NDArray[np.float64],
    across: NDArray[np.float64],
    along: NDArray[np.float64],
    out: Labels,
) -> None:
    """Label the pixels of one row of a cell.

    The weights of the points around a pixel are products of one along the rows and one along the
    columns, so those along the columns of the window are added up once for the row.
    """
    add_rows(which, count, down, step, across)
    for x in range(left, right):
        for b in range(_SIDE):
            along[b] = weight_at(b, x - column, step)
        best, most = 0, -math.inf
        for k in range(count):
            share = 0.0
            for b in range(_SIDE):
                share += across[k, b] * along[b]
            fit = math.log(share) + log_likeness(lab, depth, y, x, k, model)
            if fit > most:
                best, most = k, fit
        out[y, x] = names[best]


@compiled
def add_rows(which: Labels, count: int, down: int, step: int, across: NDArray[np.float64]) -> None:
    """Add up the weights along the rows of the window: each label's in each column."""
    for k in range(count):
        for b in range(_SIDE):
            across[k, b] = 0.0
    for a in range(_SIDE):
        weight = weight_at(a, down, step)
        for b in range(_SIDE):
            if which[a, b] >= 0:
                across[which[a, b], b] += weight


@compiled
def weight_at(place: int, off: int, step: int) -> float:
    """The weight of a row or column of the window for a pixel that lies so far from its middle."""
    away = (place - AROUND) - off / step
    return math.exp(-away * away / (2 * WIDTH * WIDTH))


@compiled
def log_likeness(
    lab: NDArray[np.uint8],
    depth: NDArray[np.float32],
    y: int,
    x: int,
    k: int,
    model: NDArray[np.float64],
) -> float:
    """Logarithm of the likelihood of a pixel's colour and depth under a label."""
    fit = (lab[y, x, 0] / 2.55 - model[k, 0]) ** 2 * model[k, 4]
    fit += (lab[y, x, 1] - 128.0 - model[k, 1]) ** 2 * model[k, 5]
    fit += (lab[y, x, 2] - 128.0 - model[k, 2]) ** 2 * model[k, 6]
    if depth[y, x] > 0 and model[k, 7] > 0:
        away = math.log(depth[y, x]) - model[k, 3]
        fit += away * away * model[k, 7] - math.log(model[k, 7])
    return float(-fit / 2 - model[k, 8])
