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

from geohue.baselines.kernels import compiled
from geohue.parallel import Workers

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
    joint = np.concatenate([values, depth[..., None], confidence[..., None]], axis=2)
    joint = np.ascontiguousarray(joint, np.float32)
    modes = np.empty((height, width, 5), np.float32)

    def work(rows: slice) -> None:
        _shift_rows(joint, weight, radius, rows.start, rows.stop, modes)

    for _ in team.map_blocks(work, height, ROWS):
        pass
    return modes


@compiled
def _shift_rows(
    joint: NDArray[np.float32],
    weight: NDArray[np.float32],
    radius: float,
    start: int,
    stop: int,
    modes: NDArray[np.float32],
) -> None:
    point = np.empty(7, np.float64)  # y, x, three values, depth, confidence
    for row in range(start, stop):
        for column in range(joint.shape[1]):
            point[0], point[1] = row, column
            for c in range(5):
                point[2 + c] = joint[row, column, c]
            for _ in range(MOST_STEPS):
                if _move(point, joint, weight, radius) < STILL * STILL:
                    break
            for c in range(5):
                modes[row, column, c] = point[2 + c]


@compiled
def _move(
    point: NDArray[np.float64],
    joint: NDArray[np.float32],
    weight: NDArray[np.float32],
    radius: float,
) -> float:
    """Move a point to the mean around it, in place; return the squared length of the move."""
    y, x, p0, p1, p2, pd, pc = point
    s = sy = sx = s0 = s1 = s2 = sd = sc = 0.0
    for i in range(max(0, int(np.ceil(y - radius))), min(joint.shape[0] - 1, int(y + radius)) + 1):
        reach = np.sqrt(max(radius * radius - (i - y) ** 2, 0.0))
        first = max(0, int(np.ceil(x - reach)))
        last = min(joint.shape[1] - 1, int(x + reach))
        for j in range(first, last + 1):
            e0, e1, e2 = joint[i, j, 0] - p0, joint[i, j, 1] - p1, joint[i, j, 2] - p2
            c = joint[i, j, 4]
            ed = joint[i, j, 3] - pd
            if e0 * e0 + e1 * e1 + e2 * e2 + pc * c * ed * ed <= 1.0:
                w = weight[i, j]
                s += w
                sy += w * i
                sx += w * j
                s0 += w * e0
                s1 += w * e1
                s2 += w * e2
                sd += w * c * ed
                sc += w * c
    if s <= 0.0:
        return 0.0
    depth_step = sd / sc if sc > 0.0 else 0.0
    point[0], point[1] = sy / s, sx / s
    point[2], point[3], point[4] = p0 + s0 / s, p1 + s1 / s, p2 + s2 / s
    point[5], point[6] = pd + depth_step, sc / s
    moved = ((sy / s - y) ** 2 + (sx / s - x) ** 2) / (radius * radius)
    return float(moved + (s0 * s0 + s1 * s1 + s2 * s2) / (s * s) + pc * depth_step * depth_step)
