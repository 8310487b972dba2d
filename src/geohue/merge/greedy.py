"""Greedy merging: the two neighbours that most likely belong together become one, and so on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geohue.compute.compiled import compiled, compiled_part
from geohue.merge import table as t
from geohue.merge.cues import NAMES, fit_plane, measure
from geohue.merge.table import Table

APART = 1000.0
"""Score of regions that do not touch: they are merged last, the nearest first."""

Floats = NDArray[np.float64]
Positions = NDArray[np.int64]


class Queue(NamedTuple):
    """The borders as a binary heap, the one with the lowest score first.

    Attributes
    ----------
    heap, place : (B,) int64
        The borders in the order of the heap, and where each stands in it, -1 = nowhere.
    score : (B,) float64
        Below 0 for regions that belong together.
    size : (1,) int64
        Borders in the heap.
    """

    heap: Positions
    place: Positions
    score: Floats
    size: Positions


class Links(NamedTuple):
    """The borders of each region, as linked lists of half-borders 2e and 2e + 1.

    Attributes
    ----------
    first, last : (R,) int64
        Ends of each region's list, -1 = empty.
    next : (2B,) int64
        The half-border after each.
    marks : (R,) int64
        The border that a region shares with the one at hand, -1 elsewhere.
    """

    first: Positions
    last: Positions
    next: Positions
    marks: Positions


def merge_all(table: Table, weights: Floats) -> tuple[Positions, Floats]:
    """Merge regions until none has a neighbour left.

    The pair of neighbours with the lowest score, ``weights[:-1] . cues + weights[-1]``, is merged
    first; what is known of the new region is computed anew, and with it the scores of its borders.

    Parameters
    ----------
    table : Table
        Regions and borders; used up.
    weights : (16,) float64
        One for each of `geohue.merge.cues.NAMES`, and the bias.

    Returns
    -------
    merges : (M, 2) int64
        The two regions of each merge, the one whose name stays first.
    scores : (M,) float64
        The score of each merge.
    """
    n_regions, n_borders = len(table.region), len(table.ends)
    links = linked(table)
    queue = Queue(
        np.empty(n_borders, np.int64),
        np.full(n_borders, -1, np.int64),
        np.empty(n_borders),
        np.zeros(1, np.int64),
    )
    merges, scores = np.empty((n_regions, 2), np.int64), np.empty(n_regions)
    scratch = np.empty(6 + len(NAMES))
    n = run(table, weights, links, queue, merges, scores, scratch[:6], scratch[6:])
    return merges[:n], scores[:n]


def linked(table: Table) -> Links:
    """List the borders of each region."""
    n_regions, n_borders = len(table.region), len(table.ends)
    owner = table.ends.reshape(-1)
    order = np.argsort(owner, kind="stable")
    following = np.full(2 * n_borders, -1, np.int64)
    same = owner[order[1:]] == owner[order[:-1]]
    following[order[:-1][same]] = order[1:][same]
    first, last = np.full(n_regions, -1, np.int64), np.full(n_regions, -1, np.int64)
    first[owner[order[::-1]]] = order[::-1]
    last[owner[order]] = order
    return Links(first, last, following, np.full(n_regions, -1, np.int64))


@compiled
def run(
    table: Table,
    weights: Floats,
    links: Links,
    queue: Queue,
    merges: Positions,
    scores: Floats,
    scratch: Floats,
    cues: Floats,
) -> int:
    """Merge until the queue is empty; return the number of merges."""
    for i in range(table.region.shape[0]):
        fit_plane(table.region, i, scratch)
    for e in range(table.ends.shape[0]):
        place(queue, e, judge(table, weights, e, scratch, cues))
    n = 0
    while queue.size[0] > 0:
        e = queue.heap[0]
        kept, gone = table.ends[e, 0], table.ends[e, 1]
        merges[n, 0], merges[n, 1], scores[n] = kept, gone, queue.score[e]
        n += 1
        remove(queue, e)
        take_up(table, links, queue, kept, gone, e)
        fit_plane(table.region, kept, scratch)
        half = links.first[kept]
        while half >= 0:
            at = half >> 1
            if queue.place[at] >= 0:
                place(queue, at, judge(table, weights, at, scratch, cues))
            half = links.next[half]
    return n


@compiled_part
def judge(table: Table, weights: Floats, e: int, scratch: Floats, cues: Floats) -> float:
    """Return the score of a border: below 0 where its regions belong together."""
    if table.border[e, t.LENGTH] == 0:
        return APART
    measure(table, table.ends[e, 0], table.ends[e, 1], e, cues, scratch)
    score = weights[cues.size]
    for k in range(cues.size):
        score += weights[k] * cues[k]
    return float(score)


@compiled_part
def take_up(table: Table, links: Links, queue: Queue, kept: int, gone: int, e: int) -> None:
    """Add a region and its borders to another, across the border `e`, which is in no queue."""
    region, border, marks = table.region, table.border, links.marks
    for k in range(t.SUMS):
        region[kept, k] += region[gone, k]
    for k in range(table.votes.shape[1]):
        table.votes[kept, k] += table.votes[gone, k]
    region[kept, t.PERIMETER] -= 2 * border[e, t.LENGTH]
    region[kept, t.INNER_PAIRS] += border[e, t.LENGTH]
    region[kept, t.INNER_STEP] += border[e, t.STEP]
    drop_dead(links, queue, kept)
    half = links.first[kept]
    while half >= 0:
        marks[table.ends[half >> 1, 1 - (half & 1)]] = half >> 1
        half = links.next[half]
    half = links.first[gone]
    while half >= 0:
        at, following = half >> 1, links.next[half]
        if queue.place[at] >= 0:
            same = marks[table.ends[at, 1 - (half & 1)]]
            # Of two borders with one region the lower number stays: of two links, the nearer.
            if same >= 0:
                low, high = min(at, same), max(at, same)
                for k in range(border.shape[1]):
                    border[low, k] += border[high, k]
                remove(queue, high)
            if same < 0 or same > at:
                table.ends[at, half & 1] = kept
                append(links, kept, half)
        half = following
    half = links.first[kept]
    while half >= 0:
        marks[table.ends[half >> 1, 1 - (half & 1)]] = -1
        half = links.next[half]


@compiled_part
def drop_dead(links: Links, queue: Queue, region: int) -> None:
    """Leave out the borders of a region that are no longer in the queue."""
    half, before = links.first[region], -1
    links.first[region], links.last[region] = -1, -1
    while half >= 0:
        following = links.next[half]
        if queue.place[half >> 1] >= 0:
            if before < 0:
                links.first[region] = half
            else:
                links.next[before] = half
            before = half
        half = following
    if before >= 0:
        links.next[before] = -1
        links.last[region] = before


@compiled_part
def append(links: Links, region: int, half: int) -> None:
    """Put a half-border at the end of a region's list."""
    links.next[half] = -1
    if links.last[region] < 0:
        links.first[region] = half
    else:
        links.next[links.last[region]] = half
    links.last[region] = half


@compiled_part
def place(queue: Queue, e: int, score: float) -> None:
    """Put a border where its score belongs, whether it was in the queue or not."""
    at = queue.place[e]
    if at < 0:
        at = queue.size[0]
        queue.size[0] += 1
    queue.score[e] = score
    settle(queue, e, at)


@compiled_part
def remove(queue: Queue, e: int) -> None:
    """Take a border out of the queue."""
    at = queue.place[e]
    queue.place[e] = -1
    queue.size[0] -= 1
    if at < queue.size[0]:
        settle(queue, queue.heap[queue.size[0]], at)


@compiled_part
def settle(queue: Queue, e: int, at: int) -> None:
    """Put a border where it belongs, above or below the free place `at`."""
    heap, where, score = queue.heap, queue.place, queue.score
    while at > 0 and before(score, e, heap[(at - 1) >> 1]):
        heap[at] = heap[(at - 1) >> 1]
        where[heap[at]] = at
        at = (at - 1) >> 1
    while True:
        child = 2 * at + 1
        if child >= queue.size[0]:
            break
        if child + 1 < queue.size[0] and before(score, heap[child + 1], heap[child]):
            child += 1
        if not before(score, heap[child], e):
            break
        heap[at] = heap[child]
        where[heap[at]] = at
        at = child
    heap[at] = e
    where[e] = at


@compiled_part
def before(score: Floats, one: int, other: int) -> bool:
    """Whether a border comes first: by its score, equal ones by their number."""
    return bool((score[one] < score[other]) | ((score[one] == score[other]) & (one < other)))
