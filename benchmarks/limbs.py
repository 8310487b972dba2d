"""Limbs of thin branching clouds: how good they are, and which clouds pass for one.

    python -m benchmarks.limbs [--plants FOLDER] [--clouds FILE ...] [--frames FOLDER ...]
        [--limit 80] [--seeds 6]

Plants are PLY clouds with labels, 0 = none. Frames, RGB-D, are taken as clouds.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from geohue.measures import evaluate
from geohue.merge.branching import DRAFT, Branching, branching_evidence, near_pairs
from geohue.merge.limbs import Limbs, find_limbs
from geohue.read.clouds.cloud import read_cloud
from geohue.scene import Scene
from geohue.simulate.branching import BRANCHING, COMPACT, branching_cloud
from geohue.studies.benchmark.frames import find_frames, load_frame
from geohue.studies.items import Item

MEASURED = ("maize", "tree", "cables", "animal")
"""Simulated clouds whose limbs are scored."""

SIZES = (4000, 8000, 20_000)
"""Points of simulated clouds, in turn."""


def simulated(name: str, seed: int) -> tuple[Scene, NDArray[np.int32]]:
    """Return a simulated cloud as a scene, with its truth from 1."""
    points, truth = branching_cloud(name, SIZES[seed % len(SIZES)], seed)
    return Scene.from_cloud(points, np.zeros(points.shape, np.uint8)), truth + 1


def cloud(path: Path) -> tuple[Scene, NDArray[np.int32]]:
    """Read a cloud and its labels, 0 where it has none."""
    data = read_cloud(path)
    points = data.points.reshape(-1, 3)
    colors = np.zeros(points.shape, np.uint8) if data.colors is None else data.colors
    labels = np.zeros(len(points), np.int32) if data.labels is None else data.labels
    return Scene.from_cloud(points, colors.reshape(-1, 3)), labels.reshape(-1)


def simulated_scene(name: str, seed: int) -> Scene:
    """Return a simulated cloud without its truth."""
    return simulated(name, seed)[0]


def cloud_scene(path: Path) -> Scene:
    """Read a cloud without its labels."""
    return cloud(path)[0]


def frame_cloud(frame: Item) -> Scene:
    """Turn a frame into a cloud."""
    scene = load_frame(frame)[0]
    valid = scene.valid
    return Scene.from_cloud(scene.points[valid], scene.colors[valid])


def draft_of(scene: Scene, most: int, seed: int = 0) -> NDArray[np.float32]:
    """Draw the points of a draft."""
    draft = scene.thinning(most, np.random.default_rng(seed))
    return scene.points[draft[scene.valid[draft]]]


def scores(scene: Scene, truth: NDArray[np.int32], most: int = DRAFT) -> tuple[float, ...]:
    """Score the limbs of a draft, spread to all points; VoI, Rand, covering, segments, parts."""
    points = draft_of(scene, most)
    labels = find_limbs(points, *near_pairs(points)).labels
    valid = scene.valid
    _, nearest = cKDTree(points).query(scene.points[valid])
    found = evaluate(labels[np.asarray(nearest)], truth[valid])
    return tuple(found[name] for name in ("voi_bits", "rand", "covering", "n_pred", "n_gt"))


def quality(plants: list[Path], seeds: int) -> Iterator[str]:
    """Score labelled plants, whole and thinned, and simulated clouds."""
    yield "| cloud | VoI (bits) | Rand | covering | segments | parts |"
    yield "| --- | --: | --: | --: | --: | --: |"
    read = [cloud(path) for path in plants]
    for path, (scene, truth) in zip(plants, read, strict=True):
        yield _row(path.stem, [scores(scene, truth)])
    for part in (1, 2, 4):
        rows = [scores(scene, truth, min(DRAFT, scene.size) // part) for scene, truth in read]
        if rows:
            yield _row(f"mean of plants, 1/{part} of the points", rows)
    for name in MEASURED:
        yield _row(
            f"simulated {name}, {seeds}", [scores(*simulated(name, i)) for i in range(seeds)]
        )
    yield ""


def _row(name: str, rows: list[tuple[float, ...]]) -> str:
    voi, rand, covering, found, parts = np.mean(rows, axis=0)
    return f"| {name} | {voi:.3f} | {rand:.3f} | {covering:.3f} | {found:.1f} | {parts:.1f} |"


def decide(scene: Scene) -> tuple[Limbs, Branching, float]:
    """Find the limbs of a draft and judge them; seconds for both."""
    points = draft_of(scene, DRAFT)
    begin = time.perf_counter()
    limbs = find_limbs(points, *near_pairs(points))
    evidence = branching_evidence(points, limbs)
    return limbs, evidence, time.perf_counter() - begin


def decisions(groups: dict[str, list[Callable[[], Scene]]]) -> Iterator[str]:
    """Say for each group of clouds how many pass for branching, and how clearly."""
    yield "| clouds | pass | slim: least, most | again, of the slim: least, most | seconds, most |"
    yield "| --- | --: | --: | --: | --: |"
    for name, makers in groups.items():
        found = [decide(make()) for make in makers]
        slim = [evidence.slim for _, evidence, _ in found]
        again = [evidence.again for _, evidence, _ in found if evidence.again > 0] or [0.0]
        passed = sum(evidence.is_branching for _, evidence, _ in found)
        yield (
            f"| {name} | {passed} of {len(found)} | {min(slim):.2f}, {max(slim):.2f} "
            f"| {min(again):.2f}, {max(again):.2f} | {max(t for *_, t in found):.2f} |"
        )


def main() -> None:
    """Write both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--plants", type=Path)
    parser.add_argument("--clouds", type=Path, nargs="*", default=[])
    parser.add_argument("--frames", type=Path, nargs="*", default=[])
    parser.add_argument("--limit", type=int)
    parser.add_argument("--seeds", type=int, default=6)
    given = parser.parse_args()
    plants = sorted(given.plants.glob("*.ply")) if given.plants else []
    for line in quality(plants, given.seeds):
        print(line, flush=True)
    groups: dict[str, list[Callable[[], Scene]]] = {}
    for path in [*plants, *given.clouds]:
        groups[path.stem] = [partial(cloud_scene, path)]
    for name in BRANCHING | COMPACT:
        seeds = range(given.seeds)
        groups[f"simulated {name}"] = [partial(simulated_scene, name, i) for i in seeds]
    for folder in given.frames:
        frames = find_frames(folder, given.limit)
        groups[folder.name] = [partial(frame_cloud, frame) for frame in frames]
    for line in decisions(groups):
        print(line, flush=True)


if __name__ == "__main__":
    main()
