"""Merging a part of a cloud as the whole cloud would be merged, as far as that can be known.

The cheapest union comes next, as in `geohue.superpoint.ward`. A region that touches points of
another part is open: what it would merge with is not known here. A region whose cheapest union is
with an open one is open too. Two regions that are cheapest for each other merge in the whole cloud
as well, whatever lies elsewhere, since a union only makes the unions around it dearer (nearly so:
the mean step along a border may fall). So borders do not follow the faces of the parts.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.compute.compiled import compiled
from geohue.merge.greedy import Links, Queue, place, remove
from geohue.superpoint.ward import SIZE, Floats, Positions, Regions, cost, linked, take_up


def merge_inside(
    regions: Regions,
    spacing: float,
    weights: Floats,
    is_open: NDArray[np.bool_],
    density: float,
) -> tuple[Positions, NDArray[np.bool_]]:
    """Merge the regions that are not open until few enough are left.

    Parameters
    ----------
    regions : Regions
        Regions and their borders; afterwards the rows that are left are those of the unions.
    spacing, weights
        As for `geohue.superpoint.ward.merge_regions`.
    is_open : (R,) bool
        Which regions touch another part; afterwards, all that wait for one.
    density : float
        How many regions may be left for each point of those that are not open.

    Returns
    -------
    merges : (M, 2) int64
        The two regions of each merge, the one whose row stays first.
    alive : (B,) bool
        Which borders are left.
    """
    n_regions, n_borders = len(regions.region), len(regions.ends)
    queue = Queue(
        np.empty(n_borders, np.int64),
        np.full(n_borders, -1, np.int64),
        np.empty(n_borders),
        np.zeros(1, np.int64),
    )
    merges = np.empty((n_regions, 2), np.int64)
    links = linked(regions.ends, n_regions)
    n = run_inside(regions, spacing, weights, links, queue, merges, is_open, density)
    return merges[:n], queue.place >= 0


@compiled
def run_inside(
    regions: Regions,
    spacing: float,
    weights: Floats,
    links: Links,
    queue: Queue,
    merges: Positions,
    is_open: NDArray[np.bool_],
    density: float,
) -> int:
    """Merge until all is open or few regions are left; return the number of merges."""
    left, points = 0, 0.0
    for i in range(is_open.size):
        if not is_open[i]:
            left += 1
            points += regions.region[i, SIZE]
    for e in range(regions.ends.shape[0]):
        place(queue, e, cost(regions, e, spacing, weights))
    n = 0
    while queue.size[0] > 0 and left > density * points:
        e = queue.heap[0]
        if queue.score[e] == np.inf:
            break
        kept, gone = regions.ends[e, 0], regions.ends[e, 1]
        if is_open[kept] or is_open[gone]:
            closed = gone if is_open[kept] else kept
            if not is_open[closed]:
                is_open[closed] = True
                left -= 1
                points -= regions.region[closed, SIZE]
            place(queue, e, np.inf)
            continue
        merges[n, 0], merges[n, 1] = kept, gone
        n += 1
        left -= 1
        remove(queue, e)
        take_up(regions, links, queue, kept, gone)
        judge_around(regions, spacing, weights, links, queue, kept)
    return n


@compiled
def judge_around(
    regions: Regions, spacing: float, weights: Floats, links: Links, queue: Queue, i: int
) -> None:
    """Give all borders of a region their costs anew."""
    half = links.first[i]
    while half >= 0:
        at = half >> 1
        if queue.place[at] >= 0:
            place(queue, at, cost(regions, at, spacing, weights))
        half = links.next[half]
