"""The regions of all tiles as one graph, and its merging into superpoints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.large.tile_regions import Across, TileRegions, Wish
from geohue.merge.tree import MergeTree
from geohue.regions.groups import join_pairs
from geohue.superpoint import loops
from geohue.superpoint.driver import from_level, renamed
from geohue.superpoint.ward import LAB, LENGTH, POSITION, SIZE, Regions, merge_regions
from geohue.superpoint.weights import CRUMB, SHARE, merging_weights, step_weights

Floats = NDArray[np.float64]
Positions = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Whole:
    """Superpoints of a cloud in tiles.

    Attributes
    ----------
    starts : (T,) int64
        The first region of each tile.
    name : (M + 1,) int64
        The superpoint of each region, and -1 at the end for points without one.
    tree : MergeTree
        How superpoints merge on.
    graph : dict of arrays
        ``size`` (K,), ``center`` (K, 3), ``color`` (K, 3), ``edges`` (B, 2), ``contact`` (B,).
    """

    starts: Positions
    name: Positions
    tree: MergeTree
    graph: dict[str, NDArray[np.generic]]


def joined(
    parts: list[TileRegions], region_of: Callable[[int, Positions], NDArray[np.int32]], most: float
) -> tuple[Regions, Floats, Positions, NDArray[np.int32]]:
    """Put the regions of all tiles together, those that touch across a face as neighbours.

    Parameters
    ----------
    parts : list of TileRegions
        Of each tile.
    region_of : callable
        Given a tile and rows of its points, returns their regions.
    most : float
        Points of a set of a few points at most: those that a face cuts become one again.

    Returns
    -------
    regions : Regions
        Of the whole cloud.
    color : (R, 3) float64
        Sums of sRGB.
    starts : (T,) int64
        The first of the M regions of each tile.
    name : (M,) int32
        Which of the R regions each of them is.
    """
    starts = np.cumsum([0, *(len(part.region) for part in parts)])
    n = int(starts[-1])
    beyond = [_far(part.pairs, starts, region_of) for part in parts]
    cut = [_far(part.same, starts, region_of) for part in parts]
    near = [part.same.inside + start for part, start in zip(parts, starts, strict=False)]
    one, other = np.concatenate(near), np.concatenate(cut)
    region = np.concatenate([part.region for part in parts])
    parent, name = np.arange(n, dtype=np.int32), np.empty(n, np.int32)
    size = np.ascontiguousarray(region[:, SIZE])
    loops.join_capped(one, other, np.arange(len(one)), parent, size, most)
    n = loops.number_sets(parent, name)
    ends, borders = [], []
    for part, start, far in zip(parts, starts, beyond, strict=False):
        ends += [part.ends + start, np.stack([part.pairs.inside + start, far], axis=1)]
        step = part.pairs.step
        borders += [part.border, np.stack([np.ones(len(step)), step], axis=1)]
    pairs = name[np.concatenate(ends)].astype(np.int64)
    apart = pairs[:, 0] != pairs[:, 1]
    found, border = _summed(pairs[apart], np.concatenate(borders)[apart], n)
    color = np.concatenate([part.color for part in parts])
    whole = Regions(_added(region, name, n), border, found)
    return whole, _added(color, name, n), starts[:-1], name


def _far(
    across: Across, starts: Positions, region_of: Callable[[int, Positions], NDArray[np.int32]]
) -> Positions:
    """Return the region in the whole cloud of points in other tiles."""
    far = np.empty(len(across.tile), np.int64)
    for other in np.unique(across.tile).tolist():
        there = across.tile == other
        far[there] = region_of(other, across.row[there]) + starts[other]
    return far


def merged(
    regions: Regions, color: Floats, wish: Wish, wanted: int
) -> tuple[Positions, MergeTree, dict[str, NDArray[np.generic]]]:
    """Merge the regions of a whole cloud.

    Returns
    -------
    name : (R,) int64
        The superpoint of each, the largest first.
    tree : MergeTree
        How superpoints merge on.
    graph : dict of arrays
        As in `Whole`.
    """
    sums = np.hstack([regions.region[:, [SIZE]], regions.region[:, POSITION:], color])
    regions = with_crumbs(regions, max(CRUMB, SHARE * float(sums[:, 0].sum()) / wanted))
    ends, contact = regions.ends.copy(), regions.border[:, LENGTH].copy()
    n = len(sums)
    merges, costs = merge_regions(regions, wish.spacing, merging_weights(wish.compactness))
    tree, region = from_level(MergeTree(n, merges, costs), min(wanted, n))
    k = tree.n_regions
    size = np.bincount(region, sums[:, 0], k)
    old = np.argsort(-size, kind="stable")
    new = np.empty(k, np.int64)
    new[old] = np.arange(k)
    name = new[region]
    total = _added(sums, name, k)
    apart = name[ends[:, 0]] != name[ends[:, 1]]
    pairs, border = _summed(name[ends[apart]], contact[apart, None], k)
    graph: dict[str, NDArray[np.generic]] = {
        "size": total[:, 0].astype(np.int64),
        "center": total[:, 1:4] / total[:, :1] + wish.origin,
        "color": total[:, 4:] / total[:, :1],
        "edges": pairs,
        "contact": border[:, 0].astype(np.int64),
    }
    return name, renamed(tree, old.astype(np.int32)), graph


def with_crumbs(regions: Regions, least: float) -> Regions:
    """Put each piece of less than `least` points beside the nearest region of a larger one."""
    from scipy.spatial import cKDTree

    n = len(regions.region)
    size = regions.region[:, SIZE]
    piece = join_pairs(regions.ends[:, 0], regions.ends[:, 1], n)
    small = np.bincount(piece, size)[piece] < least
    if not small.any() or small.all():
        return regions
    mean = regions.region / size[:, None]
    lost, ground = np.flatnonzero(small), np.flatnonzero(~small)
    at = mean[:, POSITION:]
    distance, near = cKDTree(at[ground]).query(at[lost])
    order = np.lexsort((np.asarray(distance), piece[lost]))
    _, first = np.unique(piece[lost][order], return_index=True)
    one, other = lost[order][first], ground[np.asarray(near)[order][first]]
    # No surface lies between the two: they differ in colour, and in their normals as if crosswise.
    color, turn, _ = step_weights()
    away = ((mean[one, LAB : LAB + 3] - mean[other, LAB : LAB + 3]) ** 2).sum(axis=1)
    border = np.stack([np.ones(len(one)), np.sqrt(color * away + turn)], axis=1)
    return Regions(
        regions.region,
        np.concatenate([regions.border, border]),
        np.concatenate([regions.ends, np.stack([one, other], axis=1)]),
    )


def _summed(pairs: Positions, border: Floats, n: int) -> tuple[Positions, Floats]:
    """Return the different pairs among 0..n-1, (B, 2), with the sums of their borders."""
    keys = pairs.min(axis=1) * n + pairs.max(axis=1)
    there, place = np.unique(keys, return_inverse=True)
    ends = np.stack([there // max(n, 1), there % max(n, 1)], axis=1)
    return ends, _added(border, place.reshape(-1), len(there))


def _added(rows: Floats, name: NDArray[np.integer[Any]], n: int) -> Floats:
    """Add up the rows of each name."""
    return np.stack([np.bincount(name, column, n) for column in rows.T], axis=1)
