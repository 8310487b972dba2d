"""The frames that the default does worst on, beside the truth.

    python -m benchmarks.worst DATA -o FOLDER [--sets nyuv2 mosd] [--part test] [--count 6]

Prints the variation of information of each, its two parts and the numbers of segments. Writes one
picture for each data set, worst frame first: the scene, its segments, the true ones.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from benchmarks.splits import part
from numpy.typing import NDArray

from geohue import Scene, segment
from geohue.measures.contingency import contingency_table
from geohue.measures.crop import PROTOCOLS
from geohue.measures.partition import VariationOfInformation, information_of
from geohue.regions.images import connected_components
from geohue.results.picture import overlay
from geohue.studies.benchmark.frames import find_frames, load_frame


class Row(NamedTuple):
    """What is known of a frame, and its picture."""

    name: str
    information: VariationOfInformation
    found: int
    true: int
    picture: NDArray[np.uint8]


def looked_at(name: str, scene: Scene, truth: NDArray[np.int32]) -> Row:
    """Segment a frame, measure and draw it."""
    seg = segment(scene)
    information = information_of(contingency_table(connected_components(seg.labels), truth))
    views = [scene.colors, overlay(scene.colors, seg.labels), overlay(scene.colors, truth - 1)]
    n_true = len(np.unique(truth[truth > 0]))
    return Row(name, information, seg.k, n_true, np.hstack(views))


def measured(data: Path, folder: str, which: str) -> list[Row]:
    """Look at all frames of a part of a data set, the worst first."""
    names = part(folder, which)  # type: ignore[arg-type]
    crop = PROTOCOLS["nyu"] if folder == "nyuv2" else None
    rows = [
        looked_at(frame.name, *load_frame(frame, crop)[:2])
        for frame in find_frames(data / folder)
        if frame.name in names
    ]
    return sorted(rows, key=lambda row: -row.information.total)


def main() -> None:
    """Print and draw."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--sets", nargs="+", default=["nyuv2", "mosd"])
    parser.add_argument("--part", default="test")
    parser.add_argument("--count", type=int, default=6)
    given = parser.parse_args()
    given.output.mkdir(parents=True, exist_ok=True)
    for folder in given.sets:
        rows = measured(given.data, folder, given.part)
        middle = float(np.median([row.information.total for row in rows]))
        print(f"{folder}: {len(rows)} frames, median {middle:.3f} bits")
        for row in rows[: given.count]:
            total, over, under = row.information
            print(f"  {row.name}: {total:.2f} bits, too many {over:.2f}, too few {under:.2f};")
            print(f"      {row.found} segments, true {row.true}")
        drawn = np.vstack([row.picture for row in rows[: given.count]])
        cv2.imwrite(str(given.output / f"{folder}.png"), drawn[..., ::-1])


if __name__ == "__main__":
    main()
