"""One setting at a time: landmarks, affinity scale, labelling, refinement, fill, seeds.

    python -m benchmarks.ablations NAME=FOLDER [--protocol nyu] [--limit 20] [-k 6] [-o FILE.md]

Everything is the preset of the paper but for the setting named; regions are connected components.
The weight is 1 where it is not said to be chosen, so that the choice adds no noise of its own.
Fill is measured on the simulated scenes, which have true labels where depth is missing.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np

from geohue.jobs.pool import run_jobs
from geohue.measures import evaluate
from geohue.measures.crop import PROTOCOLS, Crop
from geohue.segmentation.driver import segment
from geohue.settings import PRESETS
from geohue.simulate import WORLDS, scene
from geohue.studies.benchmark.frames import find_frames, load_frame
from geohue.studies.items import Item

PAPER = PRESETS["paper"]
SEEDS = 10

SETTINGS: dict[str, tuple[dict[str, Any], ...]] = {
    "landmarks": tuple({"landmarks": n} for n in (25, 50, 100, 200, 400)),
    "choice of the landmarks": tuple(
        {"landmark_choice": name} for name in ("random", "kmeans", "farthest")
    ),
    "scale of the affinity": tuple({"scale": s} for s in (0.2, 0.3, 0.35, 0.4, 0.5, 0.7, 1.0)),
    "points of the fit": ({"fit": "all"}, {"fit": "draft"}),
    "restarts of k-means": tuple({"restarts": n} for n in (0, 2, 4, 8)),
    "labelling": tuple({"labelling": name} for name in ("kmeans", "rotation", "qr")),
    "smallest region": tuple({"min_region": m} for m in (0.0, 0.0005, 0.002, 0.005, 0.01)),
}

Key = tuple[str, str]
Weight = float | Literal["auto"]


def cases() -> Iterator[tuple[Key, dict[str, Any], Weight, int]]:
    """Yield the name, the changed settings, the weight and the seed of each run on a frame."""
    for group, changes in SETTINGS.items():
        for change in changes:
            ((_, value),) = change.items()
            yield (group, str(value)), change, 1.0, 0
    for scale in (0.3, 0.4, 0.5):
        yield ("scale of the affinity, weight by Q", str(scale)), {"scale": scale}, "auto", 0
    for seed in range(SEEDS):
        yield ("seed", str(seed)), {}, 1.0, seed
        yield ("seed, weight by Q", str(seed)), {}, "auto", seed


def measure(frame: Item, crop: Crop | None, k: int) -> dict[Key, tuple[float, float, float]]:
    """Return VoI, Rand index and number of regions of one frame for every case."""
    loaded, truth = load_frame(frame, crop)
    found = {}
    for key, change, weight, seed in cases():
        settings = PAPER.changed(**change)
        seg = segment(
            loaded, k, weight, settings, seed=seed, components=True, fill=False, threads=1
        )
        scores = evaluate(seg.labels, truth)
        found[key] = (scores["voi_bits"], scores["rand"], float(scores["n_pred"]))
    return found


def report(results: list[dict[Key, tuple[float, float, float]]]) -> Iterator[str]:
    """Write the tables; the spread over seeds is that of the mean over all frames."""
    values = {key: np.array([result[key] for result in results]) for key in results[0]}
    yield "| setting | value | VoI (bits) | sd over frames | Rand | regions |"
    yield "| --- | --- | --: | --: | --: | --: |"
    for (group, value), v in values.items():
        if not group.startswith("seed"):
            mean = v.mean(axis=0)
            yield (
                f"| {group} | {value} | {mean[0]:.3f} | {v[:, 0].std():.3f} | {mean[1]:.3f} "
                f"| {mean[2]:.1f} |"
            )
    yield ""
    yield f"| {SEEDS} seeds | mean VoI | least | largest | sd of the mean | sd within a frame |"
    yield "| --- | --: | --: | --: | --: | --: |"
    for group in ("seed", "seed, weight by Q"):
        voi = np.array([v[:, 0] for (g, _), v in values.items() if g == group])
        means = voi.mean(axis=1)
        title = "weight 1" if group == "seed" else "weight by Q"
        yield (
            f"| {title} | {means.mean():.3f} | {means.min():.3f} | {means.max():.3f} "
            f"| {means.std(ddof=1):.3f} | {voi.std(axis=0, ddof=1).mean():.3f} |"
        )
    yield ""


def fill_report(sensors: tuple[str, ...] = ("kinect", "stereo")) -> Iterator[str]:
    """Write how the fill of the Appendix changes VoI and boundaries of the simulated scenes."""
    yield "| sensor | scene | missing depth | VoI unfilled | VoI filled | F unfilled | F filled |"
    yield "| --- | --- | --: | --: | --: | --: | --: |"
    for sensor in sensors:
        for name in WORLDS:
            frame, truth = scene(name, sensor)
            cells = []
            for fill in (False, True):
                seg = segment(frame, int(truth.max()) + 1, 1.0, fill=fill, threads=1)
                cells.append(evaluate(seg.labels, truth, ignore=None))
            numbers = [f"{c[m]:.3f}" for m in ("voi_bits", "boundary_f") for c in cells]
            missing = f"{1 - frame.valid.mean():.1%}"
            yield "| " + " | ".join([sensor, name, missing, *numbers]) + " |"
    yield ""


def main() -> None:
    """Write the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", metavar="NAME=FOLDER")
    parser.add_argument("--protocol", choices=sorted(PROTOCOLS))
    parser.add_argument("--limit", type=int, default=20)
    parser.add_argument("-k", type=int, default=6)
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--fill", action="store_true", help="measure the fill too")
    parser.add_argument("-o", "--out", type=Path)
    given = parser.parse_args()
    name, _, folder = given.folder.partition("=")
    work = partial(measure, crop=PROTOCOLS.get(given.protocol or ""), k=given.k)
    frames = find_frames(folder, given.limit)
    outcomes = list(run_jobs(work, frames, given.processes))
    results = [outcome.result for outcome in outcomes if outcome.result is not None]
    failures = [f"{o.job.name}: {o.error}" for o in outcomes if o.error is not None]
    lines = [f"### {name}, {len(results)} frames, K = {given.k}", "", *failures, *report(results)]
    if given.fill:
        lines += fill_report()
    text = "\n".join(lines)
    print(text)
    if given.out is not None:
        given.out.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
