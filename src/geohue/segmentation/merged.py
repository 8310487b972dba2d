"""Beyond the paper: the scene as nested levels of regions that belong together."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.consensus.cut import checked_maps
from geohue.consensus.voters import CutVoter, Voter, make_voters
from geohue.errors import GeohueError
from geohue.merge.branching import find_branches
from geohue.merge.carry import carry
from geohue.merge.draft import cues_of, merge_draft, merge_limbs
from geohue.merge.levels import Detail, threshold_of
from geohue.merge.score import Cues
from geohue.merge.shares import BorderShares, border_shares
from geohue.merge.tree import MergeTree
from geohue.ncut.cutter import Cutter
from geohue.prepared import PreparedScene
from geohue.regions.graph import PairGraph
from geohue.segmentation.outcome import Outcome
from geohue.segmentation.result import StageClock
from geohue.weight.likeness import distances_from

Labels = NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class MergedDraft:
    """The draft of a scene in its regions.

    Attributes
    ----------
    prepared : PreparedScene
        The scene; the points of its draft all have a region.
    cues : {"fusion", "color", "geometry"}
        What the regions go by.
    regions : int32, shape of the draft
        Fine regions 0..R-1.
    tree : MergeTree
        Their merges.
    chosen : (R,) int32
        The segment of each region in the level that was asked for.
    weight : float
        The paper's lambda of the voter whose maps are most like these segments.
    shares : BorderShares or None
        The votes along the borders of the regions; None where no cut voted.
    """

    prepared: PreparedScene
    cues: Cues
    regions: Labels
    tree: MergeTree
    chosen: Labels
    weight: float
    shares: BorderShares | None


def merge_scene(
    prepared: PreparedScene, k: int | None, detail: Detail, clock: StageClock
) -> Outcome:
    """Let many cuts vote, merge fine regions on all the evidence, and draw their borders.

    A cloud of thin branching parts falls into its limbs instead.

    Parameters
    ----------
    prepared : PreparedScene
        The scene.
    k : int or None
        Number of segments of the level to take; None for that of `detail`.
    detail : float or str
        Degree of detail (`threshold_of`).
    clock : StageClock
        Times the stages.

    Returns
    -------
    Outcome
    """
    draft = merge_points(prepared, k, detail, clock)
    prepared, cues = draft.prepared, draft.cues
    with clock.stage("borders"):
        lab = prepared.raw.lab if prepared.scene.is_grid and cues != "geometry" else None
        here = prepared.positions, prepared.scene, prepared.workers
        full = carry(draft.regions, draft.chosen, *here, cues, lab)
        full, tree, shares = _shown(full, draft.tree, draft.shares)
    segment_of = level_of(tree, k, detail)
    return Outcome(full, draft.weight, [], k, segment_of, tree, shares=shares)


def merge_points(
    prepared: PreparedScene, k: int | None, detail: Detail, clock: StageClock
) -> MergedDraft:
    """Do all of `merge_scene` that takes place on the draft; the arguments are the same."""
    prepared = placed(prepared)
    settings, features = prepared.settings, prepared.draft_features
    cues, smallest = cues_of(features), settings.consensus.smallest
    graph = PairGraph.of(prepared.draft, settings.min_region, smallest, cues == "color")
    with clock.stage("limbs"):
        limbs = _limbs(graph, k)
    with clock.stage("cuts"):
        weights, maps = ([], []) if limbs is not None else cut_votes(prepared, graph)
    with clock.stage("merge"):
        if limbs is None:
            regions, tree = merge_draft(graph, features, maps, k or 1)
        else:
            regions, tree = limbs, merge_limbs(graph, features, limbs)
        shares = border_shares(regions, maps, graph.one, graph.other) if maps else None
        chosen = level_of(tree, k, detail)
        weight = math.inf if limbs is not None else _most_like(chosen[regions], weights, maps)
    return MergedDraft(prepared, cues, regions, tree, chosen, weight, shares)


def level_of(tree: MergeTree, k: int | None, detail: Detail) -> Labels:
    """Return the segment of each region: of the level with k segments, else of the detail."""
    return tree.at(threshold_of(detail)) if k is None else tree.with_segments(k)


def _shown(
    regions: Labels, tree: MergeTree, shares: BorderShares | None
) -> tuple[Labels, MergeTree, BorderShares | None]:
    """Leave out regions without any point in the scene: in gaps, or lost to their neighbours."""
    kept = np.zeros(tree.n_regions, bool)
    kept[regions[regions >= 0]] = True
    if kept.all():
        return regions, tree, shares
    name = np.append(np.cumsum(kept, dtype=np.int32) - np.int32(1), np.int32(-1))
    return name[regions], tree.among(kept), None if shares is None else shares.among(kept)


def placed(prepared: PreparedScene) -> PreparedScene:
    """Leave points without a position out of the draft of a cloud, which has nothing else."""
    scene, positions = prepared.scene, prepared.positions
    if scene.is_grid or scene.valid[positions].all():
        return prepared
    positions = positions[scene.valid[positions]]
    if len(positions) == 0:
        raise GeohueError("no point has a position: check the cloud")
    return prepared.at(positions)


def _limbs(graph: PairGraph, k: int | None) -> Labels | None:
    """The limbs of a cloud of thin branching parts, unless more segments are asked for."""
    if graph.draft.is_grid:
        return None
    points = graph.draft.points.astype(np.float64)
    away = points[graph.other] - points[graph.one]
    length = np.sqrt((away**2).sum(axis=1))
    spacing = float(np.median(length[length > 0])) if (length > 0).any() else 0.0
    limbs = find_branches(points, graph.one, graph.other, spacing)
    return limbs if limbs is not None and (k is None or k <= limbs.max() + 1) else None


def cut_votes(prepared: PreparedScene, graph: PairGraph) -> tuple[list[float], list[Labels]]:
    """Return the weight of each segmentation that votes, and the segmentations themselves.

    Parameters
    ----------
    prepared : PreparedScene
        The scene; its settings of the merging say who votes.
    graph : PairGraph
        The points of its draft and their neighbours.

    Returns
    -------
    weights : list of float
    maps : list of int32 arrays, shape of the draft
    """
    settings, features, team = prepared.settings.merge, prepared.draft_features, prepared.workers
    counts = settings.cut_into(features.cues)
    cutter = Cutter(prepared, max(counts))
    voters: list[Voter]
    if features.is_fused:
        voters = make_voters(prepared, cutter, settings.panel, counts)
    else:
        voters = [CutVoter(cutter, 0.0 if features.uses("color") else math.inf, counts)]
    by_voter = list(team.map(lambda voter: checked_maps(voter, prepared), voters))
    weights = [voter.weight for voter, maps in zip(voters, by_voter, strict=True) for _ in maps]
    return weights, list(team.map(graph.tidied, [labels for maps in by_voter for labels in maps]))


def _most_like(labels: Labels, weights: list[float], maps: list[Labels]) -> float:
    """The weight of the voter whose maps are most like the segments."""
    if not maps:  # no voter can tell two points apart
        return 1.0
    distance = distances_from(labels, maps)
    mean = {w: distance[np.equal(weights, w)].mean() for w in weights if not math.isnan(w)}
    return float(min(mean, key=mean.__getitem__)) if mean else math.nan
