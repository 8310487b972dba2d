"""How far the labels of a cloud in pieces are those in memory.

    python -m benchmarks.pieces CLOUD [CLOUD ...] [--cues fusion] [--seeds 3]

A cloud of more than 100,000 points has one draft in memory and another in pieces, each drawn at
random. So the labels in pieces are compared with those in memory (a row of each seed), and those in
memory with each other from seed to seed: two random drafts differ no less. VoI in bits, Rand index.
"""

from __future__ import annotations

import argparse
import tempfile
from itertools import combinations
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geohue import segment, segment_file
from geohue.measures.contingency import contingency_table
from geohue.measures.partition import information_of, rand_of
from geohue.merge.levels import Levels
from geohue.read import read_levels
from geohue.read.scenes.scenes import read_scene

Labels = NDArray[np.int32]


def agreement(one: Labels, other: Labels) -> tuple[float, float]:
    """VoI in bits and the Rand index of two segmentations."""
    table = contingency_table(one, other + 1)
    return information_of(table).total, rand_of(table)


def in_pieces(cloud: Path, cues: str, seed: int) -> Levels:
    """Levels of a cloud in pieces."""
    with tempfile.TemporaryDirectory() as folder:
        segment_file(cloud, folder, cues=cues, seed=seed, processes=1)
        return read_levels(Path(folder) / "levels.npz")


def main() -> None:
    """Print a row for each cloud and degree of detail."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("clouds", type=Path, nargs="+")
    parser.add_argument("--cues", default="fusion")
    parser.add_argument("--seeds", type=int, default=3)
    given = parser.parse_args()
    print("| cloud | points | detail | segments | pieces: VoI / Rand | other seeds: VoI / Rand |")
    print("| --- | ---: | --- | --- | --- | --- |")
    for cloud in given.clouds:
        scene, whole = read_scene(cloud), []
        for seed in range(given.seeds):
            levels = segment(scene, cues=given.cues, seed=seed).levels
            assert levels is not None
            whole.append(levels)
        parts = [in_pieces(cloud, given.cues, seed) for seed in range(given.seeds)]
        for detail in ("coarse", "auto", "fine"):
            ours = [levels.at(detail) for levels in parts]
            theirs = [levels.at(detail) for levels in whole]
            here = np.array([agreement(*pair) for pair in zip(ours, theirs, strict=True)])
            others = np.array([agreement(*pair) for pair in combinations(theirs, 2)])
            counts = [
                f"{int(a.max()) + 1}/{int(b.max()) + 1}" for a, b in zip(ours, theirs, strict=True)
            ]
            cells = [
                f"{pairs[:, 0].mean():.3f} / {pairs[:, 1].mean():.3f}" for pairs in (here, others)
            ]
            name = cloud.name, str(scene.size), detail, ", ".join(counts)
            print("|", " | ".join((*name, *cells)), "|", flush=True)


if __name__ == "__main__":
    main()
