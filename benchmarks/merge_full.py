"""How good the merging is on whole scenes of the test part, through `geohue.segment`.

    python -m benchmarks.merge_full DATA [SET ...] [--preset best] [--every 1] [--cues fusion]

Sets: nyuv2 (valid crop, connected pieces), mosd (labels_object.png), mosd-cloud (the frames as
shuffled clouds), rooms (geometry alone), maize. Points without a true label are left out.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from time import perf_counter

import numpy as np
from benchmarks.merge_frames import load, names

import geohue
from geohue.measures.contingency import contingency_table
from geohue.measures.partition import covering_of, information_of, rand_of
from geohue.regions.images import connected_components


def scores(name: str, data: Path, preset: str, cues: str, seed: int) -> list[float]:
    """Segment one scene: VoI, Rand, covering, number of segments, seconds."""
    scene, truth = load(name, data)
    start = perf_counter()
    found = geohue.segment(scene, preset=preset, cues=cues, seed=seed)
    took = perf_counter() - start
    labels = connected_components(found.labels) if scene.is_grid else found.labels
    table = contingency_table(labels, truth)
    return [information_of(table).total, rand_of(table), covering_of(table), found.k, took]


def main() -> None:
    """Print a row for each set."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path)
    parser.add_argument("sets", nargs="*", default=["nyuv2", "mosd", "mosd-cloud", "rooms"])
    parser.add_argument("--preset", default="best")
    parser.add_argument("--cues", default="fusion")
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--seeds", type=int, default=1)
    given = parser.parse_args()
    print("| set | n | VoI | Rand | covering | segments | seconds |\n| --- " + "| --: " * 6 + "|")
    for folder in given.sets:
        cues = "geometry" if folder == "rooms" else given.cues
        groups = (
            [[name] for name in names(folder, "test")]
            if folder == "rooms"
            else [names(folder, "test")[:: given.every]]
        )
        for group in groups:
            got = np.array(
                [
                    scores(name, given.data, given.preset, cues, seed)
                    for name in group
                    for seed in range(given.seeds)
                ]
            )
            mean, error = got.mean(axis=0), got.std(axis=0) / np.sqrt(max(len(got) - 1, 1))
            cells = [f"{m:.3f} +- {e:.3f}" for m, e in zip(mean[:3], error[:3], strict=True)]
            title = group[0] if folder == "rooms" else folder
            print(
                f"| {title}, {cues} | {len(got)} | {' | '.join(cells)} | {mean[3]:.1f} | "
                f"{np.median(got[:, 4]):.2f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
