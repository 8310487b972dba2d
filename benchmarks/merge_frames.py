"""Labelled scenes as the merging sees them: the fine regions of a draft, and what is known of them.

A scene has a name such as ``nyuv2/0003``, ``mosd/learn0`` or ``simulated/boxes-kinect-0``; a table
top as a shuffled cloud is ``mosd-cloud/learn0``, a room without colours ``rooms/room2_gt_fine``.
"""

from __future__ import annotations

import pickle
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from unittest.mock import patch

import numpy as np
from benchmarks.splits import Part, part
from numpy.typing import NDArray

from geohue.compute.parallel import workers
from geohue.consensus.votes import count_votes
from geohue.measures.crop import PROTOCOLS
from geohue.merge import smooth
from geohue.merge.draft import draft_evidence, first_regions
from geohue.merge.evidence import Evidence
from geohue.merge.score import Cues, color_share
from geohue.merge.table import Table, tabulate
from geohue.prepared import prepare_scene
from geohue.read.clouds.cloud import read_cloud
from geohue.regions.graph import PairGraph
from geohue.scene import Scene
from geohue.segmentation.merged import cut_votes, placed
from geohue.settings import preset_named
from geohue.simulate import SENSORS, WORLDS
from geohue.simulate import scene as simulated
from geohue.studies.benchmark.frames import find_frames, load_frame

VARIANTS = ("all", "9 cuts", "no votes", "no smoothing")
"""What the regions and tables are made of; the first one is what the library does."""

FEW = (4, 8, 12)
"""Numbers of segments of the 9 cuts, three for each voter."""

Labels = NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class Example:
    """The draft of a labelled scene.

    Attributes
    ----------
    regions : (n,) int32
        Its fine regions.
    truth : (n,) int32
        True segments; 0 is none.
    table : Table
        What is known of the regions.
    share : float
        How much colour says (`color_share`).
    """

    regions: Labels
    truth: Labels
    table: Table
    share: float


def names(folder: str, wanted: Part) -> list[str]:
    """Names of the scenes of a folder that belong to a part of the split."""
    return [f"{folder}/{name}" for name in part(folder.removesuffix("-cloud"), wanted)]


def simulated_names(seeds: int) -> list[str]:
    """Names of all simulated scenes, seen by all sensors."""
    return [
        f"simulated/{world}-{sensor}-{seed}"
        for world in WORLDS
        for sensor in SENSORS
        for seed in range(seeds)
    ]


def load(name: str, data: Path) -> tuple[Scene, Labels]:
    """Read a scene and its true labels, 0 = none."""
    folder, _, single = name.partition("/")
    if folder == "simulated":
        world, sensor, seed = single.split("-")
        scene, truth = simulated(world, sensor, seed=int(seed))
        return scene, truth + np.int32(1)
    if folder in ("rooms", "maize"):
        cloud = read_cloud(data / folder / f"{single}.ply")
        assert cloud.labels is not None
        colors = np.full((len(cloud.points), 3), 128, np.uint8)
        given = colors if cloud.colors is None else cloud.colors
        return Scene.from_cloud(cloud.points, given), cloud.labels.astype(np.int32)
    frames = find_frames(data / folder.removesuffix("-cloud"))
    frame = next(each for each in frames if each.name == single)
    scene, truth = load_frame(frame, PROTOCOLS["nyu"] if folder == "nyuv2" else None)
    if not folder.endswith("-cloud"):
        return scene, truth
    order = np.random.default_rng(0).permutation(np.flatnonzero(scene.valid))
    points, colors = scene.points.reshape(-1, 3)[order], scene.colors.reshape(-1, 3)[order]
    return Scene.from_cloud(points, colors), truth.reshape(-1)[order]


def examples_of(scene: Scene, truth: Labels, cues: Cues, seed: int = 0) -> dict[str, Example]:
    """Cut a scene as the preset best does, and tabulate its fine regions in all variants."""
    settings = preset_named("best")
    with workers(1) as team:
        prepared = placed(prepare_scene(scene, settings, cues, seed, team))
        smallest = settings.consensus.smallest
        graph = PairGraph.of(prepared.draft, settings.min_region, smallest, cues == "color")
        _, cuts = cut_votes(prepared, graph)
    evidence, lab = draft_evidence(graph, prepared.draft_features, cuts)
    known = truth.reshape(-1)[prepared.positions.reshape(-1)]
    made = {}
    for variant in VARIANTS if cues == "fusion" else VARIANTS[:1]:
        varied = _varied(evidence, variant)
        regions = first_regions(varied, lab)
        with patch.object(smooth, "ROUNDS", 0 if variant == "no smoothing" else smooth.ROUNDS):
            table = tabulate(varied, regions)
        share = 0.0 if cues == "geometry" else color_share(evidence.lab, regions)
        made[variant] = Example(regions, known, table, share)
    return made


def _varied(evidence: Evidence, variant: str) -> Evidence:
    if variant not in ("9 cuts", "no votes"):
        return evidence
    per_voter = len(preset_named("best").merge.counts)
    kept = [
        cut
        for i, cut in enumerate(evidence.cuts)
        if variant == "9 cuts" and preset_named("best").merge.counts[i % per_voter] in FEW
    ]
    share = count_votes(kept, evidence.one, evidence.other) if kept else 0 * evidence.share
    return replace(evidence, cuts=kept, share=share)


def gather_examples(
    wanted: Sequence[str], data: Path, store: Path, cues: Cues = "fusion", processes: int = 2
) -> list[dict[str, Example]]:
    """Return the examples of many scenes, in their order.

    Parameters
    ----------
    wanted : sequence of str
        Names of scenes.
    data : Path
        The folder of the data sets.
    store : Path
        A folder that keeps examples for the next run. It does not see when the code changes.
    cues : {"fusion", "color", "geometry"}
        What to go by.
    processes : int
        How many work at the same time.
    """
    missing = [name for name in wanted if not _file(store, name, cues).exists()]
    with ProcessPoolExecutor(processes) as pool:
        list(pool.map(partial(_keep, data=data, store=store, cues=cues), missing))
    return [pickle.loads(_file(store, name, cues).read_bytes()) for name in wanted]


def _file(store: Path, name: str, cues: Cues) -> Path:
    return store / cues / f"{name.replace('/', '-')}.pickle"


def _keep(name: str, data: Path, store: Path, cues: Cues) -> None:
    file = _file(store, name, cues)
    file.parent.mkdir(parents=True, exist_ok=True)
    made = pickle.dumps(examples_of(*load(name, data), cues))
    file.with_suffix(".part").write_bytes(made)
    file.with_suffix(".part").rename(file)
