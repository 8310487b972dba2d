"""A segmentation that many cuts agree on, with no weight and no number of segments to choose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.consensus.contrast import join_faint
from geohue.consensus.voters import Voter
from geohue.consensus.votes import count_votes, join_by_votes
from geohue.errors import GeohueError
from geohue.features import Features
from geohue.prepared import PreparedScene
from geohue.regions.adjacency import adjacent_pixels, adjacent_points, link_pieces, nearest_known
from geohue.regions.groups import connected_groups, merge_small_groups
from geohue.regions.images import connected_components, merge_small_regions
from geohue.scene import Scene
from geohue.weight.likeness import distances_from

Labels = NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class Consensus:
    """What the voters agree on.

    Attributes
    ----------
    labels : (h, w) or (m,) int32
        Segments of the draft, connected but for gaps; -1 where it has no point.
    weight : float
        That of the voter whose maps are most like them, NaN if it has none.
    """

    labels: Labels
    weight: float


def find_consensus(voters: Sequence[Voter], prepared: PreparedScene) -> Consensus:
    """Let voters segment the draft, and keep the borders that enough of them draw.

    Each map votes for its borders, those of small regions left out. Neighbouring points are joined
    while fewer than `least` of the maps part them (`join_by_votes`), then the regions between which
    there is little to be seen (`join_faint`).

    Parameters
    ----------
    voters : sequence of Voter
        Who votes: normalized cuts of several weights (`make_voters`), or any other.
    prepared : PreparedScene
        The scene; its settings `least`, `clear`, `smallest` and `min_region` count.

    Returns
    -------
    Consensus

    Raises
    ------
    GeohueError
        If a voter gives labels of another shape than the draft.
    """
    draft, workers, rules = prepared.draft, prepared.workers, prepared.settings.consensus
    by_voter = list(workers.map(lambda voter: _checked(voter, prepared), voters))
    owner = np.array([i for i, maps in enumerate(by_voter) for _ in maps])
    if len(owner) == 0:  # no voter can tell two points apart
        return Consensus(np.where(draft.valid, 0, -1).astype(np.int32), 1.0)
    ground = _Ground.of(draft, prepared.settings.min_region, rules.smallest)
    maps = list(workers.map(ground.tidied, [labels for maps in by_voter for labels in maps]))
    share = count_votes(maps, ground.one, ground.other)
    joined = join_by_votes(ground.one, ground.other, share, draft.size, rules.least)
    labels = ground.known(ground.tidied(ground.known(joined.reshape(draft.shape))))
    one, other, real = ground.real_pairs()
    steps = _steps(prepared.draft_features, one, other)
    labels = join_faint(labels, one, other, steps, share[real], rules.clear)
    distance = distances_from(labels, maps)
    mean = {i: distance[owner == i].mean() for i in np.unique(owner).tolist()}
    return Consensus(labels, float(voters[min(mean, key=mean.__getitem__)].weight))


def _checked(voter: Voter, prepared: PreparedScene) -> list[Labels]:
    """Return the maps of a voter, which must be as the draft."""
    maps = [np.asarray(labels, np.int32) for labels in voter.maps(prepared)]
    for labels in maps:
        if labels.shape != prepared.draft.shape:
            raise GeohueError(
                f"a voter ({type(voter).__name__}) gave labels of shape {labels.shape}; "
                f"expected {prepared.draft.shape}, as the draft"
            )
    return maps


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
    def of(cls, draft: Scene, min_region: float, smallest: tuple[int, int]) -> _Ground:
        pixels, points = (max(least, round(min_region * draft.size)) for least in smallest)
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
