"""Time the measures of over-segmentations on a million points.

    python -m benchmarks.measures [--side 1000] [--repeats 5]

A square of side x side points cut into cells of 32 x 32, true regions of 250 x 200, once as a grid
and once as a cloud with five pairs of neighbours a point. Medians of wall-clock seconds.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from statistics import median
from time import perf_counter

import numpy as np

from geohue.measures.boundary import boundary_precision_recall_f
from geohue.measures.contingency import contingency_table
from geohue.measures.pairs import pair_boundary_precision_recall_f, pair_compactness
from geohue.measures.superpoints import compactness, explained_variation, superpoint_scores
from geohue.regions.adjacency import adjacent_pixels


def seconds(work: Callable[[], object], repeats: int) -> float:
    """Return the median time of a call, after one that is not counted."""
    work()
    times = []
    for _ in range(repeats):
        start = perf_counter()
        work()
        times.append(perf_counter() - start)
    return median(times)


def cases(side: int) -> dict[str, Callable[[], object]]:
    """Return the calls to time, by name."""
    y, x = np.mgrid[:side, :side]
    pred, gt = y // 32 * side + x // 32, 1 + y // 250 * side + x // 200
    values = np.random.default_rng(0).integers(0, 255, (side, side, 3))
    flat_pred, flat_gt, flat_values = pred.reshape(-1), gt.reshape(-1), values.reshape(-1, 3)
    one, other = (np.concatenate([e, e, e[: side * side]]) for e in adjacent_pixels(gt.shape))
    pairs = one, other
    return {
        "contingency table": lambda: contingency_table(pred, gt),
        "borders, grid": lambda: boundary_precision_recall_f(pred, gt, tolerance=4),
        "borders, cloud": lambda: pair_boundary_precision_recall_f(
            flat_pred, flat_gt, pairs, slack=1
        ),
        "compactness, grid": lambda: compactness(pred),
        "compactness, cloud": lambda: pair_compactness(flat_pred, pairs),
        "explained variation": lambda: explained_variation(pred, values),
        "all, grid": lambda: superpoint_scores(pred, gt, values=values),
        "all, cloud": lambda: superpoint_scores(
            flat_pred, flat_gt, pairs=pairs, values=flat_values
        ),
    }


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--side", type=int, default=1000)
    parser.add_argument("--repeats", type=int, default=5)
    given = parser.parse_args()
    print(f"| measure | seconds, {given.side * given.side} points |\n| --- | --: |")
    for name, work in cases(given.side).items():
        print(f"| {name} | {seconds(work, given.repeats):.3f} |")


if __name__ == "__main__":
    main()
