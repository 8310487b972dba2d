"""Segment the draft of every frame for a grid of weights and every K: what the studies look at.

    python -m benchmarks.sweep FOLDER -o OUT [--protocol nyu] [--processes 2]

One file a frame, written whole or not at all; a second run goes on where the first one ended.
"""

from __future__ import annotations

import argparse
import math
import sys
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geohue.compute.lloyd import nearest_center
from geohue.compute.parallel import Workers
from geohue.jobs.pool import run_jobs
from geohue.measures.crop import PROTOCOLS, Crop
from geohue.ncut.cutter import Cutter
from geohue.ncut.labels import find_centers
from geohue.ncut.nystrom import NystromCut, nystrom_cut
from geohue.ncut.selectors import choose_k
from geohue.prepared import prepare_scene
from geohue.regions.images import merge_small_regions
from geohue.results.atomic import atomic_write
from geohue.scene import Scene
from geohue.settings import PRESETS
from geohue.settings.cut import SELECTORS
from geohue.studies.benchmark.frames import find_frames, load_frame
from geohue.studies.items import Item

SEED = 0
WEIGHTS = (0.0, *(2.0 ** (e / 2) for e in range(-8, 9)), math.inf)
"""Colour alone, half octaves from 1/16 to 16, geometry alone."""

KS = tuple(range(2, 11))
"""What the selectors may choose."""


@dataclass(frozen=True, slots=True, eq=False)
class Sweep:
    """The segmentations of one frame's draft.

    Attributes
    ----------
    labels : (len(WEIGHTS), len(KS), h, w) int8
        -1 where there is no label.
    truth : (h, w) int32
        0 where there is no label.
    positions : (h, w) int64
        The draft's pixels in the frame (`Scene.thinning`).
    eigenvalues : (len(WEIGHTS), K_MAX + 1) float64
        Of the normalized affinity.
    chosen : (len(SELECTORS),) int64
        K by each selector at weight 1, as the driver asks them.
    """

    labels: NDArray[np.int8]
    truth: NDArray[np.int32]
    positions: NDArray[np.int64]
    eigenvalues: NDArray[np.float64]
    chosen: NDArray[np.int64]


def sweep(scene: Scene, truth: NDArray[np.int32], seed: int = SEED) -> Sweep:
    """Segment the draft of a scene for all WEIGHTS and KS with the preset of the paper."""
    settings, team = PRESETS["paper"], Workers(None)
    prepared, most = prepare_scene(scene, settings, seed=seed), settings.cut.k_max
    draft, features = prepared.positions, prepared.draft_features
    cutter = Cutter(prepared, most)
    labels = np.empty((len(WEIGHTS), len(KS), *draft.shape), np.int8)
    eigenvalues = np.zeros((len(WEIGHTS), most + 1))
    chosen = np.zeros(len(SELECTORS), np.int64)
    least = max(1, round(settings.min_region * draft.size))
    for i, weight in enumerate(WEIGHTS):
        vectors = features.mixed(weight)
        landmarks = vectors[cutter._landmarks]
        cut = nystrom_cut(vectors, landmarks, team, most + 1, settings.cut.scale)
        eigenvalues[i, : len(cut.eigenvalues)] = cut.eigenvalues
        sample = vectors[:: -(-len(vectors) // settings.cut.center_points)]
        if weight == 1:
            chosen[:] = [choose_k(cut, sample, name, most) for name in SELECTORS]
        for j, k in enumerate(KS):
            rows = _cluster(cut, vectors, sample, k, seed)
            labels[i, j] = merge_small_regions(features.to_scene(rows), least)
    return Sweep(labels, truth.reshape(-1)[draft], draft, eigenvalues, chosen)


def _cluster(
    cut: NystromCut, vectors: NDArray[np.float32], sample: NDArray[np.float32], k: int, seed: int
) -> NDArray[np.int32]:
    k = min(k, cut.basis.shape[1])
    rng = np.random.default_rng((seed, 1))
    centers = find_centers(cut.rows(sample, k), k, PRESETS["paper"].cut.labelling, rng)
    return nearest_center(cut.rows(vectors, k), centers)


def save(frame: Item, out: Path, crop: Crop | None) -> str:
    """Sweep a frame and write the result."""
    result = sweep(*load_frame(frame, crop))
    with atomic_write(out / f"{frame.name}.npz") as temporary:
        np.savez_compressed(
            temporary,
            labels=result.labels,
            truth=result.truth,
            positions=result.positions,
            eigenvalues=result.eigenvalues,
            chosen=result.chosen,
        )
    return frame.name


def load(path: Path) -> Sweep:
    """Read what `save` wrote."""
    with np.load(path) as stored:
        return Sweep(**{name: stored[name] for name in stored.files})


def main() -> None:
    """Sweep the frames of a folder."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("-o", "--out", type=Path, required=True)
    parser.add_argument("--protocol", choices=sorted(PROTOCOLS))
    parser.add_argument("--limit", type=int)
    parser.add_argument("--processes", type=int, default=2)
    given = parser.parse_args()
    crop = PROTOCOLS.get(given.protocol)
    frames = find_frames(given.folder, given.limit)
    jobs = [frame for frame in frames if not (given.out / f"{frame.name}.npz").exists()]
    work = partial(save, out=given.out, crop=crop)
    for done, outcome in enumerate(run_jobs(work, jobs, given.processes), start=1):
        print(f"{done}/{len(jobs)} {outcome.job.name} {outcome.error or ''}", file=sys.stderr)


if __name__ == "__main__":
    main()
