"""The cut against other libraries' on the same vectors, time and quality side by side.

    python -m benchmarks.peers [--env DIR] [--frames 2] [--runs 3] [--spectral 10000]

The peers run in an environment of their own, which is made in DIR (by default in the user's cache
folder). All get the 6-D vectors of one frame with lambda = 1, K = 5, 100 landmarks, the Gaussian of
geohue's preset, and two threads as geohue; what is timed starts at the vectors (geohue: at colour
and geometry apart) and ends at the labels. Runs are interleaved; medians, and what they rest on.

- ncut-pytorch: `Ncut` and `kway_ncut` as in its quick start, with 100 landmarks, and again with the
  10,240 that it recommends; it fits its cut on these landmarks alone, which is nearest to geohue's
  cut fitted on its draft of 20,000 points, as the preset `fast` does it;
- nystrom-ncut: `NystromNCut` and `AxisAlign`, its landmarks given (it need not choose them);
- scikit-learn: `Nystroem` and k-means, whole and in batches; `SpectralClustering` on a thinned
  grid of as many points as --spectral says (it keeps all affinities in memory);
- scikit-image: `felzenszwalb` (scale 300, sigma 0.8) on the picture, against the preset `fast` from
  scene to filled labels, and against the cut alone.

VoI and Rand against the true labels of nyuv2 (in the valid crop) and mosd, where depth is known,
of the labels as each gives them; these need GEOHUE_DATA (or ../shared/data).
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from statistics import fmean, median
from time import perf_counter, process_time
from typing import Any

import numpy as np
from benchmarks.peers.environment import Answer, Peers, open_peers
from numpy.typing import NDArray

import geohue
from geohue.compute.parallel import cores, workers
from geohue.datasets import load_sample
from geohue.features import Features, Raw, extract_features
from geohue.jobs.machine import describe_machine
from geohue.measures import evaluate
from geohue.measures.crop import PROTOCOLS, Crop
from geohue.ncut.cutter import Cutter
from geohue.prepared import PreparedScene
from geohue.settings import Preset
from geohue.studies.benchmark.frames import find_frames, load_frame

K, WEIGHT, SEED = 5, 1.0, 0
SETTINGS = Preset()
ON_DRAFT = SETTINGS.changed(fit="draft")


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """A frame to be split, with what is known of it."""

    source: str
    scene: geohue.Scene
    features: Features
    truth: NDArray[np.int32] | None = None
    crop: Crop | None = None

    @classmethod
    def of(
        cls,
        source: str,
        scene: geohue.Scene,
        truth: NDArray[np.int32] | None = None,
        crop: Crop | None = None,
    ) -> Task:
        """Make a task of a scene."""
        if truth is not None:
            truth = np.where(scene.valid, truth, 0)
        return cls(source, scene, extract_features(scene), truth, crop)

    def thinned(self, count: int) -> Task:
        """Return the task on a thinner grid of about so many points."""
        rows = self.scene.thinning(count, np.random.default_rng(SEED))
        truth = None
        if self.truth is not None:
            # The protocol's crop does not fit the thinner grid: what is outside goes unlabelled.
            kept = np.zeros_like(self.truth)
            inside = (
                tuple(slice(*ends) for ends in (self.crop[:2], self.crop[2:])) if self.crop else ...
            )
            kept[inside] = self.truth[inside]
            truth = kept.reshape(-1)[rows]
        return Task(self.source, self.scene.take(rows), self.features.at(rows), truth)


Method = Callable[[Task], Answer]


@dataclass(slots=True)
class Row:
    """A method, and what came of it: answers and scores for each source of frames."""

    name: str
    run: Method
    most_runs: int = 99
    answers: dict[str, list[Answer]] = field(default_factory=dict)
    scores: dict[str, list[tuple[float, float]]] = field(default_factory=dict)

    def measure(self, task: Task, scored: bool) -> None:
        """Run once; the labels of the first run are scored."""
        found = self.run(task)
        self.answers.setdefault(task.source, []).append(found)
        if scored and task.truth is not None:
            result = evaluate(found.labels, task.truth, crop=task.crop)
            self.scores.setdefault(task.source, []).append((result["voi_bits"], result["rand"]))

    def milliseconds(self, source: str, part: str = "seconds") -> list[float]:
        """Return the times of the frames of a source."""
        return [1000 * getattr(answer, part) for answer in self.answers[source]]


def own_cut(task: Task, settings: Preset = SETTINGS) -> Answer:
    """Make the cut with a fixed weight, its landmarks and k-means included."""
    with workers() as team:
        prepared = PreparedScene.of(Raw(task.scene), task.features, settings, SEED, team)
        begin, busy = perf_counter(), process_time()
        labels = Cutter(prepared, K).labels(WEIGHT, K)
        seconds, busy = perf_counter() - begin, process_time() - busy
    return Answer(labels, seconds, seconds, busy)


def own_fast(task: Task) -> Answer:
    """Run the preset fast: K and weight chosen, small regions removed, pixels filled."""
    begin, busy = perf_counter(), process_time()
    labels = geohue.segment(task.scene, preset="fast").labels
    seconds, busy = perf_counter() - begin, process_time() - busy
    return Answer(labels, seconds, seconds, busy)


def vectors_through(peers: Peers, method: str, **settings: float) -> Method:
    """Return a peer's way from vectors to labels."""

    def run(task: Task) -> Answer:
        vectors = task.features.mixed(WEIGHT)
        rows = np.random.default_rng(SEED).choice(
            len(vectors), SETTINGS.cut.landmarks, replace=False
        )
        given = {"k": K, "scale": SETTINGS.cut.scale, "seed": SEED} | settings
        found = peers.run(method, vectors, np.sort(rows), **given)
        return replace(found, labels=task.features.to_scene(found.labels))

    return run


def picture_through(peers: Peers) -> Method:
    """Return scikit-image's way from the picture to labels."""

    def run(task: Task) -> Answer:
        smallest = round(SETTINGS.min_region * task.scene.size)
        none = np.empty(0, np.int64)
        return peers.run("felzenszwalb", task.scene.colors, none, smallest=smallest)

    return run


def tasks(count: int) -> Iterator[Task]:
    """Yield the frames: the motorcycle, and real ones where they are there."""
    yield Task.of("motorcycle", load_sample("motorcycle"))
    data = Path(os.environ.get("GEOHUE_DATA", Path(__file__).parents[3] / "shared" / "data"))
    for name, crop in (("nyuv2", PROTOCOLS["nyu"]), ("mosd", None)):
        if not (data / name).is_dir():
            print(f"no {name} in {data}: times only (set GEOHUE_DATA)", file=sys.stderr)
            continue
        for frame in find_frames(data / name, count):
            scene, truth = load_frame(frame)
            yield Task.of(name, scene, truth, crop)


def groups(peers: Peers) -> list[list[Row]]:
    """Return the tables' rows; the first of each is geohue's, on which the ratios rest."""
    peer = vectors_through
    n = SETTINGS.cut.landmarks
    return [
        [
            Row("geohue, cut", own_cut),
            Row("geohue, cut fitted on its draft", partial(own_cut, settings=ON_DRAFT)),
            Row("ncut-pytorch", peer(peers, "ncut_pytorch", samples=n)),
            Row("ncut-pytorch, its own 10,240 landmarks", peer(peers, "ncut_pytorch"), 2),
            Row("nystrom-ncut", peer(peers, "nystrom_ncut"), 2),
            Row("scikit-learn Nystroem, k-means in batches", peer(peers, "nystroem", minibatch=1)),
            Row("scikit-learn Nystroem, k-means", peer(peers, "nystroem")),
        ],
        [
            Row("geohue, preset fast", own_fast),
            Row("geohue, cut", own_cut),
            Row("scikit-image felzenszwalb", picture_through(peers)),
        ],
        [
            Row("geohue, cut", own_cut),
            Row("scikit-learn SpectralClustering", peer(peers, "spectral"), 1),
        ],
    ]


def print_table(rows: list[Row], heading: str) -> None:
    """Print times, their ratios to the first row's, and scores."""
    print(f"### {heading}\n")
    print("| | frames | ms | least to most | to embedding | CPU ms | ratio | VoI | Rand |")
    print("| --- | --- | --: | --: | --: | --: | --: | --: | --: |")
    for source in rows[0].answers:
        base = median(rows[0].milliseconds(source))
        for row in rows:
            times = row.milliseconds(source)
            embedding = median(row.milliseconds(source, "embedding"))
            busy = median(row.milliseconds(source, "processor"))
            scores = zip(*row.scores.get(source, []), strict=True)
            means = [f"{fmean(values):.3f}" for values in scores] or ["", ""]
            print(
                f"| {row.name} | {source} | {median(times):.0f} "
                f"| {min(times):.0f} - {max(times):.0f} | {embedding:.0f} | {busy:.0f} "
                f"| {median(times) / base:.1f} | {' | '.join(means)} |"
            )
    print(flush=True)


def measure(rows: list[Row], work: list[Task], runs: int) -> None:
    """Run all methods on all frames, turn by turn, after one run each that does not count."""
    for row in rows:
        if row.most_runs > 1:
            row.run(work[0])
    for turn in range(runs):
        for task in work:
            for row in rows:
                if turn < row.most_runs:
                    print(f"run {turn + 1}/{runs}: {task.source}, {row.name}", file=sys.stderr)
                    row.measure(task, scored=turn == 0)


def main() -> None:
    """Print the tables."""
    given = _arguments()
    work = list(tasks(given.frames))
    dense = next((task for task in work if task.truth is not None), work[0])
    small = [dense.thinned(given.spectral)]
    with open_peers(given.env, cores()) as peers:
        vectors, pictures, thinned = groups(peers)
        machine = describe_machine()
        print("; ".join(f"{k} {v}" for k, v in {"geohue": geohue.__version__, **machine}.items()))
        print("peers: " + ", ".join(f"{k} {v}" for k, v in peers.versions.items()) + "\n")
        plans: list[tuple[list[Row], list[Task], str]] = [
            (vectors, work, "From vectors to labels"),
            (pictures, work, "From a picture to labels"),
            (thinned, small, f"The exact cut, on {len(small[0].features):,} points"),
        ]
        for rows, group, heading in plans:
            measure(rows, group, given.runs)
            print_table(rows, heading)


def _arguments() -> Any:
    cache = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--env", type=Path, default=cache / "geohue-peers")
    parser.add_argument("--frames", type=int, default=2, help="real frames of each source")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--spectral", type=int, default=10_000, help="points of the exact cut")
    return parser.parse_args()


if __name__ == "__main__":
    main()
