"""Sec. IV: the weight that maximises Q, coarse to fine."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from geohue.compute.parallel import Workers
from geohue.settings.weight import COARSE, REFINEMENTS

Curve = list[tuple[float, float]]
"""Pairs (lambda, Q) in increasing order of lambda."""


def search_weight(
    score: Callable[[float], float | None],
    workers: Workers,
    coarse: Sequence[float] = COARSE,
    refinements: Sequence[float] = REFINEMENTS,
) -> tuple[float, Curve]:
    """Find the weight with the highest score.

    First every coarse weight is tried, then, for each step in `refinements`, the two weights one
    step below and above the best so far. Of equal scores the weight nearest to 1 wins.

    Parameters
    ----------
    score : callable
        Q for a weight, None where it is undefined. Must be safe to call from several threads,
        and must share landmarks and chance between weights, or the curve is noise.
    workers : Workers
        Threads to use.
    coarse : sequence of float
        Positive weights to begin with.
    refinements : sequence of float
        Steps in octaves.

    Returns
    -------
    weight : float
        The best weight; 1 if Q was undefined everywhere.
    curve : list of (float, float)
        Every weight tried with its Q, in increasing order; undefined ones are left out.

    Examples
    --------
    >>> from geohue.compute.parallel import workers
    >>> with workers(1) as team:
    ...     weight, curve = search_weight(lambda x: -abs(np.log2(x) - 1.2), team)
    >>> round(weight, 3), len(curve)
    (2.378, 13)
    """
    curve = _evaluate(score, coarse, workers)
    for step in refinements:
        best = _best(curve)
        curve |= _evaluate(score, (best * 2**-step, best * 2**step), workers)
    return _best(curve), sorted(curve.items())


def _evaluate(
    score: Callable[[float], float | None], weights: Sequence[float], workers: Workers
) -> dict[float, float]:
    values = zip(weights, workers.map(score, weights), strict=True)
    return {weight: value for weight, value in values if value is not None}


def _best(curve: dict[float, float]) -> float:
    if not curve:
        return 1.0
    return max(curve, key=lambda weight: (curve[weight], -abs(np.log2(weight)), weight))
