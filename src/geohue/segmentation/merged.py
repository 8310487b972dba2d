"""Beyond the paper: the scene as nested levels of regions that belong together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.compute.parallel import Workers
from geohue.errors import GeohueError
from geohue.features import Cues
from geohue.merge.carry import carry
from geohue.merge.draft import merge_draft
from geohue.merge.levels import Detail, Levels, threshold_of
from geohue.merge.tree import MergeTree
from geohue.ncut.cutter import Cutter
from geohue.regions.graph import PairGraph
from geohue.scene import Scene
from geohue.segmentation.presets import Preset
from geohue.segmentation.result import StageClock
from geohue.weight.likeness import distances_from

Labels = NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class Merged:
    """What the merging found.

    Attributes
    ----------
    levels : Levels
        Nested segmentations of the scene.
    segment_of : (R,) int32
        The segment of each of its finest regions in the level that was asked for.
    weight : float
        The voter whose cuts are most like that level.
    """

    levels: Levels
    segment_of: Labels
    weight: float

    @property
    def labels(self) -> Labels:
        """Segments of the level that was asked for, -1 = none."""
        return np.append(self.segment_of, np.int32(-1))[self.levels.regions]


def merge_scene(
    scene: Scene,
    cutter: Cutter,
    draft: NDArray[np.int64],
    settings: Preset,
    team: Workers,
    clock: StageClock,
    k: int | None,
    detail: Detail,
) -> Merged:
    """Let many cuts vote, merge fine regions on all the evidence, and draw their borders.

    Parameters
    ----------
    scene : Scene
        The scene.
    cutter : Cutter
        Its cuts.
    draft : int64
        The positions that were cut (`Scene.thinning`), all with a position in space if the scene
        is a cloud.
    settings : Preset
        The voters.
    team : Workers
        Threads to use.
    clock : StageClock
        Times the stages.
    k : int or None
        Number of segments of the level to take; None for that of `detail`.
    detail : float or str
        Degree of detail (`threshold_of`).

    Returns
    -------
    Merged
    """
    with clock.stage("cuts"):
        cues = cutter.draft.cues
        graph = PairGraph.of(scene.take(draft), settings.min_region, everywhere=cues == "color")
        weights, cuts = _votes(cutter, graph, settings, team)
    with clock.stage("merge"):
        regions, tree = merge_draft(graph, cutter.draft, cuts, k or 1)
        chosen = _level(tree, k, detail)
        weight = _most_like(chosen[regions], weights, cuts)
    with clock.stage("borders"):
        full = carry(regions, chosen, draft, scene, team, cues)
        full, tree = _shown(full, tree)
    return Merged(Levels(full, tree), _level(tree, k, detail), weight)


def _level(tree: MergeTree, k: int | None, detail: Detail) -> Labels:
    return tree.at(threshold_of(detail)) if k is None else tree.with_segments(k)


def _shown(regions: Labels, tree: MergeTree) -> tuple[Labels, MergeTree]:
    """Leave out regions without any point in the scene: in gaps, or lost to their neighbours."""
    kept = np.zeros(tree.n_regions, bool)
    kept[regions[regions >= 0]] = True
    if kept.all():
        return regions, tree
    name = np.append(np.cumsum(kept, dtype=np.int32) - np.int32(1), np.int32(-1))
    return name[regions], tree.among(kept)


def _votes(
    cutter: Cutter, graph: PairGraph, settings: Preset, team: Workers
) -> tuple[list[float], list[Labels]]:
    """The cuts that vote, and the weight of each."""
    cues = cutter.draft.cues
    voters = {"color": (0.0,), "geometry": (np.inf,)}.get(cues, settings.voters)
    counts = settings.voted(cues)
    jobs = [(weight, counts) for weight in voters]
    by_voter = list(team.map(lambda job: cutter.draft_cuts(*job), jobs))
    weights = [weight for weight, cuts in zip(voters, by_voter, strict=True) for _ in cuts]
    return weights, list(team.map(graph.tidied, [cut for cuts in by_voter for cut in cuts]))


def _most_like(labels: Labels, weights: list[float], cuts: list[Labels]) -> float:
    if not cuts:  # no voter can tell two points apart
        return 1.0
    distance = distances_from(labels, cuts)
    mean = {weight: distance[np.equal(weights, weight)].mean() for weight in weights}
    return min(mean, key=mean.__getitem__)


def with_position(draft: NDArray[np.int64], scene: Scene, cues: Cues) -> NDArray[np.int64]:
    """Leave points without a position out of the draft of a cloud, which has nothing else."""
    if scene.is_grid:
        return draft
    placed = draft[scene.valid[draft]]
    if len(placed) == 0:
        raise GeohueError(f"no point has a position: cues={cues!r} need a cloud's positions here")
    return placed
