"""The fill of the Appendix and the watershed: time, and how often hidden labels come back.

    python -m benchmarks.fills DENSE HOLES [--limit 24]

Frames of DENSE (nyuv2, no gaps) are segmented; the gaps of frames of HOLES (mosd) are cut out of
these labels, and out of the true ones, and filled again. Printed: the share of the hidden pixels
that get their own label back, with the standard error of the difference, and the median time.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from time import perf_counter

import numpy as np

import geohue
from geohue.features import lab_of
from geohue.fill import fill_labels
from geohue.fill.flood import flood_labels
from geohue.studies.benchmark.frames import find_frames, load_frame


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("dense", type=Path)
    parser.add_argument("holes", type=Path)
    parser.add_argument("--limit", type=int, default=24)
    given = parser.parse_args()
    gaps = [~load_frame(frame, None)[0].valid for frame in find_frames(given.holes, given.limit)]
    shares: dict[str, list[tuple[float, float]]] = {"of a segmentation": [], "of the truth": []}
    seconds = []
    for frame, gap in zip(find_frames(given.dense, len(gaps)), gaps, strict=True):
        scene, truth = load_frame(frame, None)
        mine = geohue.segment(scene, 6, preset="fast").labels
        for name, labels in zip(shares, (mine, truth - 1), strict=True):
            hidden, cut = gap & (labels >= 0), np.where(gap, -1, labels).astype(np.int32)
            start = perf_counter()
            slow = fill_labels(cut, lab_of(scene.colors))
            middle = perf_counter()
            quick = flood_labels(cut, scene.colors)
            seconds.append((middle - start, perf_counter() - middle))
            right = [float((found == labels)[hidden].mean()) for found in (slow, quick)]
            shares[name].append((right[0], right[1]))
    print("| hidden labels | Appendix | watershed | difference |\n| --- | ---: | ---: | ---: |")
    for name, pairs in shares.items():
        step = np.subtract(*np.transpose(pairs)[::-1])
        error = step.std() / np.sqrt(len(step))
        slow_mean, quick_mean = np.mean(pairs, axis=0)
        print(f"| {name} | {slow_mean:.3f} | {quick_mean:.3f} | {step.mean():+.3f} ± {error:.3f} |")
    print("| ms | {:.0f} | {:.0f} | |".format(*(1000 * np.median(seconds, axis=0))))


if __name__ == "__main__":
    main()
