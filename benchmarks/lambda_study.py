"""Does the weight with the highest Q give the best segmentation? Tables from scored sweeps.

    python -m benchmarks.lambda_study NAME=SCORES [NAME=SCORES ...] [-k 4 6 8] [--short]

SCORES are folders that `benchmarks.scores` wrote. Weights: half octaves from 1/16 to 16.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from benchmarks.criteria import INTERS, NORMS
from benchmarks.scores import CRITERIA_KS, UNITS, Scores, load_scores
from benchmarks.sweep import KS, WEIGHTS
from numpy.typing import NDArray
from scipy.stats import rankdata

Floats = NDArray[np.float64]
Rule = Callable[[Scores, int], Floats]

FINITE = slice(1, -1)
GRID = WEIGHTS[FINITE]
MEASURED = UNITS.index("components")
"""VoI is that of connected components, as in the tables of the benchmark."""


@dataclass(frozen=True, slots=True)
class Result:
    """How well a rule chooses the weight on many frames.

    Attributes
    ----------
    voi, regret : float
        Mean VoI of the chosen weights, and what the best weights have less.
    error : float
        Standard error of the regret.
    best, near : float
        Share of frames where the choice is the best, and within 5 % of it.
    rank : float
        Mean Spearman correlation of the rule's scores with minus VoI over the weights.
    """

    voi: float
    regret: float
    error: float
    best: float
    near: float
    rank: float


def criterion(name: str, unit: str) -> Rule:
    """Return the rule that takes the weight with the highest score."""

    def score(frame: Scores, k: int) -> Floats:
        found = np.flatnonzero(frame.names == name)[0]
        values = frame.criteria[found, UNITS.index(unit), FINITE, KS.index(k)]
        # One segment has no score: it is never chosen.
        lowest = np.nanmin(values) if np.isfinite(values).any() else 0.0
        return np.where(np.isnan(values), lowest - 1e-9, values)

    return score


def fixed(weight: float) -> Rule:
    """Return the rule that takes one weight whatever the frame."""
    return lambda _frame, _k: -np.abs(np.log2(GRID) - np.log2(weight))


def smoothed(rule: Rule, width: int) -> Rule:
    """Average a rule's scores over neighbouring weights."""

    def score(frame: Scores, k: int) -> Floats:
        values = np.pad(rule(frame, k), width // 2, mode="edge")
        return np.convolve(values, np.ones(width) / width, "valid")

    return score


def together(*rules: Rule) -> Rule:
    """Add the scores of several rules, each brought to mean 0 and deviation 1 over the weights."""

    def score(frame: Scores, k: int) -> Floats:
        total = np.zeros(len(GRID))
        for rule in rules:
            values = rule(frame, k)
            total += (values - values.mean()) / (values.std() or 1.0)
        return total

    return score


def rules() -> dict[str, Rule]:
    """Return all rules by their names."""
    found: dict[str, Rule] = {}
    for unit in UNITS:
        for inter in INTERS:
            for norm in NORMS:
                found[f"Q, inter {inter}, {norm}, {unit}"] = criterion(f"Q {inter} {norm}", unit)
    clusters = UNITS[0]
    for name in (
        "Q without inter",
        "Q without intra",
        "explained sum",
        "planes",
        "explained color, planes",
        "unequal sizes",
        "contrast geometry",
        "contrast sum",
        "contrast color",
        "stability",
        "consensus",
    ):
        found[name] = criterion(name, clusters)
    found["Q (paper), smoothed over 3 weights"] = smoothed(criterion("Q pairs sum", clusters), 3)
    found["Q (paper), smoothed over 5 weights"] = smoothed(criterion("Q pairs sum", clusters), 5)
    found["contrast color + consensus + stability"] = together(
        *(criterion(n, clusters) for n in ("contrast color", "consensus", "stability"))
    )
    for weight in (0.25, 0.5, 1.0, 2.0):
        found[f"always {weight:g}"] = fixed(weight)
    return found


def judge(frames: list[Scores], rule: Rule, k: int) -> Result:
    """Choose the weight of every frame by a rule, and compare with the best weight."""
    voi = np.array([frame.voi[MEASURED, FINITE, KS.index(k)] for frame in frames])
    scores = np.array([rule(frame, k) for frame in frames])
    chosen = voi[np.arange(len(voi)), scores.argmax(axis=1)]
    best = voi.min(axis=1)
    regret = chosen - best
    ranks = [_spearman(s, -v) for s, v in zip(scores, voi, strict=True)]
    return Result(
        float(chosen.mean()),
        float(regret.mean()),
        float(regret.std(ddof=1) / np.sqrt(len(regret))),
        float((regret < 1e-9).mean()),
        float((chosen <= 1.05 * best + 1e-9).mean()),
        float(np.nanmean(ranks)) if np.isfinite(ranks).any() else float("nan"),
    )


def _spearman(a: Floats, b: Floats) -> float:
    a, b = rankdata(a), rankdata(b)
    if a.std() == 0 or b.std() == 0:
        return float("nan")
    return float(np.corrcoef(a, b)[0, 1])


SHORT = (
    "Q, inter pairs, sum, clusters",
    "Q, inter adjacent, sum, clusters",
    "explained color, planes",
    "contrast color",
    "consensus",
    "contrast color + consensus + stability",
    "always 0.25",
    "always 1",
)
"""The rules of the short tables."""


def report(name: str, frames: list[Scores], k: int, short: bool = False) -> Iterator[str]:
    """Write the table of one set of frames at one K."""
    voi = np.array([frame.voi[MEASURED][:, KS.index(k)] for frame in frames])
    best = voi[:, FINITE].min(axis=1)
    yield f"### {name}, K = {k}, {len(frames)} frames"
    yield ""
    yield "| rule | VoI (bits) | regret | best | within 5 % | rank correlation |"
    yield "| --- | --: | --: | --: | --: | --: |"
    yield f"| oracle: the best weight of each frame | {best.mean():.3f} | 0 | 100 % | 100 % | |"
    for title, column in (("colour only", 0), ("geometry only", -1)):
        other = voi[:, column]
        near = (other <= 1.05 * best).mean()
        regret = (other - best).mean()
        yield f"| {title} | {other.mean():.3f} | {regret:.3f} | | {near:.0%} | |"
    judged = {
        title: judge(frames, rule, k)
        for title, rule in rules().items()
        if not short or title in SHORT
    }
    for title, r in sorted(judged.items(), key=lambda item: item[1].regret):
        rank = "" if np.isnan(r.rank) else f"{r.rank:.2f}"
        paper = " **(the paper's)**" if title == "Q, inter pairs, sum, clusters" else ""
        yield (
            f"| {title}{paper} | {r.voi:.3f} | {r.regret:.3f} ± {r.error:.3f} | {r.best:.0%} "
            f"| {r.near:.0%} | {rank} |"
        )
    yield ""


def main() -> None:
    """Write the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scores", nargs="+", metavar="NAME=SCORES")
    parser.add_argument("-k", type=int, nargs="+", default=[6], choices=CRITERIA_KS)
    parser.add_argument("--short", action="store_true", help="the main rules only")
    parser.add_argument("-o", "--out", type=Path)
    given = parser.parse_args()
    lines: list[str] = []
    for pair in given.scores:
        name, _, folder = pair.partition("=")
        frames = load_scores(Path(folder))
        for k in given.k:
            lines += report(name, frames, k, given.short)
    text = "\n".join(lines)
    print(text)
    if given.out is not None:
        given.out.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
