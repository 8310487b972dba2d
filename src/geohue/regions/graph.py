"""The points of a draft as a graph: which of them lie side by side, across gaps and pieces too."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.regions.adjacency import adjacent_pixels, adjacent_points, link_pieces, nearest_known
from geohue.regions.groups import connected_groups, merge_small_groups
from geohue.regions.images import connected_components, merge_small_regions
from geohue.scene import Scene
from geohue.settings.consensus import SMALLEST

Labels = NDArray[np.int32]


@dataclass(frozen=True, slots=True, eq=False)
class PairGraph:
    """Which points of a draft lie side by side.

    A pixel in a gap of a grid counts as the point nearest to it, so that gaps part nothing.

    Attributes
    ----------
    draft : Scene
        The points.
    near : (h, w) int64 or None
        The pixel that each pixel counts as; None for a cloud.
    one, other : (E,) int64
        Pairs of neighbours; those of a grid may lie in gaps.
    n_beside : int
        The pairs after these only link pieces of a cloud.
    smallest : int
        Points below which a region joins what is around it.
    """

    draft: Scene
    near: NDArray[np.int64] | None
    one: NDArray[np.int64]
    other: NDArray[np.int64]
    n_beside: int
    smallest: int

    @classmethod
    def of(
        cls,
        draft: Scene,
        min_region: float,
        smallest: tuple[int, int] = SMALLEST,
        everywhere: bool = False,
    ) -> PairGraph:
        """Pair the points of a draft.

        Parameters
        ----------
        draft : Scene
            The points.
        min_region : float
            Share of the points below which a region counts as small.
        smallest : (int, int)
            Pixels of a grid and points of a cloud below which it does, however small the draft.
        everywhere : bool
            Whether a grid has no gaps: where colour alone counts, so does a pixel without depth.
        """
        pixels, points = (max(least, round(min_region * draft.size)) for least in smallest)
        if draft.is_grid:
            one, other = adjacent_pixels(draft.shape)
            near = nearest_known(draft.valid | everywhere)
            return cls(draft, near, one, other, len(one), pixels)
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

    def close_pairs(
        self, far: float, least: int | None = None
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
        """Divide the pairs into those that may lie in one thing and links across a distance.

        A link between pieces of a cloud is close where it is shorter than `far` median distances of
        neighbours, or where one of the pieces has fewer than `least` points (by default
        `smallest`): too few for a thing.

        Returns
        -------
        one, other : (E,) int64
            The close pairs.
        distant : (F, 2) int64
            The other links, the shortest first.
        """
        if self.near is not None or self.n_beside in (0, len(self.one)):
            return self.one, self.other, np.zeros((0, 2), np.int64)
        away = self.draft.points[self.other] - self.draft.points[self.one]
        length = np.sqrt((away.astype(np.float64) ** 2).sum(axis=1))
        beside = np.arange(len(length)) < self.n_beside
        close = beside | (length < far * np.median(length[beside]))
        everywhere = np.zeros(self.draft.size, np.int32)
        piece = connected_groups(everywhere, self.one[close], self.other[close])
        small = np.bincount(piece)[piece] < (self.smallest if least is None else least)
        close |= small[self.one] | small[self.other]
        distant = np.stack([self.one[~close], self.other[~close]], axis=1)
        order = np.argsort(length[~close], kind="stable")
        return self.one[close], self.other[close], distant[order]
