"""Score the segmentations of a sweep: against the true labels, and by what uses none.

    python -m benchmarks.scores FOLDER -s SWEEP -o OUT [--protocol nyu] [--processes 2]

FOLDER and the protocol are those of `benchmarks.sweep`, SWEEP what it wrote. One file a frame,
written whole or not at all; a second run goes on where the first one ended.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from benchmarks.criteria import Data, criteria
from benchmarks.sweep import KS, WEIGHTS, Sweep, load
from numpy.typing import NDArray

from geohue.jobs.pool import run_jobs
from geohue.measures.contingency import contingency_table
from geohue.measures.crop import PROTOCOLS, Crop
from geohue.measures.partition import information_of, rand_of
from geohue.regions.images import connected_components
from geohue.results.atomic import atomic_write
from geohue.scene import Scene
from geohue.studies.benchmark.frames import find_frames, load_frame
from geohue.studies.items import Item
from geohue.weight.likeness import likeness

UNITS = ("clusters", "components")

CRITERIA_KS = (4, 6, 8)
"""K for which all criteria are computed."""


@dataclass(frozen=True, slots=True, eq=False)
class Scores:
    """The scores of one frame.

    Attributes
    ----------
    voi, rand : (2, len(WEIGHTS), len(KS)) float64
        Against the truth; first axis UNITS.
    regions : (2, len(WEIGHTS), len(KS)) int64
        Number of regions.
    criteria : (n, 2, len(WEIGHTS), len(KS)) float64
        NaN where a criterion is undefined or was not computed.
    names : (n,) str
        Of the criteria.
    eigenvalues, chosen
        As in the sweep.
    """

    voi: NDArray[np.float64]
    rand: NDArray[np.float64]
    regions: NDArray[np.int64]
    criteria: NDArray[np.float64]
    names: NDArray[np.str_]
    eigenvalues: NDArray[np.float64]
    chosen: NDArray[np.int64]


def score(scene: Scene, swept: Sweep) -> Scores:
    """Score all segmentations of a frame's draft."""
    data = Data(scene.take(swept.positions))
    shape = (len(UNITS), len(WEIGHTS), len(KS))
    voi, rand, regions = np.empty(shape), np.empty(shape), np.empty(shape, np.int64)
    found: dict[str, NDArray[np.float64]] = {}
    for j, k in enumerate(KS):
        clusters = [swept.labels[i, j].astype(np.int32) for i in range(len(WEIGHTS))]
        per_unit = (clusters, [connected_components(labels) for labels in clusters])
        for u, maps in enumerate(per_unit):
            for i, labels in enumerate(maps):
                table = contingency_table(labels, swept.truth)
                voi[u, i, j] = information_of(table).total
                rand[u, i, j] = rand_of(table)
                regions[u, i, j] = len(table.pred_labels)
                if k in CRITERIA_KS:
                    for name, value in (criteria(data, labels) or {}).items():
                        found.setdefault(name, np.full(shape, np.nan))[u, i, j] = value
            if k in CRITERIA_KS:
                for name, values in zip(("consensus", "stability"), likeness(maps), strict=True):
                    found.setdefault(name, np.full(shape, np.nan))[u, :, j] = values
    return Scores(
        voi,
        rand,
        regions,
        np.stack(list(found.values())),
        np.array(list(found)),
        swept.eigenvalues,
        swept.chosen,
    )


def save(frame: Item, swept: Path, out: Path, crop: Crop | None) -> str:
    """Score a frame and write the result."""
    scene, _ = load_frame(frame, crop)
    result = score(scene, load(swept / f"{frame.name}.npz"))
    with atomic_write(out / f"{frame.name}.npz") as temporary:
        np.savez_compressed(
            temporary,
            voi=result.voi,
            rand=result.rand,
            regions=result.regions,
            criteria=result.criteria,
            names=result.names,
            eigenvalues=result.eigenvalues,
            chosen=result.chosen,
        )
    return frame.name


def load_scores(folder: Path) -> list[Scores]:
    """Read what `save` wrote, in the order of the frames' names."""
    frames = []
    for path in sorted(folder.glob("*.npz")):
        with np.load(path) as stored:
            frames.append(Scores(**{name: stored[name] for name in stored.files}))
    return frames


def main() -> None:
    """Score the frames of a sweep."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("-s", "--sweep", type=Path, required=True)
    parser.add_argument("-o", "--out", type=Path, required=True)
    parser.add_argument("--protocol", choices=sorted(PROTOCOLS))
    parser.add_argument("--processes", type=int, default=2)
    given = parser.parse_args()
    jobs = [
        frame
        for frame in find_frames(given.folder)
        if (given.sweep / f"{frame.name}.npz").exists()
        and not (given.out / f"{frame.name}.npz").exists()
    ]
    work = partial(save, swept=given.sweep, out=given.out, crop=PROTOCOLS.get(given.protocol or ""))
    for done, outcome in enumerate(run_jobs(work, jobs, given.processes), start=1):
        print(f"{done}/{len(jobs)} {outcome.job.name} {outcome.error or ''}", file=sys.stderr)


if __name__ == "__main__":
    main()
