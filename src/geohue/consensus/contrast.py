"""Borders that can be seen: where colour or geometry changes more than beside them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from heapq import heapify, heappop, heappush

import numpy as np
from numpy.typing import NDArray

Labels = NDArray[np.int32]

PRIOR = 20
"""Pairs of the scene that count as a region's own, lest a few pairs speak for it."""


def join_faint(
    labels: Labels,
    one: NDArray[np.int64],
    other: NDArray[np.int64],
    step: NDArray[np.floating],
    share: NDArray[np.floating],
    least: float,
) -> Labels:
    """Join regions between which there is little to be seen.

    The contrast of a border is the mean step between the neighbours on its two sides, over the mean
    step between neighbours within the calmer of its two regions. Contrast times share of the votes
    says how clear a border is: one that all cuts draw may be faint, one that few draw must be
    plain. The least clear one goes first, as long as it is below `least`. Half a table may be a
    good cut by position; but nothing changes where it begins.

    Parameters
    ----------
    labels : int32 array
        Regions, -1 = none.
    one, other : (E,) int64
        Flat positions of neighbours (`adjacent_points`), all with a region.
    step : (E,) float
        How much they differ.
    share : (E,) float
        `count_votes` of each pair.
    least : float
        How clear a border must be to stay.

    Returns
    -------
    int32 array of the same shape
        Each region under the name of one of its parts.

    Examples
    --------
    >>> one = np.arange(5)
    >>> steps, share = np.array([0.1, 0.1, 2.0, 0.1, 0.1]), np.ones(5)
    >>> join_faint(np.int32([0, 0, 0, 1, 1, 2]), one, one + 1, steps, share, 2).tolist()
    [0, 0, 0, 1, 1, 1]
    """
    flat = labels.reshape(-1)
    n = int(flat.max(initial=-1)) + 1
    regions = _Regions(n, flat[one], flat[other], step, share)
    part_of = np.arange(n, dtype=np.int32)
    for kept, gone in regions.join(least):
        part_of[part_of == gone] = kept
    return np.append(part_of, np.int32(-1))[labels]


class _Regions:
    """What lies within each region and between each two of them: pairs, their steps and votes."""

    def __init__(
        self,
        n: int,
        one: Labels,
        other: Labels,
        step: NDArray[np.floating],
        share: NDArray[np.floating],
    ) -> None:
        low, high = np.minimum(one, other).astype(np.int64), np.maximum(one, other)
        cells, place = np.unique(low * n + high, return_inverse=True)
        columns = np.ones(len(one)), step, share
        sums = np.stack([np.bincount(place, column, len(cells)) for column in columns], axis=1)
        self._within = np.zeros((n, 2))
        self._around: list[dict[int, NDArray[np.float64]]] = [{} for _ in range(n)]
        for cell, values in zip(cells.tolist(), sums, strict=True):
            a, b = divmod(cell, n)
            if a == b:
                self._within[a] = values[:2]
            else:
                self._around[a][b] = self._around[b][a] = values
        pairs, steps = self._within.sum(axis=0)
        self._typical = float(steps / pairs) if pairs else None

    def join(self, least: float) -> Iterator[tuple[int, int]]:
        """Join the two regions with the least clear border; yields which took up which."""
        if self._typical is None:  # single points: nothing to compare a step with
            return
        heap = [
            (self._clear(a, b), a, b) for a, near in enumerate(self._around) for b in near if a < b
        ]
        heapify(heap)
        while heap and heap[0][0] < least:
            clear, kept, gone = heappop(heap)
            if gone not in self._around[kept] or clear != self._clear(kept, gone):
                continue  # one of the two has changed since
            self._take_up(kept, gone)
            yield kept, gone
            for near in self._around[kept]:
                a, b = min(kept, near), max(kept, near)
                heappush(heap, (self._clear(a, b), a, b))

    def _clear(self, a: int, b: int) -> float:
        """Contrast times votes of a border."""
        pairs, steps, votes = self._around[a][b]
        if steps == 0:
            return 0.0
        calm = min(self._calm(a), self._calm(b))
        return float(steps * votes / pairs**2 / calm) if calm > 0 else math.inf

    def _calm(self, region: int) -> float:
        """The mean step within a region, with a few pairs of the scene among its own."""
        pairs, steps = self._within[region]
        return float((steps + PRIOR * (self._typical or 0.0)) / (pairs + PRIOR))

    def _take_up(self, kept: int, gone: int) -> None:
        self._within[kept] += self._within[gone] + self._around[kept].pop(gone)[:2]
        for near, values in self._around[gone].items():
            if near != kept:
                del self._around[near][gone]
                known = self._around[kept].get(near)
                total = values if known is None else known + values
                self._around[kept][near] = self._around[near][kept] = total
        self._around[gone] = {}
