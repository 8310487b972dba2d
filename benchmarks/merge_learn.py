"""How the constants of the merging are fitted, and how good a set of constants is on drafts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from benchmarks.merge_frames import Example
from benchmarks.merge_samples import collect
from numpy.typing import NDArray

from geohue.measures.contingency import contingency_table
from geohue.measures.partition import covering_of, information_of, rand_of
from geohue.merge.cues import NAMES
from geohue.merge.greedy import merge_all
from geohue.merge.table import Table
from geohue.merge.tree import MergeTree

Floats = NDArray[np.float64]

SHIFTS = np.arange(-8, 9) / 10
"""Thresholds that are tried on the fitted drafts; the best one goes into the bias."""

RANDOM_RUNS = 2
"""Random correct merges of each draft that are sampled before there are constants."""

KEPT = 3
"""Every so many samples are kept: a pair is looked at again whenever a neighbour has changed."""


@dataclass(frozen=True, slots=True)
class Plan:
    """How constants are fitted.

    Attributes
    ----------
    rounds : int
        Rounds of the merging's own decisions that are added to the samples.
    averaged : int
        Rounds at the end whose constants are averaged.
    cues : tuple of str
        The cues to use.
    seed : int
        Source of the random merges.
    """

    rounds: int = 10
    averaged: int = 4
    cues: tuple[str, ...] = NAMES
    seed: int = 0


def copied(table: Table) -> Table:
    """Copy a table, as merging uses it up."""
    return Table(
        table.region.copy(),
        table.votes.copy(),
        table.border.copy(),
        table.ends.copy(),
        table.scene.copy(),
    )


def counts_of(example: Example) -> Floats:
    """Points of each region in each true segment, (R, G); those without a label left out."""
    known = example.truth > 0
    _, names = np.unique(example.truth[known], return_inverse=True)
    counts = np.zeros((len(example.table.region), int(names.max(initial=0)) + 1))
    np.add.at(counts, (example.regions[known], names), 1.0)
    return counts


def fit(examples: Sequence[Example], plan: Plan) -> Floats:
    """Fit constants: a weighted logistic regression on decisions, and the best threshold.

    Each round adds the decisions that the merging meets with the constants so far, so that it
    learns from the states it gets into (Ross, Gordon and Bagnell 2011).

    Parameters
    ----------
    examples : sequence of Example
        Drafts with labels.
    plan : Plan
        How.

    Returns
    -------
    (16,) float64
        Constants in the order of `NAMES`, the bias last.
    """
    counts = [counts_of(example) for example in examples]
    first = range(RANDOM_RUNS * plan.seed, RANDOM_RUNS * (plan.seed + 1))
    samples = [_round(examples, counts, None, seed) for seed in first]
    last: list[Floats] = []
    weights = regress(*_joined(samples), plan.cues)
    for _ in range(plan.rounds):
        samples.append(_round(examples, counts, weights, 0))
        weights = regress(*_joined(samples), plan.cues)
        last.append(weights)
    if last:
        weights = np.mean(last[-plan.averaged :], axis=0)
    return at_best_threshold(examples, weights)


def regress(cues: Floats, change: Floats, used: Sequence[str]) -> Floats:
    """Regress whether merging a pair does harm on its cues, each sample weighted.

    Parameters
    ----------
    cues : (S, 15) float
        Of the pairs.
    change : (S,) float
        Change of the variation of information; its square root is the weight of a sample.
    used : sequence of str
        The cues to use.

    Returns
    -------
    (16,) float64
    """
    from sklearn.linear_model import LogisticRegression

    columns = [i for i, name in enumerate(NAMES) if name in used]
    values = cues[:, columns]
    mean, spread = values.mean(axis=0, dtype=np.float64), values.std(axis=0, dtype=np.float64)
    spread = np.maximum(spread, 1e-9)
    weight = np.sqrt(np.abs(change))
    model = LogisticRegression(solver="newton-cholesky")
    model.fit((values - mean) / spread, change > 0, sample_weight=weight / weight.mean())
    out = np.zeros(len(NAMES) + 1)
    out[columns] = model.coef_[0] / spread
    out[-1] = model.intercept_[0] - (out[columns] * mean).sum()
    return out


def at_best_threshold(examples: Sequence[Example], weights: Floats) -> Floats:
    """Shift the bias to the threshold with the least mean variation of information.

    It is the lowest point of a parabola through the means: from one threshold to the next they
    jump by some thousandths of a bit.
    """
    voi = evaluate(examples, weights, SHIFTS)[:, :, 0].mean(axis=0)
    curve, slope, _ = np.polyfit(SHIFTS, voi, 2)
    best = -slope / (2 * curve) if curve > 0 else SHIFTS[voi.argmin()]
    shifted = weights.copy()
    shifted[-1] -= np.clip(best, SHIFTS[0], SHIFTS[-1])
    return shifted


def evaluate(
    examples: Sequence[Example],
    weights: Floats | Sequence[Floats],
    thresholds: Floats | None = None,
) -> Floats:
    """Score the merging of drafts.

    Parameters
    ----------
    examples : sequence of Example
        Drafts with labels.
    weights : (16,) float64 or one such for each draft
        Constants.
    thresholds : (T,) float64, optional
        Scores below which regions are merged; 0 if not given.

    Returns
    -------
    (n, T, 3) float64
        Variation of information in bits, Rand index and covering.
    """
    each = [weights] * len(examples) if isinstance(weights, np.ndarray) else weights
    steps = np.zeros(1) if thresholds is None else thresholds
    out = np.empty((len(examples), len(steps), 3))
    for i, (example, constants) in enumerate(zip(examples, each, strict=True)):
        tree = MergeTree(
            len(example.table.region), *merge_all(copied(example.table), np.asarray(constants))
        )
        for j, threshold in enumerate(steps):
            table = contingency_table(tree.at(threshold)[example.regions], example.truth)
            out[i, j] = information_of(table).total, rand_of(table), covering_of(table)
    return out


def _round(
    examples: Sequence[Example], counts: Sequence[Floats], weights: Floats | None, seed: int
) -> tuple[Floats, Floats]:
    parts = [
        collect(copied(example.table), count.copy(), weights, seed)
        for example, count in zip(examples, counts, strict=True)
    ]
    return _joined([(cues[::KEPT].astype(np.float32), change[::KEPT]) for cues, change in parts])


def _joined(parts: Sequence[tuple[Floats, Floats]]) -> tuple[Floats, Floats]:
    cues, change = zip(*parts, strict=True)
    return np.concatenate(cues), np.concatenate(change)
