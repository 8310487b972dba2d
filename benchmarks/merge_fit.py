"""Fit the constants of `geohue.merge.score`, and study what they depend on.

    python -m benchmarks.merge_fit DATA STORE [STUDY ...] [--every 1] [--rounds 10]

DATA is the folder of the data sets, STORE one for the drafts, outside of the repository; delete it
when the code of cuts or evidence changes. Studies: ``constants`` prints the tables of constants for
score.py, and how good they are on the drafts of the test part; ``transfer`` fits on one data set,
or on simulated scenes alone; ``cues`` leaves out one cue at a time; ``ingredients`` does without
votes or smoothing; ``seeds`` fits with other random merges; ``blend`` compares values of
COLOR_SPREAD. ``--every 3`` fits on every third frame only.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
from benchmarks.merge_frames import (
    VARIANTS,
    Example,
    gather_examples,
    names,
    simulated_names,
)
from benchmarks.merge_learn import Floats, Plan, evaluate, fit
from benchmarks.splits import Part

from geohue.merge.cues import NAMES
from geohue.merge.score import COLOR, COLOR_SPREAD, FUSION, GEOMETRY, Cues, weights_of

SETS = ("nyuv2", "mosd")

COLOR_CUES = (
    "color_step",
    "texture",
    "whole_votes",
    "length",
    "contrast",
    "straightness",
    "perimeter",
    "smaller",
    "larger",
)
"""What is left to go by without geometry."""

FORM_CUES = tuple(name for name in GEOMETRY if name != "bias")
"""What is left to go by without colour; sizes do not carry over from frames to clouds."""

SPREADS = (0.0, 5.0, 10.0, 15.0, 20.0, 30.0)


@dataclass(frozen=True, slots=True)
class Bench:
    """What a study works with: where drafts come from, and how constants are fitted."""

    data: Path
    store: Path
    plan: Plan
    every: int

    def drafts(
        self, sets: Sequence[str], wanted: Part, cues: Cues = "fusion", variant: str = VARIANTS[0]
    ) -> list[Example]:
        """Return the drafts of a part of some data sets; of those to fit on every so many."""
        step = self.every if wanted == "fit" else 1
        listed = tuple(name for folder in sets for name in names(folder, wanted)[::step])
        return _drafts(listed, self.data, self.store, cues, variant)

    def scores(
        self, weights: Floats, cues: Cues = "fusion", variant: str = VARIANTS[0]
    ) -> tuple[Floats, ...]:
        """Return the scores of each draft of the test part, (n, 3) for each data set."""
        return tuple(
            evaluate(self.drafts([name], "test", cues, variant), weights)[:, 0] for name in SETS
        )


@cache
def _drafts(
    listed: tuple[str, ...], data: Path, store: Path, cues: Cues, variant: str
) -> list[Example]:
    return [each[variant] for each in gather_examples(listed, data, store, cues)]


def row(name: str, scores: Sequence[Floats], base: Sequence[Floats] | None = None) -> None:
    """Print means, and the paired difference of the variation of information from a base."""
    cells = []
    for i, each in enumerate(scores):
        cells.append(" / ".join(f"{value:.3f}" for value in each.mean(axis=0)))
        if base is None:
            error = each[:, 0].std(ddof=1) / np.sqrt(len(each))
            cells.append(f"+- {error:.3f}")
        else:
            away = each[:, 0] - base[i][:, 0]
            cells.append(f"{away.mean():+.3f} +- {away.std(ddof=1) / np.sqrt(len(away)):.3f}")
    print(f"| {name} | {' | '.join(cells)} |", flush=True)


def head(title: str) -> None:
    """Print the head of a table of scores."""
    cells = [f"{name}: VoI / Rand / covering | VoI, change" for name in SETS]
    print(f"\n| {title} | {' | '.join(cells)} |\n| --- {'| --: ' * 2 * len(SETS)}|", flush=True)


def table_of(name: str, weights: Floats) -> None:
    """Print constants as they stand in score.py."""
    print(f"\n{name} = {{")
    for cue, value in zip((*NAMES, "bias"), weights, strict=True):
        if value:
            print(f'    "{cue}": {value:.3f},')
    print("}", flush=True)


def constants(bench: Bench) -> None:
    """Fit all three columns, and compare them with those of score.py."""
    columns: list[tuple[str, Cues, tuple[str, ...], dict[str, float]]] = [
        ("FUSION", "fusion", NAMES, FUSION),
        ("GEOMETRY", "geometry", FORM_CUES, GEOMETRY),
        ("COLOR", "color", COLOR_CUES, COLOR),
    ]
    for name, cues, used, today in columns:
        drafts = bench.drafts(SETS, "fit", cues)
        weights = fit(drafts, replace(bench.plan, cues=used))
        table_of(name, weights)
        base = bench.scores(weights_of(today), cues)
        fitted = [evaluate(drafts, each)[:, 0, 0].mean() for each in (weights_of(today), weights)]
        print(
            f"\n{len(drafts)} fitted drafts: {fitted[0]:.4f} bits in score.py, now {fitted[1]:.4f}"
        )
        head(f"{name}, test part")
        row("score.py", base)
        row("fitted now", bench.scores(weights, cues), base)


def transfer(bench: Bench) -> None:
    """Fit on one data set, or on simulated scenes, and test on both."""
    head("fitted on")
    base = bench.scores(fit(bench.drafts(SETS, "fit"), bench.plan))
    row("both", base)
    for name in SETS:
        row(f"{name} alone", bench.scores(fit(bench.drafts([name], "fit"), bench.plan)), base)
    made = gather_examples(simulated_names(3), bench.data, bench.store)
    weights = fit([each[VARIANTS[0]] for each in made], bench.plan)
    row(f"{len(made)} simulated frames", bench.scores(weights), base)


def cues(bench: Bench) -> None:
    """Leave out one cue at a time, and fit the others anew."""
    head("without")
    drafts = bench.drafts(SETS, "fit")
    base = bench.scores(fit(drafts, bench.plan))
    row("(all cues)", base)
    for name in NAMES:
        used = tuple(cue for cue in NAMES if cue != name)
        row(name, bench.scores(fit(drafts, replace(bench.plan, cues=used))), base)
    used = tuple(cue for cue in NAMES if cue not in ("smaller", "larger", "region_convexity"))
    row("the last three", bench.scores(fit(drafts, replace(bench.plan, cues=used))), base)


def ingredients(bench: Bench) -> None:
    """Do without votes or smoothing, or with fewer cuts, and fit anew."""
    head("regions and cues")
    base: tuple[Floats, ...] | None = None
    for variant in VARIANTS:
        used = tuple(cue for cue in NAMES if variant != "no votes" or cue != "whole_votes")
        weights = fit(bench.drafts(SETS, "fit", "fusion", variant), replace(bench.plan, cues=used))
        scores = bench.scores(weights, "fusion", variant)
        row(variant, scores, base)
        base = base or scores


def seeds(bench: Bench) -> None:
    """Fit with other random merges, fewer rounds, and no average."""
    head("fit")
    drafts = bench.drafts(SETS, "fit")
    base = bench.scores(fit(drafts, bench.plan))
    row("seed 0", base)
    for seed in (1, 2):
        row(f"seed {seed}", bench.scores(fit(drafts, replace(bench.plan, seed=seed))), base)
    for rounds in (0, 1, 3, bench.plan.rounds):
        plan = replace(bench.plan, rounds=rounds, averaged=1)
        row(f"{rounds} rounds, no average", bench.scores(fit(drafts, plan)), base)


def blend(bench: Bench) -> None:
    """Compare values of COLOR_SPREAD, the blend of the columns FUSION and GEOMETRY."""
    head("COLOR_SPREAD")
    base: tuple[Floats, ...] | None = None
    for spread in SPREADS:
        scores = tuple(_blended(bench.drafts([name], "test"), spread) for name in SETS)
        row(f"{spread:g}", scores, base)
        base = base or scores


def _blended(drafts: Sequence[Example], spread: float) -> Floats:
    """Score drafts with the constants of score.py, blended by another spread."""
    weights = []
    for draft in drafts:
        variance = COLOR_SPREAD**2 * draft.share / max(1 - draft.share, 1e-9)
        share = variance / max(variance + spread**2, 1e-9)
        weights.append(share * weights_of(FUSION) + (1 - share) * weights_of(GEOMETRY))
    return evaluate(drafts, weights)[:, 0]


STUDIES: dict[str, Callable[[Bench], None]] = {
    study.__name__: study for study in (constants, transfer, cues, ingredients, seeds, blend)
}


def main() -> None:
    """Run the studies that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path)
    parser.add_argument("store", type=Path)
    parser.add_argument("studies", nargs="*", default=["constants"], choices=STUDIES)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--rounds", type=int, default=10)
    given = parser.parse_args()
    plan = Plan(rounds=given.rounds, averaged=min(Plan().averaged, given.rounds))
    bench = Bench(given.data, given.store, plan, given.every)
    for study in given.studies:
        STUDIES[study](bench)


if __name__ == "__main__":
    main()
