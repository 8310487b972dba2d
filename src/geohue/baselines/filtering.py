"""The mean shift filter in the joint domain of image plane, colour and depth.

Each pixel starts where it is and moves to the mean of the pixels that lie within a spatial
bandwidth in the image and a range bandwidth in its values, until it moves no more; it keeps the
values it ends with. The kernel is flat in both domains (Comaniciu and Meer 2002, Sec. 4.1), and
every pixel takes part in the means with a weight of its own: one minus the strength of the edge
it lies on (Christoudias, Georgescu and Meer 2002).

Depth is one more value with a confidence c in 0..1 for each pixel: it adds
``c_point * c_pixel * (D_point - D_pixel)^2`` to the squared distance, and enters the mean with
the weight c_pixel. A pixel without depth has c = 0: it goes by place and colour and takes on the
depth, and the confidence in it, of the pixels like it around it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.baselines.kernels import compiled, compiled_part, vectorised_part
from geohue.compute.parallel import Workers

MOST_STEPS = 100
"""Most moves of a pixel, as in EDISON."""

STILL = 0.01
"""A pixel rests when it moves less than this share of the bandwidths, as in EDISON."""

ROWS = 8
"""Image rows that one thread takes at a time."""


def shift_filter(
    values: NDArray[np.float32],
    depth: NDArray[np.float32],
    confidence: NDArray[np.float32],
    weight: NDArray[np.float32],
    radius: float,
    team: Workers,
) -> NDArray[np.float32]:
    """Move every pixel to its mode.

    Parameters
    ----------
    values : (H, W, 3) float32
        In units of their bandwidth; finite everywhere.
    depth : (H, W) float32
        In units of its bandwidth; finite everywhere.
    confidence : (H, W) float32
        Of the depth, 0 to 1; all zero for a filter without depth.
    weight : (H, W) float32
        Of each pixel in the means, 0 to 1; a pixel of weight 0 is in no mean, not even its own.
    radius : float
        Spatial bandwidth, pixels.
    team : Workers
        Threads.

    Returns
    -------
    (H, W, 5) float32
        The three values, the depth and its confidence where each pixel ends.
    """
    height, width = depth.shape
    planes = tuple(
        np.ascontiguousarray(plane, np.float32)
        for plane in (*np.moveaxis(values, 2, 0), depth, confidence, weight)
    )
    modes = np.empty((height, width, 5), np.float32)

    def work(rows: slice) -> None:
        _shift_rows(planes, radius, rows.start, rows.stop, modes)

    for _ in team.map_blocks(work, height, ROWS):
        pass
    return modes


@compiled
def _shift_rows(
    planes: tuple[NDArray[np.float32], ...],
    radius: float,
    start: int,
    stop: int,
    modes: NDArray[np.float32],
) -> None:
    point = np.empty(7, np.float64)  # y, x, three values, depth, confidence
    for row in range(start, stop):
        for column in range(modes.shape[1]):
            point[0], point[1] = row, column
            for c in range(5):
                point[2 + c] = planes[c][row, column]
            for _ in range(MOST_STEPS):
                if _move(point, planes, radius) < STILL * STILL:
                    break
            for c in range(5):
                modes[row, column, c] = point[2 + c]


@compiled_part
def _move(
    point: NDArray[np.float64], planes: tuple[NDArray[np.float32], ...], radius: float
) -> float:
    """Move a point to the mean around it, in place; return the squared length of the move."""
    height, width = planes[0].shape
    y, x = point[0], point[1]
    here = point.astype(np.float32)
    sums = np.zeros(8, np.float64)
    for i in range(max(0, int(np.ceil(y - radius))), min(height - 1, int(y + radius)) + 1):
        reach = np.sqrt(max(radius * radius - (i - y) ** 2, 0.0))
        first, last = max(0, int(np.ceil(x - reach))), min(width - 1, int(x + reach))
        _add_row(planes, here, i, first, last + 1, sums)
    total, confident = sums[0], sums[7]
    if total <= 0.0:
        return 0.0
    depth_step = sums[6] / confident if confident > 0.0 else 0.0
    point[0], point[1] = sums[1] / total, sums[2] / total
    moved = ((point[0] - y) ** 2 + (point[1] - x) ** 2) / (radius * radius)
    moved += point[6] * depth_step * depth_step
    for c in range(3):
        step = sums[3 + c] / total
        point[2 + c] += step
        moved += step * step
    point[5] += depth_step
    point[6] = confident / total
    return float(moved)


@vectorised_part
def _add_row(
    planes: tuple[NDArray[np.float32], ...],
    here: NDArray[np.float32],
    row: int,
    first: int,
    stop: int,
    sums: NDArray[np.float64],
) -> None:
    """Add the pixels of one image row that are like the point: weight, y, x, values, depth, c."""
    p0, p1, p2, pd, pc = here[2], here[3], here[4], here[5], here[6]
    v0, v1, v2 = planes[0][row, first:stop], planes[1][row, first:stop], planes[2][row, first:stop]
    vd, vc, weight = (
        planes[3][row, first:stop],
        planes[4][row, first:stop],
        planes[5][row, first:stop],
    )
    zero = np.float32(0)
    s = sx = s0 = s1 = s2 = sd = sc = zero
    for j in range(stop - first):
        e0, e1, e2, ed, c = v0[j] - p0, v1[j] - p1, v2[j] - p2, vd[j] - pd, vc[j]
        own = weight[j]
        near = e0 * e0 + e1 * e1 + e2 * e2 + pc * c * ed * ed <= np.float32(1)
        w = own if near else zero
        s += w
        sx += w * np.float32(j)
        s0 += w * e0
        s1 += w * e1
        s2 += w * e2
        sd += w * c * ed
        sc += w * c
    sums[0] += s
    sums[1] += np.float64(s) * row
    sums[2] += np.float64(sx) + np.float64(s) * first
    sums[3] += s0
    sums[4] += s1
    sums[5] += s2
    sums[6] += sd
    sums[7] += sc
