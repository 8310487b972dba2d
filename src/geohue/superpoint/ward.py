"""Fine regions merged two by two, those first whose union costs least."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geohue.compute.compiled import compiled
from geohue.merge.greedy import Links, Queue, append, drop_dead, place, remove

Floats = NDArray[np.float64]
Positions = NDArray[np.int64]

# Columns of a region: sums over its points.
SIZE, LAB, PLANE, POSITION = 0, 1, 4, 10
COLUMNS = 13

# Columns of a border: sums over its pairs.
LENGTH, STEP = 0, 1

# Places of the weights.
COLOR, TURN, SAME, LONG, EDGE, POWER = 0, 1, 2, 3, 4, 5


class Regions(NamedTuple):
    """Regions and borders, as the compiled loop takes them; used up by it.

    Attributes
    ----------
    region : (R, 13) float64
        Sums of 1, Lab, the products n n^T of normals (xx, xy, xz, yy, yz, zz) and the positions.
    border : (B, 2) float64
        Pairs of points across it, and the sum of their steps.
    ends : (B, 2) int64
        Its two regions.
    """

    region: Floats
    border: Floats
    ends: Positions


def merge_regions(regions: Regions, spacing: float, weights: Floats) -> tuple[Positions, Floats]:
    """Merge neighbours until none are left, the cheapest first.

    Returns
    -------
    merges : (M, 2) int64
        As in `MergeTree`.
    costs : (M,) float64
        The cost of each.
    """
    n_regions, n_borders = len(regions.region), len(regions.ends)
    links = linked(regions.ends, n_regions)
    queue = Queue(
        np.empty(n_borders, np.int64),
        np.full(n_borders, -1, np.int64),
        np.empty(n_borders),
        np.zeros(1, np.int64),
    )
    merges, costs = np.empty((n_regions, 2), np.int64), np.empty(n_regions)
    n = run(regions, spacing, weights, links, queue, merges, costs)
    return merges[:n], costs[:n]


def linked(ends: Positions, n_regions: int) -> Links:
    """List the borders of each region."""
    n = 2 * len(ends)
    links = Links(
        np.full(n_regions, -1, np.int64),
        np.full(n_regions, -1, np.int64),
        np.full(n, -1, np.int64),
        np.full(n_regions, -1, np.int64),
    )
    link_all(links, ends)
    return links


@compiled
def link_all(links: Links, ends: Positions) -> None:
    """List the borders of each region."""
    for e in range(ends.shape[0]):
        append(links, ends[e, 0], 2 * e)
        append(links, ends[e, 1], 2 * e + 1)


@compiled
def run(
    regions: Regions,
    spacing: float,
    weights: Floats,
    links: Links,
    queue: Queue,
    merges: Positions,
    costs: Floats,
) -> int:
    """Merge until the queue is empty; return the number of merges."""
    for e in range(regions.ends.shape[0]):
        place(queue, e, cost(regions, e, spacing, weights))
    n = 0
    while queue.size[0] > 0:
        e = queue.heap[0]
        kept, gone = regions.ends[e, 0], regions.ends[e, 1]
        merges[n, 0], merges[n, 1], costs[n] = kept, gone, queue.score[e]
        n += 1
        remove(queue, e)
        take_up(regions, links, queue, kept, gone)
        half = links.first[kept]
        while half >= 0:
            at = half >> 1
            if queue.place[at] >= 0:
                place(queue, at, cost(regions, at, spacing, weights))
            half = links.next[half]
    return n


@compiled
def cost(regions: Regions, e: int, spacing: float, weights: Floats) -> float:
    """What the union of the two regions of a border costs."""
    region = regions.region
    i, j = regions.ends[e, 0], regions.ends[e, 1]
    n, m = region[i, SIZE], region[j, SIZE]
    color, turn, away = 0.0, 0.0, 0.0
    for c in range(LAB, LAB + 3):
        color += (region[i, c] / n - region[j, c] / m) ** 2
    for c in range(PLANE, PLANE + 6):
        once = (region[i, c] / n - region[j, c] / m) ** 2
        # Off the diagonal each product stands for two entries of the matrix.
        turn += once if c in (PLANE, PLANE + 3, PLANE + 5) else 2 * once
    for c in range(POSITION, POSITION + 3):
        away += (region[i, c] / n - region[j, c] / m) ** 2
    long = away / (spacing * spacing * (n + m))
    step = regions.border[e, STEP] / regions.border[e, LENGTH]
    unlike = weights[COLOR] * color + weights[TURN] * turn + weights[SAME] + weights[LONG] * long
    return float((n * m / (n + m)) ** weights[POWER] * unlike * (weights[EDGE] + step))


@compiled
def take_up(regions: Regions, links: Links, queue: Queue, kept: int, gone: int) -> None:
    """Add a region and its borders to another."""
    region, border, ends, marks = regions.region, regions.border, regions.ends, links.marks
    for c in range(COLUMNS):
        region[kept, c] += region[gone, c]
    drop_dead(links, queue, kept)
    half = links.first[kept]
    while half >= 0:
        marks[ends[half >> 1, 1 - (half & 1)]] = half >> 1
        half = links.next[half]
    half = links.first[gone]
    while half >= 0:
        at, following = half >> 1, links.next[half]
        if queue.place[at] >= 0:
            same = marks[ends[at, 1 - (half & 1)]]
            if same >= 0:
                for c in range(border.shape[1]):
                    border[same, c] += border[at, c]
                remove(queue, at)
            else:
                ends[at, half & 1] = kept
                append(links, kept, half)
        half = following
    half = links.first[kept]
    while half >= 0:
        marks[ends[half >> 1, 1 - (half & 1)]] = -1
        half = links.next[half]


def tabulate(
    labels: NDArray[np.int32],
    n: int,
    points: Floats,
    lab: Floats,
    normals: Floats,
    weight: Floats,
    one: Positions,
    other: Positions,
    step: Floats,
) -> Regions:
    """Sum up what is known of n regions and of the borders between them."""
    region = np.zeros((n, COLUMNS))
    add_up(labels, points, lab, normals, weight, region)
    a, b = labels[one].astype(np.int64), labels[other].astype(np.int64)
    apart = np.flatnonzero(a != b)
    a, b, step = a[apart], b[apart], step[apart]
    keys = np.minimum(a, b) * n + np.maximum(a, b)
    order = np.argsort(keys, kind="stable")
    keys, step = keys[order], step[order]
    starts = np.flatnonzero(np.append(True, keys[1:] != keys[:-1])) if len(keys) else order
    length = np.diff(np.append(starts, len(keys))).astype(np.float64)
    total = np.add.reduceat(step, starts) if len(keys) else step
    ends = np.stack([keys[starts] // n, keys[starts] % n], axis=1)
    return Regions(region, np.ascontiguousarray(np.stack([length, total], axis=1)), ends)


@compiled
def add_up(
    labels: NDArray[np.int32],
    points: Floats,
    lab: Floats,
    normals: Floats,
    weight: Floats,
    region: Floats,
) -> None:
    """Add up the columns of the regions over their points."""
    for i in range(labels.size):
        r, w = labels[i], weight[i]
        region[r, SIZE] += w
        x, y, z = normals[i, 0], normals[i, 1], normals[i, 2]
        for c in range(3):
            region[r, LAB + c] += w * lab[i, c]
            region[r, POSITION + c] += w * points[i, c]
        region[r, PLANE] += w * x * x
        region[r, PLANE + 1] += w * x * y
        region[r, PLANE + 2] += w * x * z
        region[r, PLANE + 3] += w * y * y
        region[r, PLANE + 4] += w * y * z
        region[r, PLANE + 5] += w * z * z
