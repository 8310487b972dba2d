"""The consensus of cuts, one setting at a time: who votes, how often, and what stays.

    python -m benchmarks.consensus NAME=FOLDER [...] [--protocol nyu] [--limit 48] [--processes 2]

On the draft of the preset paper. The protocol holds for the folders whose name begins with NYU.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from geohue.consensus import find_consensus, make_voters
from geohue.jobs.pool import run_jobs
from geohue.measures import evaluate
from geohue.measures.crop import PROTOCOLS, Crop
from geohue.ncut.cutter import Cutter
from geohue.prepared import prepare_scene
from geohue.settings import PRESETS
from geohue.settings.consensus import FINER_BALANCES
from geohue.settings.weight import COARSE
from geohue.studies.benchmark.frames import find_frames, load_frame
from geohue.studies.items import Item

PAPER = PRESETS["paper"]
MOST = 14

CASES: dict[str, dict[str, Any]] = {
    "as it is: 0, 1 and infinity; K to 10; 15 %; 0.6": {},
    "voters 0, 0.41, 1, 2.41, infinity": {"voters": FINER_BALANCES},
    "voters 1/16, 1/8, ... 16": {"voters": COARSE},
    "voter 1 alone": {"voters": (1.0,)},
    "voters 0 and infinity": {"voters": (0.0, math.inf)},
    "K to 6": {"k_max": 6},
    f"K to {MOST}": {"k_max": MOST},
    "10 % of the votes": {"least": 0.1},
    "20 % of the votes": {"least": 0.2},
    "25 % of the votes": {"least": 0.25},
    "clear 0.4": {"clear": 0.4},
    "clear 0.8": {"clear": 0.8},
    "votes only, 15 %": {"clear": 0.0},
    "votes only, 25 %": {"clear": 0.0, "least": 0.25},
}


def measure(frame: Item, crop: Crop | None) -> dict[str, tuple[float, float, float]]:
    """Return VoI, Rand index and number of segments of one frame for every case."""
    scene, truth = load_frame(frame, crop)
    prepared = prepare_scene(scene, PAPER)
    cutter, wanted = Cutter(prepared, MOST), truth.reshape(-1)[prepared.positions]
    found = {}
    for name, changes in CASES.items():
        asked = replace(prepared, settings=PAPER.changed(**changes))
        labels = find_consensus(make_voters(asked, cutter), asked).labels
        scores = evaluate(labels, np.where(labels < 0, 0, wanted))
        found[name] = (scores["voi_bits"], scores["rand"], float(scores["n_pred"]))
    return found


def report(results: list[dict[str, tuple[float, float, float]]]) -> Iterator[str]:
    """Write the table; the difference is that to the first case, with its standard error."""
    values = {name: np.array([result[name] for result in results]) for name in CASES}
    first = values[next(iter(CASES))]
    yield "| setting | VoI (bits) | difference | Rand | segments |"
    yield "| --- | --: | --: | --: | --: |"
    for name, v in values.items():
        change = v[:, 0] - first[:, 0]
        error = change.std() / math.sqrt(len(change))
        mean = v.mean(axis=0)
        difference = f"{change.mean():+.3f} ± {error:.3f}" if change.any() else ""
        yield f"| {name} | {mean[0]:.3f} | {difference} | {mean[1]:.3f} | {mean[2]:.1f} |"
    yield ""


def main() -> None:
    """Write a table for each folder."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="+", metavar="NAME=FOLDER")
    parser.add_argument("--protocol", choices=sorted(PROTOCOLS))
    parser.add_argument("--limit", type=int)
    parser.add_argument("--processes", type=int, default=2)
    given = parser.parse_args()
    for item in given.folders:
        name, _, folder = item.partition("=")
        crop = PROTOCOLS.get(given.protocol) if name.startswith("NYU") else None
        frames = find_frames(folder, given.limit)
        outcomes = list(run_jobs(partial(measure, crop=crop), frames, given.processes))
        results = [outcome.result for outcome in outcomes if outcome.result is not None]
        failures = [f"{o.job.name}: {o.error}" for o in outcomes if o.error is not None]
        print("\n".join([f"### {name}, {len(results)} frames", "", *failures, *report(results)]))


if __name__ == "__main__":
    main()
