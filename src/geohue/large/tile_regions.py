"""A tile of a cloud into regions, a few for each superpoint, that do not depend on its faces."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geohue.compute.parallel import cores, workers
from geohue.large.tiles import Buckets, Tiles
from geohue.merge.tree import MergeTree
from geohue.superpoint import loops
from geohue.superpoint.driver import fine_regions, roots
from geohue.superpoint.nodes import FAR, ROUNDS, Nodes, in_order, nodes_of_places
from geohue.superpoint.opened import merge_inside
from geohue.superpoint.ward import tabulate
from geohue.superpoint.weights import merging_weights

Floats = NDArray[np.float64]
Positions = NDArray[np.int64]

FINER = 4.0
"""Regions that a tile leaves for each superpoint: what is decided on the whole cloud."""

HALO = 2.0 * FAR * (ROUNDS + 1)
"""Typical distances of neighbours that a tile sees beyond its faces. The normal of a point depends
on the neighbours of its neighbours, and which those are on points as far away again."""

_SURVEY = 50  # one place in so many tells the typical distance


@dataclass(frozen=True, slots=True)
class Wish:
    """What a tile is split by, the same for all.

    Attributes
    ----------
    cues : {"fusion", "color", "geometry"}
        What takes part.
    compactness : float
        As for `geohue.superpoints`.
    spacing : float
        Typical distance of neighbours.
    density : float
        Superpoints for each point.
    origin : (3,) float64
        What is taken off all positions.
    """

    cues: str
    compactness: float
    spacing: float
    density: float
    origin: Floats


class Across(NamedTuple):
    """Regions of a tile and points of others.

    Attributes
    ----------
    inside : (C,) int64
        The region.
    tile, row : (C,) int64
        The tile of the point, and which of its points it is.
    step : (C,) float64
        The step between the two.
    """

    inside: Positions
    tile: Positions
    row: Positions
    step: Floats


class TileRegions(NamedTuple):
    """The regions of a tile, their borders, and what lies across its faces.

    Attributes
    ----------
    region : (R, 13) float64
        As in `geohue.superpoint.ward.Regions`.
    color : (R, 3) float64
        Sums of sRGB.
    border : (B, 2) float64
        Pairs across each border, and the sum of their steps.
    ends : (B, 2) int64
        Its two regions.
    pairs : Across
        Points side by side across a face.
    same : Across
        Regions of a few points that a face cuts: the point is of the same.
    """

    region: Floats
    color: Floats
    border: Floats
    ends: Positions
    pairs: Across
    same: Across


def survey(buckets: Buckets, tile: int, origin: Floats, threads: int | None) -> NDArray[np.float64]:
    """Return the distance to the third nearest of some of the places of a tile."""
    from scipy.spatial import cKDTree

    points = buckets.rows(tile)["xyz"] - origin
    order, new = in_order(points)
    places = points[order][new]
    if len(places) < 2:
        return np.empty(0)
    tree = cKDTree(places, balanced_tree=False, compact_nodes=False)
    some, rank = places[::_SURVEY], min(4, len(places))
    found = tree.query(some, [rank], workers=cores() if threads is None else threads)
    return np.asarray(found[0]).reshape(-1)


def area(buckets: Buckets, tile: int, wish: Wish, threads: int | None) -> float:
    """Return the area of the surface in a tile."""
    rows = buckets.rows(tile)
    nodes = _nodes(rows["xyz"], rows["rgb"], replace(wish, cues="geometry"), threads)
    here = nodes.points, nodes.normals, nodes.one, nodes.other
    return nodes.size * loops.mean_area(*here) if len(nodes.one) else 0.0


def split_tile(
    buckets: Buckets,
    tile: int,
    tiles: Tiles,
    bounds: Floats,
    wish: Wish,
    threads: int | None,
) -> tuple[TileRegions, NDArray[np.int32]]:
    """Split a tile.

    Parameters
    ----------
    buckets : Buckets
        The points of all tiles.
    tile : int
        Which one.
    tiles : Tiles
        All of them.
    bounds : (T, 2, 3) float64
        The boxes of their points.
    wish : Wish
        How.
    threads : int, optional
        How many; by default one a core.

    Returns
    -------
    found : TileRegions
    labels : (n,) int32
        The region of each point of the tile.
    """
    view = _View.of(buckets, tile, tiles, bounds, wish, threads)
    nodes, is_own, n_own = view.nodes, view.is_own, view.n_own
    every, n, step = fine_regions(
        nodes, max(1, round(wish.density * nodes.weight.sum())), exact=True
    )
    # Sets that lie beyond the faces alone are another tile's.
    kept, fine = _numbered(every[is_own])
    mine = np.full(n, -1, np.int64)
    mine[kept] = np.arange(len(kept))
    crossing = is_own[nodes.one] != is_own[nodes.other]
    first = is_own[nodes.one[crossing]]
    one, other = nodes.one[crossing], nodes.other[crossing]
    near, far = mine[every[np.where(first, one, other)]], np.where(first, other, one)
    rest = np.flatnonzero(~is_own & (mine[every] >= 0))
    part = mine[every[rest]]
    is_open = np.zeros(len(kept), np.bool_)
    is_open[near], is_open[part] = True, True
    inside = is_own[nodes.one] & is_own[nodes.other]
    core = _only(nodes, is_own, inside)
    shape = core.points, core.lab, core.normals, core.weight, core.one, core.other
    table = tabulate(fine, len(kept), *shape, step[inside])
    weights = merging_weights(wish.compactness)
    merges, alive = merge_inside(table, wish.spacing, weights, is_open, FINER * wish.density)
    tree = MergeTree(len(kept), merges, np.zeros(len(merges)))
    name, left = tree.after(len(merges)), roots(tree, len(merges))
    left = left[np.argsort(name[left])]
    labels = name[mine[every[nodes.node[:n_own]]]]
    color = [np.bincount(labels, channel, len(left)) for channel in view.colors.T]
    found = TileRegions(
        table.region[left],
        np.stack(color, axis=1).astype(np.float64),
        table.border[alive],
        name[table.ends[alive]].astype(np.int64),
        view.told(tile, name[near], far, step[crossing]),
        view.told(tile, name[part], rest, np.zeros(len(part))),
    )
    return found, labels


@dataclass(frozen=True, slots=True, eq=False)
class _View:
    """The points of a tile and those around it.

    Attributes
    ----------
    nodes : Nodes
        Of all of them, those of the tile first.
    n_own : int
        How many are of the tile.
    is_own : (M,) bool
        Whose places are in it.
    colors : (n_own, 3) uint8
        Of the tile's points.
    owner, row : (m,) int64
        Of each other point: its tile, and which of that tile's points it is.
    """

    nodes: Nodes
    n_own: int
    is_own: NDArray[np.bool_]
    colors: NDArray[np.uint8]
    owner: Positions
    row: Positions

    @classmethod
    def of(
        cls,
        buckets: Buckets,
        tile: int,
        tiles: Tiles,
        bounds: Floats,
        wish: Wish,
        threads: int | None,
    ) -> _View:
        own = buckets.rows(tile)
        beyond = list(buckets.around(tile, tiles, bounds, HALO * wish.spacing))
        rows = np.concatenate([own, *(part for _, _, part in beyond)])
        none = np.empty(0, np.int64)
        owner = np.concatenate([none, *(np.full(len(at), t) for t, at, _ in beyond)])
        row = np.concatenate([none, *(at for _, at, _ in beyond)])
        nodes = _nodes(rows["xyz"], rows["rgb"], wish, threads)
        colors = np.array(own["rgb"])
        return cls(nodes, len(own), nodes.first < len(own), colors, owner, row)

    def told(self, tile: int, region: NDArray[np.int32], far: Positions, step: Floats) -> Across:
        """Return what lies across: both tiles see it, and the first of them tells."""
        point = self.nodes.first[far] - self.n_own
        by = self.owner[point] > tile
        point = point[by]
        return Across(region[by].astype(np.int64), self.owner[point], self.row[point], step[by])


def _numbered(labels: NDArray[np.int32]) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Return the different labels, and the number of each label among them."""
    kept, number = np.unique(labels, return_inverse=True)
    return kept, np.asarray(number.reshape(-1), np.int32)


def _nodes(xyz: Floats, rgb: NDArray[np.uint8], wish: Wish, threads: int | None) -> Nodes:
    with workers(threads) as team:
        count = cores() if threads is None else threads
        return nodes_of_places(xyz - wish.origin, rgb, wish.cues, team, count, wish.spacing)


def _only(nodes: Nodes, kept: NDArray[np.bool_], both: NDArray[np.bool_]) -> Nodes:
    """Return some of the nodes, and the pairs between `both` of them."""
    number = np.cumsum(kept) - 1
    return replace(
        nodes,
        points=np.ascontiguousarray(nodes.points[kept]),
        lab=np.ascontiguousarray(nodes.lab[kept]),
        normals=np.ascontiguousarray(nodes.normals[kept]),
        one=number[nodes.one[both]],
        other=number[nodes.other[both]],
        weight=nodes.weight[kept],
        first=nodes.first[kept],
    )
