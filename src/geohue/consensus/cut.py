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
from geohue.regions.graph import PairGraph
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
    one, other : (E,) int64
        Neighbouring points of the draft, as flat positions.
    share : (E,) float64
        How many of the maps part them, 0 to 1.
    """

    labels: Labels
    weight: float
    one: NDArray[np.int64]
    other: NDArray[np.int64]
    share: NDArray[np.float64]

    def along_borders(self, labels: NDArray[np.int32]) -> list[tuple[int, int, float]]:
        """Return the share of votes along each border of a segmentation of the draft.

        Parameters
        ----------
        labels : (h, w) or (m,) int32
            Segments of the draft's points, -1 = none.

        Returns
        -------
        list of (int, int, float)
            Two segments that touch, the lower number first, and the mean share of the maps that
            part their neighbouring points; in the order of the numbers.

        Examples
        --------
        >>> line = np.arange(2), np.arange(1, 3)
        >>> votes = Consensus(np.zeros(3, np.int32), 1.0, *line, np.array([0.2, 0.9]))
        >>> votes.along_borders(np.int32([0, 0, 1]))
        [(0, 1, 0.9)]
        """
        flat = labels.reshape(-1)
        ends = np.sort(np.stack([flat[self.one], flat[self.other]], axis=1), axis=1)
        border = (ends[:, 0] >= 0) & (ends[:, 0] < ends[:, 1])
        pairs, at = np.unique(ends[border], axis=0, return_inverse=True)
        at = at.reshape(-1)
        mean = np.bincount(at, self.share[border], len(pairs)) / np.bincount(at, None, len(pairs))
        return [(int(a), int(b), float(s)) for (a, b), s in zip(pairs, mean, strict=True)]


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
    by_voter = list(workers.map(lambda voter: checked_maps(voter, prepared), voters))
    owner = np.array([i for i, maps in enumerate(by_voter) for _ in maps])
    if len(owner) == 0:  # no voter can tell two points apart
        nobody = np.zeros(0, np.int64)
        labels = np.where(draft.valid, 0, -1).astype(np.int32)
        return Consensus(labels, 1.0, nobody, nobody, np.zeros(0))
    graph = PairGraph.of(draft, prepared.settings.min_region, rules.smallest)
    maps = list(workers.map(graph.tidied, [labels for maps in by_voter for labels in maps]))
    share = count_votes(maps, graph.one, graph.other)
    joined = join_by_votes(graph.one, graph.other, share, draft.size, rules.least)
    labels = graph.known(graph.tidied(graph.known(joined.reshape(draft.shape))))
    one, other, real = graph.real_pairs()
    steps = balanced_steps(prepared.draft_features, one, other)
    labels = join_faint(labels, one, other, steps, share[real], rules.clear)
    distance = distances_from(labels, maps)
    mean = {i: distance[owner == i].mean() for i in np.unique(owner).tolist()}
    likest = voters[min(mean, key=mean.__getitem__)]
    return Consensus(labels, float(likest.weight), graph.one, graph.other, share)


def checked_maps(voter: Voter, prepared: PreparedScene) -> list[Labels]:
    """Return the maps of a voter, which must be as the draft."""
    maps = [np.asarray(labels, np.int32) for labels in voter.maps(prepared)]
    for labels in maps:
        if labels.shape != prepared.draft.shape:
            raise GeohueError(
                f"a voter ({type(voter).__name__}) gave labels of shape {labels.shape}; "
                f"expected {prepared.draft.shape}, as the draft"
            )
    return maps


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
