"""Samples for the constants of the merging: whether merging a pair of regions helps.

Help is a fall of the variation of information from the reference labels. The states that samples
come from are those on the way of random correct merges and those that the merging itself goes
through with the constants it has so far.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geohue.compute.compiled import compiled
from geohue.merge.cues import NAMES, fit_plane, measure
from geohue.merge.greedy import Links, Queue, linked, place, remove, take_up
from geohue.merge.table import Table

Floats = NDArray[np.float64]

MOST = 40_000
"""Samples of one frame."""


class Log(NamedTuple):
    """Samples so far: the cues and the change of the variation of information, and how many."""

    cues: Floats
    change: Floats
    size: NDArray[np.int64]


def collect(
    table: Table, truth: Floats, weights: Floats | None, seed: int
) -> tuple[Floats, Floats]:
    """Merge one frame, and return the cues and the change (bits) of each pair that was looked at.

    Parameters
    ----------
    table : Table
        Regions and borders; used up.
    truth : (R, G) float64
        Points of each region in each segment of the reference; those without a label left out.
    weights : (16,) float64 or None
        Constants to merge by, below 0; None for random merges that help.
    seed : int
        The source of chance.

    Returns
    -------
    cues : (S, 15) float64
    change : (S,) float64
    """
    n_borders = len(table.ends)
    queue = Queue(
        np.empty(n_borders, np.int64),
        np.full(n_borders, -1, np.int64),
        np.empty(n_borders),
        np.zeros(1, np.int64),
    )
    log = Log(np.empty((MOST, len(NAMES))), np.empty(MOST), np.zeros(1, np.int64))
    scratch = np.empty(6 + len(NAMES))
    by = np.zeros(len(NAMES) + 1) if weights is None else weights
    chance = np.random.default_rng(seed).random(40 * n_borders + 1)
    run(
        table,
        truth,
        by,
        chance if weights is None else chance[:0],
        linked(table),
        queue,
        log,
        scratch,
    )
    n = log.size[0]
    return log.cues[:n], log.change[:n]


@compiled
def run(
    table: Table,
    truth: Floats,
    weights: Floats,
    chance: Floats,
    links: Links,
    queue: Queue,
    log: Log,
    scratch: Floats,
) -> None:
    """Merge until no pair is left that should be merged."""
    total, drawn = 0.0, 0
    for i in range(table.region.shape[0]):
        fit_plane(table.region, i, scratch)
        for g in range(truth.shape[1]):
            total += truth[i, g]
    for e in range(table.ends.shape[0]):
        drawn += 1
        place(queue, e, look(table, truth, total, weights, chance, drawn, e, log, scratch))
    while queue.size[0] > 0 and queue.score[queue.heap[0]] < 0:
        e = queue.heap[0]
        kept, gone = table.ends[e, 0], table.ends[e, 1]
        remove(queue, e)
        take_up(table, links, queue, kept, gone, e)
        for g in range(truth.shape[1]):
            truth[kept, g] += truth[gone, g]
        fit_plane(table.region, kept, scratch)
        half = links.first[kept]
        while half >= 0:
            at = half >> 1
            if queue.place[at] >= 0:
                drawn += 1
                place(
                    queue, at, look(table, truth, total, weights, chance, drawn, at, log, scratch)
                )
            half = links.next[half]


@compiled
def look(
    table: Table,
    truth: Floats,
    total: float,
    weights: Floats,
    chance: Floats,
    drawn: int,
    e: int,
    log: Log,
    scratch: Floats,
) -> float:
    """Log a pair, and return its score: at random below 0 where it helps, or by the constants."""
    i, j = table.ends[e, 0], table.ends[e, 1]
    n = min(log.size[0], log.change.size - 1)
    measure(table, i, j, e, log.cues[n], scratch)
    change = change_of_voi(truth, i, j, total)
    score = weights[weights.size - 1]
    for k in range(weights.size - 1):
        score += weights[k] * log.cues[n, k]
    log.change[n] = change
    if change != 0.0:
        log.size[0] = n + 1
    if chance.size > 0:
        return chance[drawn % chance.size] - 1.0 if change < 0 else np.inf
    return float(score)


@compiled
def change_of_voi(truth: Floats, i: int, j: int, total: float) -> float:
    """By how many bits merging two regions changes the variation of information."""
    joint, a, b = 0.0, 0.0, 0.0
    for g in range(truth.shape[1]):
        p, q = truth[i, g], truth[j, g]
        a += p
        b += q
        if p > 0 and q > 0:
            joint += p * np.log2(p) + q * np.log2(q) - (p + q) * np.log2(p + q)
    if a == 0 or b == 0:
        return 0.0
    alone = a * np.log2(a) + b * np.log2(b) - (a + b) * np.log2(a + b)
    return float((2 * joint - alone) / total)
