"""A segmentation that many cuts agree on, with no weight and no number of segments to choose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.compute.parallel import Workers
from geohue.consensus.contrast import join_faint
from geohue.consensus.votes import count_votes, join_by_votes
from geohue.features import Features
from geohue.ncut.cutter import Cutter
from geohue.regions.graph import PairGraph
from geohue.scene import Scene
from geohue.weight.likeness import distances_from
from geohue.weight.search import BALANCES

LEAST = 0.15
"""Share of the cuts that must draw a border for it to stay."""

CLEAR = 0.6
"""Share times contrast that it must have (`join_faint`)."""

Labels = NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class Consensus:
    """What the cuts agree on.

    Attributes
    ----------
    labels : (h, w) or (m,) int32
        Segments of the draft, connected but for gaps; -1 where it has no point.
    weight : float
        The voter whose cuts are most like them.
    """

    labels: Labels
    weight: float


def find_consensus(
    cutter: Cutter,
    draft: Scene,
    k_max: int,
    min_region: float,
    workers: Workers,
    voters: Sequence[float] = BALANCES,
    least: float = LEAST,
    clear: float = CLEAR,
) -> Consensus:
    """Cut the draft by several weights into 2 to `k_max` segments each, and keep what they share.

    Each cut votes for its borders, those of small regions left out. Neighbouring points are joined
    while fewer than `least` of the cuts part them (`join_by_votes`), then the regions between which
    there is little to be seen (`join_faint`).

    Parameters
    ----------
    cutter : Cutter
        The cuts.
    draft : Scene
        The points that they cut.
    k_max : int
        Most segments of one cut; the consensus can have more.
    min_region : float
        Share of the points below which a region joins what is around it; `SMALLEST` at the least.
    workers : Workers
        Threads to use.
    voters : sequence of float
        The weights, 0 to infinity.
    least : float
        Share of the votes with which a border stays.
    clear : float
        Share times contrast with which it stays.

    Returns
    -------
    Consensus
    """
    counts = range(2, k_max + 1)
    by_voter = list(workers.map(lambda weight: cutter.draft_cuts(weight, counts), voters))
    weights = [weight for weight, cuts in zip(voters, by_voter, strict=True) for _ in cuts]
    if not weights:  # no voter can tell two points apart
        return Consensus(np.where(draft.valid, 0, -1).astype(np.int32), 1.0)
    graph = PairGraph.of(draft, min_region)
    cuts = list(workers.map(graph.tidied, [labels for cuts in by_voter for labels in cuts]))
    share = count_votes(cuts, graph.one, graph.other)
    joined = join_by_votes(graph.one, graph.other, share, draft.size, least)
    labels = graph.known(graph.tidied(graph.known(joined.reshape(draft.shape))))
    one, other, real = graph.real_pairs()
    labels = join_faint(
        labels, one, other, balanced_steps(cutter.draft, one, other), share[real], clear
    )
    distance = distances_from(labels, cuts)
    mean = {weight: distance[np.equal(weights, weight)].mean() for weight in weights}
    return Consensus(labels, min(mean, key=mean.__getitem__))


def balanced_steps(
    features: Features, one: NDArray[np.int64], other: NDArray[np.int64]
) -> NDArray[np.float32]:
    """Return the distance of the balanced vectors of each two points.

    Parameters
    ----------
    features : Features
        Of the draft; the points all have a row there.
    one, other : (E,) int64
        Flat positions in the draft.

    Returns
    -------
    (E,) float32
    """
    vectors, row_of = features.mixed(1.0), np.zeros(np.prod(features.shape), np.int64)
    row_of[features.index] = np.arange(len(features))
    away = vectors[row_of[one]] - vectors[row_of[other]]
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", away, away)))
