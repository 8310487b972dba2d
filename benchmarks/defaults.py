"""Quality of the presets on the frames and clouds that nothing was fitted on.

    python -m benchmarks.defaults DATA [--part test] [--every 1] [--presets paper fast best]

DATA has the folders nyuv2, mosd, maize and rooms. Frames of NYU are cut to the valid crop before
they are segmented; pixels with the true label 0 are left out; each connected piece of a frame's
segments counts as a region, a cloud's segments count as they are. mOSD frames come a second time as
clouds: their points in random order. A room has no colour (``cues="geometry"``). Prints means with
their standard errors, and the median seconds.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from benchmarks.splits import part
from numpy.typing import NDArray

from geohue import GeohueError, Scene, Segmentation, segment
from geohue.measures.contingency import contingency_table
from geohue.measures.crop import PROTOCOLS
from geohue.measures.partition import covering_of, information_of, rand_of
from geohue.read.clouds.cloud import read_cloud
from geohue.regions.images import connected_components
from geohue.studies.benchmark.frames import find_frames, load_frame


class Case(NamedTuple):
    """A scene with its true labels, 0 = none, and the cues it has."""

    scene: Scene
    truth: NDArray[np.int32]
    cues: str = "fusion"


def frames(data: Path, folder: str, which: str, every: int) -> Iterator[Case]:
    """Labelled frames of a data set."""
    names = set(part(folder, which)[::every])  # type: ignore[arg-type]
    crop = PROTOCOLS["nyu"] if folder == "nyuv2" else None
    for frame in find_frames(data / folder):
        if frame.name in names:
            yield Case(*load_frame(frame, crop))


def as_clouds(cases: Iterator[Case]) -> Iterator[Case]:
    """Frames as clouds, their points in random order."""
    for scene, truth, cues in cases:
        known = np.flatnonzero(scene.valid)
        order = np.random.default_rng(0).permutation(known)
        points, colors = scene.points.reshape(-1, 3)[order], scene.colors.reshape(-1, 3)[order]
        yield Case(Scene.from_cloud(points, colors), truth.reshape(-1)[order], cues)


def clouds(data: Path, folder: str, which: str) -> Iterator[Case]:
    """Labelled clouds: PLY with the property ``label``, with or without colours."""
    for name in part(folder, which):  # type: ignore[arg-type]
        cloud = read_cloud(data / folder / f"{name}.ply")
        if cloud.labels is None:
            raise GeohueError(f"{name}.ply: no labels")
        gray = np.full(cloud.points.shape, 128, np.uint8)
        scene = Scene.from_cloud(cloud.points, gray if cloud.colors is None else cloud.colors)
        yield Case(scene, cloud.labels, "geometry" if cloud.colors is None else "fusion")


def score(seg: Segmentation, truth: NDArray[np.int32]) -> tuple[float, ...]:
    """VoI in bits, Rand, covering, number of segments and seconds."""
    pieces = connected_components(seg.labels) if seg.labels.ndim == 2 else seg.labels
    table = contingency_table(pieces, truth)
    measures = information_of(table).total, rand_of(table), covering_of(table)
    return (*measures, float(seg.k), seg.timings["total"])


def main() -> None:
    """Print a row for each preset and kind of scene."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path)
    parser.add_argument("--part", choices=("fit", "test"), default="test")
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--presets", nargs="+", default=["paper", "fast", "best"])
    given = parser.parse_args()
    data, which, every = given.data, given.part, given.every
    kinds: dict[str, Callable[[], Iterator[Case]]] = {
        "nyuv2": lambda: frames(data, "nyuv2", which, every),
        "mosd": lambda: frames(data, "mosd", which, every),
        "mosd as clouds": lambda: as_clouds(frames(data, "mosd", which, every)),
        "maize": lambda: clouds(data, "maize", which),
        "rooms": lambda: clouds(data, "rooms", which),
    }
    print("| scenes | preset | n | VoI (bits) | Rand | covering | K | s |")
    print("|---|---|--:|--:|--:|--:|--:|--:|")
    for kind, cases in kinds.items():
        rows: dict[str, list[tuple[float, ...]]] = {preset: [] for preset in given.presets}
        for scene, truth, cues in cases():
            for preset, found in rows.items():
                found.append(score(segment(scene, preset=preset, cues=cues), truth))
        for preset, found in rows.items():
            if found:
                print(row(kind, preset, np.array(found)), flush=True)


def row(kind: str, preset: str, found: NDArray[np.float64]) -> str:
    """Means and standard errors of a preset's scores as a row of the table."""
    n = len(found)
    mean, error = found.mean(axis=0), found.std(axis=0) / np.sqrt(n)
    cells = [f"{mean[i]:.3f} ± {error[i]:.3f}" for i in range(3)]
    last = [f"{mean[3]:.1f}", f"{np.median(found[:, 4]):.2f}"]
    return "| " + " | ".join([kind, preset, str(n), *cells, *last]) + " |"


if __name__ == "__main__":
    main()
