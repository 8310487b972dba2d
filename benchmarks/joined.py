"""Scores of a benchmark's segmentations with small regions joined to their neighbours, for all.

    python -m benchmarks.joined FOLDER RUN [--protocol nyu] [--share 0.002] [--least 30] [--limit N]

RUN is the folder of a ``geohue benchmark`` over the frames of FOLDER. Compared systems keep regions
of a few pixels, which VoI and covering count in full and the paper's method merges: here every
method's regions below a share of the frame take the label they border most. Trials with fewer than
`--least` frames are left out, and all others are compared on the frames that all of them have.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geohue.measures.contingency import contingency_table
from geohue.measures.crop import PROTOCOLS
from geohue.measures.partition import covering_of, information_of, rand_of
from geohue.read.images.pictures import read_labels
from geohue.regions.images import connected_components, merge_small_regions
from geohue.studies.benchmark.frames import find_frames, load_frame

MEASURES = ("VoI (bits)", "Rand", "covering", "K")


def score(file: Path, truth: NDArray[np.int32], share: float) -> tuple[float, float, float, float]:
    """Return VoI, Rand, covering and the number of regions of a label file, tidied."""
    labels = connected_components(read_labels(file) - 1)  # 0 in the file is none
    joined = merge_small_regions(labels, round(share * labels.size))
    table = contingency_table(joined, truth)
    found = float(len(table.pred_labels))
    return information_of(table).total, rand_of(table), covering_of(table), found


def main() -> None:
    """Print the table, best VoI first."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("run", type=Path)
    parser.add_argument("--protocol", choices=sorted(PROTOCOLS))
    parser.add_argument("--share", type=float, default=0.002)
    parser.add_argument("--least", type=int, default=30)
    parser.add_argument("--limit", type=int)
    given = parser.parse_args()
    trials = {
        folder.name: {file.stem for file in folder.glob("*.png")}
        for folder in sorted((given.run / "labels").iterdir())
    }
    trials = {name: frames for name, frames in trials.items() if len(frames) >= given.least}
    frames = find_frames(given.folder, given.limit)
    common = set.intersection({frame.name for frame in frames}, *trials.values())
    scores: dict[str, list[tuple[float, ...]]] = {name: [] for name in trials}
    for frame in frames:
        if frame.name not in common:
            continue
        _, truth = load_frame(frame, PROTOCOLS.get(given.protocol or ""))
        for name, rows in scores.items():
            file = given.run / "labels" / name / f"{frame.name}.png"
            rows.append(score(file, truth, given.share))
    print(f"{len(common)} frames, regions below {given.share:.1%} joined.\n")
    print("| method | " + " | ".join(MEASURES) + " |")
    print("| --- |" + " --: |" * len(MEASURES))
    means = {name: np.mean(rows, axis=0) for name, rows in scores.items()}
    for name, (voi, rand, covering, k) in sorted(means.items(), key=lambda item: item[1][0]):
        print(f"| {name} | {voi:.3f} | {rand:.3f} | {covering:.3f} | {k:.1f} |")


if __name__ == "__main__":
    main()
