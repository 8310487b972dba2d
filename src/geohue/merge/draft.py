"""From the draft of a scene and the cuts that vote to the tree of merges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from geohue.compute.blur import gaussian_blur
from geohue.consensus.cut import balanced_steps
from geohue.consensus.votes import count_votes
from geohue.features import Features, lab_of
from geohue.merge.evidence import Evidence, gather
from geohue.merge.greedy import merge_all
from geohue.merge.normals import cloud_normals, grid_normals
from geohue.merge.oversegment import SMALLEST, K, oversegment
from geohue.merge.score import Cues, color_share, constants
from geohue.merge.smooth import average
from geohue.merge.table import tabulate
from geohue.merge.tree import MergeTree
from geohue.regions.graph import PairGraph

BLUR = 0.5
"""Pixels of the draft that colours are blurred by before regions are begun."""

FAR = 4.0
"""Median distances of neighbours within which two pieces of a cloud may be one thing."""

FEWEST = 200
"""Regions that a draft of few points may have before these count as too small."""

Labels = NDArray[np.int32]
Floats = NDArray[np.float64]


def merge_draft(
    graph: PairGraph, features: Features, cuts: Sequence[Labels], least: int = 1
) -> tuple[Labels, MergeTree]:
    """Split a draft into fine regions and merge these on all the evidence.

    Parameters
    ----------
    graph : PairGraph
        The points and their neighbours.
    features : Features
        Of the draft.
    cuts : sequence of int32 arrays
        Segmentations of the draft that vote, as `PairGraph.tidied` gives them.
    least : int
        Fine regions there must be, if there are so many points.

    Returns
    -------
    regions : int32, shape of the draft
        Fine regions 0..R-1; pixels in gaps have one too.
    tree : MergeTree
        Their merges.
    """
    evidence, blurred = draft_evidence(graph, features, cuts)
    regions = first_regions(evidence, blurred, least)
    tree = _tree(evidence, regions, features)
    return regions.reshape(graph.draft.shape), tree


def merge_limbs(graph: PairGraph, features: Features, limbs: Labels) -> MergeTree:
    """Return the tree over the limbs of a branching cloud.

    Parameters
    ----------
    graph : PairGraph
        The points and their neighbours.
    features : Features
        Of the draft.
    limbs : (m,) int32
        Its limbs (`find_branches`), which all stay apart below the threshold 0.

    Returns
    -------
    MergeTree
    """
    tree = _tree(draft_evidence(graph, features, [])[0], limbs, features)
    return replace(tree, scores=np.maximum(tree.scores, 0.0))


def _tree(evidence: Evidence, regions: Labels, features: Features) -> MergeTree:
    weights = constants(_share(features, evidence, regions), cues_of(features))
    merges, scores = merge_all(tabulate(evidence, regions), weights)
    return MergeTree(int(regions.max(initial=-1)) + 1, merges, scores)


def first_regions(evidence: Evidence, lab: Floats, least: int = 1) -> Labels:
    """Split a draft into fine regions, finer ones where a plain scene falls into too few.

    Parameters
    ----------
    evidence : Evidence
        Points and pairs of neighbours.
    lab : (n, 3) float64
        CIELab with the noise of single pixels blurred.
    least : int
        Fine regions there must be, if there are so many points.

    Returns
    -------
    (n,) int32
        Regions 0..R-1.
    """
    n, k = len(lab), K
    regions = oversegment(evidence, lab, k, min(SMALLEST, max(1, n // FEWEST)))
    while int(regions.max(initial=-1)) + 1 < min(least, n) and k > 0:
        k = k / 4 if k > 1e-3 else 0.0
        regions = oversegment(evidence, lab, k, 1)
    return regions


def cues_of(features: Features) -> Cues:
    """Return which of colour and geometry take part, whatever further cues there are."""
    if features.is_fused:
        return "fusion"
    return "color" if features.uses("color") else "geometry"


def _share(features: Features, evidence: Evidence, regions: Labels) -> float:
    return color_share(evidence.lab, regions) if features.uses("color") else 0.0


def draft_evidence(
    graph: PairGraph, features: Features, cuts: Sequence[Labels]
) -> tuple[Evidence, Floats]:
    """Gather what the merging goes by, and the colours that regions are begun with.

    Parameters
    ----------
    graph, features, cuts
        As in `merge_draft`.

    Returns
    -------
    evidence : Evidence
    lab : (n, 3) float64
        CIELab with the noise of single pixels blurred; zeros where colour takes no part.
    """
    draft = graph.draft
    one, other, far = graph.close_pairs(FAR, SMALLEST)
    lab = lab_of(draft.colors).astype(np.float64)
    if not features.uses("color"):
        lab[:] = 0
    blurred = _blurred(lab) if draft.is_grid else _averaged(lab, one, other)
    points, depth = _points(graph, features)
    normals = grid_normals(points) if draft.is_grid else cloud_normals(points)
    flat = [cut.reshape(-1) for cut in cuts]
    evidence = gather(
        lab.reshape(-1, 3),
        points.reshape(-1, 3),
        normals.reshape(-1, 3),
        depth,
        one,
        other,
        count_votes(flat, one, other),
        _steps(graph, features, one, other),
        flat,
        far,
    )
    return evidence, blurred.reshape(-1, 3)


def _points(graph: PairGraph, features: Features) -> tuple[Floats, Floats | None]:
    """Positions of all points, those in gaps as the nearest ones have it, and their depth."""
    draft = graph.draft
    if not features.uses("geometry") and draft.is_grid:
        # The plane of the image: no form, but extent.
        y, x = np.indices(draft.shape)
        return np.stack([x, y, 0 * x], axis=-1).astype(np.float64), None
    points = draft.points.astype(np.float64)
    if graph.near is None:
        return points, None
    filled = points.reshape(-1, 3)[graph.near]
    depth = None if draft.depth is None else filled[..., 2].reshape(-1)
    return filled, depth


def _steps(
    graph: PairGraph, features: Features, one: NDArray[np.int64], other: NDArray[np.int64]
) -> Floats:
    if graph.near is not None:
        near = graph.near.reshape(-1)
        one, other = near[one], near[other]
    return balanced_steps(features, one, other).astype(np.float64)


def _averaged(lab: Floats, one: NDArray[np.int64], other: NDArray[np.int64]) -> Floats:
    """The mean of each point of a cloud and its neighbours: colours of single points are noisy."""
    n, into = len(lab), np.empty_like(lab)
    average(
        lab,
        one,
        other,
        1.0 / (1 + np.bincount(one, minlength=n) + np.bincount(other, minlength=n)),
        into,
    )
    return into


def _blurred(lab: Floats) -> Floats:
    for axis in (0, 1):
        lab = gaussian_blur(lab, BLUR, axis)
    return lab
