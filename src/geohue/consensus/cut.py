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
from geohue.regions.adjacency import adjacent_pixels, adjacent_points, link_pieces, nearest_known
from geohue.regions.groups import connected_groups, merge_small_groups
from geohue.regions.images import connected_components, merge_small_regions
from geohue.scene import Scene
from geohue.weight.likeness import distances_from
from geohue.weight.search import BALANCES

LEAST = 0.15
"""Share of the cuts that must draw a border for it to stay."""

CLEAR = 0.6
"""Share times contrast that it must have (`join_faint`)."""

SMALLEST = 10, 30
"""Pixels of a grid and points of a cloud below which a region joins what is around it, however
small the draft; the neighbourhood of points is the rougher one."""

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
    ground = _Ground.of(draft, min_region)
    cuts = list(workers.map(ground.tidied, [labels for cuts in by_voter for labels in cuts]))
    share = count_votes(cuts, ground.one, ground.other)
    joined = join_by_votes(ground.one, ground.other, share, draft.size, least)
    labels = ground.known(ground.tidied(ground.known(joined.reshape(draft.shape))))
    one, other, real = ground.real_pairs()
    labels = join_faint(labels, one, other, _steps(cutter.draft, one, other), share[real], clear)
    distance = distances_from(labels, cuts)
    mean = {weight: distance[np.equal(weights, weight)].mean() for weight in weights}
    return Consensus(labels, min(mean, key=mean.__getitem__))


@dataclass(frozen=True, slots=True, eq=False)
class _Ground:
    """The points that vote, and which of them lie side by side.

    A pixel in a gap of a grid votes as the point nearest to it, so that gaps part nothing.
    """

    draft: Scene
    near: NDArray[np.int64] | None
    one: NDArray[np.int64]
    other: NDArray[np.int64]
    n_beside: int  # the pairs after these only link pieces of a cloud
    smallest: int

    @classmethod
    def of(cls, draft: Scene, min_region: float) -> _Ground:
        pixels, points = (max(least, round(min_region * draft.size)) for least in SMALLEST)
        if draft.is_grid:
            one, other = adjacent_pixels(draft.shape)
            return cls(draft, nearest_known(draft.valid), one, other, len(one), pixels)
        one, other = adjacent_points(draft)
        far = link_pieces(draft, one, other)
        both = np.concatenate([one, far[0]]), np.concatenate([other, far[1]])
        return cls(draft, None, *both, len(one), points)

    def real_pairs(self) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
        """The points behind each pair, and which pairs have two, in two places."""
        if self.near is None:
            one, other = self.one, self.other
            real = (self.draft.points[one] != self.draft.points[other]).any(axis=1)
        else:
            one, other = (self.near.reshape(-1)[side] for side in (self.one, self.other))
            real = one != other
        return one[real], other[real], real

    def known(self, labels: Labels) -> Labels:
        """Leave points without a position without a label."""
        return np.where(self.draft.valid, labels, np.int32(-1))

    def tidied(self, labels: Labels) -> Labels:
        """Fill the gaps, and let small regions join what is around them.

        Where all regions are small it is noise, and says nothing.
        """
        pairs = self.one[: self.n_beside], self.other[: self.n_beside]
        if self.near is not None:
            labels = labels.reshape(-1)[self.near]
            pieces = connected_components(labels)
        else:
            pieces = connected_groups(labels, *pairs)
        if np.bincount(pieces.reshape(-1)[labels.reshape(-1) >= 0]).max(initial=0) < self.smallest:
            return np.zeros_like(labels)
        if self.near is not None:
            return merge_small_regions(labels, self.smallest)
        return merge_small_groups(labels, *pairs, self.draft.points, self.smallest)


def _steps(
    features: Features, one: NDArray[np.int64], other: NDArray[np.int64]
) -> NDArray[np.float32]:
    """The distance of the balanced vectors of each two points of the draft."""
    vectors, row_of = features.mixed(1.0), np.zeros(np.prod(features.shape), np.int64)
    row_of[features.index] = np.arange(len(features))
    away = vectors[row_of[one]] - vectors[row_of[other]]
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", away, away)))
