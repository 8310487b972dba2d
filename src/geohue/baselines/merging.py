"""Region merging by statistics: which neighbours are most likely of one distribution.

The region model is that of Calderero and Marques: values that are independent and identically
distributed, with any distribution, hence a histogram for each channel. Merging regions with n1
and n2 observations and distributions P1 and P2 into P = (n1 P1 + n2 P2) / (n1 + n2) costs

- ``n1 KL(P1 | P) + n2 KL(P2 | P)``: the loss of log-likelihood (criterion "kl"), or
- ``-n1 log BC(P1, P) - n2 log BC(P2, P)``, BC the Bhattacharyya coefficient ("bhattacharyya"),

summed over the channels. The cheapest pair of neighbours merges first.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from geohue.baselines.kernels import compiled, compiled_part, find_root, flatten, join_roots

Criterion = Literal["kl", "bhattacharyya"]


def soft_histograms(
    values: NDArray[np.float32],
    regions: NDArray[np.int32],
    n_regions: int,
    bins: int,
) -> NDArray[np.float64]:
    """Count the values of each region, each value shared by the two bins that it lies between.

    Parameters
    ----------
    values : (M, C) float32
        Channels; each is spread over the bins from its least to its greatest value.
    regions : (M,) int32
    n_regions, bins : int

    Returns
    -------
    (n_regions, C, bins) float64
        Counts.

    Examples
    --------
    >>> values = np.array([[0.0], [0.25], [1.0]], np.float32)
    >>> soft_histograms(values, np.array([0, 0, 1], np.int32), 2, 3)[:, 0].tolist()
    [[1.5, 0.5, 0.0], [0.0, 0.0, 1.0]]
    """
    counts = np.zeros((n_regions, values.shape[1], bins))
    for channel, column in enumerate(values.T):
        if len(column) == 0:
            continue
        low, high = float(column.min()), float(column.max())
        place = (column.astype(np.float64) - low) / ((high - low) or 1.0) * (bins - 1)
        lower = np.minimum(place.astype(np.int64), bins - 2)
        share = place - lower
        for part, weight in ((lower, 1 - share), (lower + 1, share)):
            flat = np.bincount(regions * bins + part, weight, n_regions * bins)
            counts[:, channel] += flat.reshape(n_regions, bins)
    return counts


def merge_costs(
    counts: NDArray[np.float64], pairs: NDArray[np.int32], criterion: Criterion = "kl"
) -> NDArray[np.float64]:
    """Return the cost of merging each pair of regions.

    Parameters
    ----------
    counts : (R, C, B) float
        Histograms; a region without observations merges at no cost.
    pairs : (E, 2) int32
    criterion : {"kl", "bhattacharyya"}

    Returns
    -------
    (E,) float64

    Examples
    --------
    >>> counts = np.array([[[1.0, 0.0]], [[0.0, 1.0]], [[2.0, 0.0]]])
    >>> merge_costs(counts, np.array([[0, 1], [0, 2]], np.int32)).round(4).tolist()
    [1.3863, 0.0]
    """
    return _costs(counts.astype(np.float64), pairs, criterion == "kl")


def merge_regions(
    counts: NDArray[np.float64],
    pairs: NDArray[np.int32],
    target: int,
    criterion: Criterion = "kl",
) -> NDArray[np.int32]:
    """Merge the cheapest neighbours until `target` regions are left, or no neighbours.

    Parameters
    ----------
    counts : (R, C, B) float
        Histograms of the regions.
    pairs : (E, 2) int32
        Neighbours, each pair once.
    target : int
    criterion : {"kl", "bhattacharyya"}

    Returns
    -------
    (R,) int32
        The region that each one is part of now, 0..R'-1 in the order of their first parts.
    """
    adjacent = np.zeros((len(counts), len(counts)), np.bool_)
    adjacent[pairs[:, 0], pairs[:, 1]] = adjacent[pairs[:, 1], pairs[:, 0]] = True
    return _merge(counts.astype(np.float64), adjacent, target, criterion == "kl")


@compiled_part
def _part_cost(
    own: NDArray[np.float64], n_own: float, other: NDArray[np.float64], n_other: float, kl: bool
) -> float:
    """Return n1 KL(P1 | P), or -n1 log BC(P1, P), for one channel."""
    total = 0.0
    for b in range(len(own)):
        if own[b] > 0.0:
            share = own[b] / n_own
            union = (own[b] + other[b]) / (n_own + n_other)
            total += share * np.log(share / union) if kl else np.sqrt(share * union)
    return n_own * max(total, 0.0) if kl else -n_own * np.log(min(total, 1.0))


@compiled_part
def _cost(one: NDArray[np.float64], other: NDArray[np.float64], kl: bool) -> float:
    total = 0.0
    for c in range(len(one)):
        n1, n2 = one[c].sum(), other[c].sum()
        if n1 > 0.0 and n2 > 0.0:
            total += _part_cost(one[c], n1, other[c], n2, kl)
            total += _part_cost(other[c], n2, one[c], n1, kl)
    return total


@compiled
def _costs(counts: NDArray[np.float64], pairs: NDArray[np.int32], kl: bool) -> NDArray[np.float64]:
    costs = np.empty(len(pairs), np.float64)
    for e in range(len(pairs)):
        costs[e] = _cost(counts[pairs[e, 0]], counts[pairs[e, 1]], kl)
    return costs


@compiled_part
def _find_best(cost: NDArray[np.float64], row: int, best: NDArray[np.int32]) -> None:
    best[row] = np.argmin(cost[row])


@compiled
def _merge(
    counts: NDArray[np.float64], adjacent: NDArray[np.bool_], target: int, kl: bool
) -> NDArray[np.int32]:
    n = len(counts)
    parent = np.arange(n).astype(np.int32)
    cost = np.full((n, n), np.inf)
    best = np.zeros(n, np.int32)
    for i in range(n):
        for j in range(i):
            if adjacent[i, j]:
                cost[i, j] = cost[j, i] = _cost(counts[i], counts[j], kl)
    for i in range(n):
        _find_best(cost, i, best)
    for _ in range(n - target):
        one = 0
        for i in range(n):
            if cost[i, best[i]] < cost[one, best[one]]:
                one = i
        other = best[one]
        if cost[one, other] == np.inf:  # no neighbours left
            break
        one, other = min(one, other), max(one, other)
        join_roots(parent, one, other)
        counts[one] += counts[other]
        _adopt(counts, cost, best, one, other, kl)
    for i in range(n):
        find_root(parent, i)
    return flatten(parent)


@compiled_part
def _adopt(
    counts: NDArray[np.float64],
    cost: NDArray[np.float64],
    best: NDArray[np.int32],
    one: int,
    other: int,
    kl: bool,
) -> None:
    """Give `one` the neighbours of `other`, which is gone, and the costs of the union."""
    n = len(counts)
    for i in range(n):
        touched = cost[one, i] < np.inf or cost[other, i] < np.inf
        cost[other, i] = cost[i, other] = np.inf
        if touched and i != one and i != other:
            cost[one, i] = cost[i, one] = _cost(counts[one], counts[i], kl)
            _find_best(cost, i, best)
    _find_best(cost, one, best)
    _find_best(cost, other, best)
