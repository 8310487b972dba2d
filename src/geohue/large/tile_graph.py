"""The regions of all tiles as one graph, and its merging into superpoints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.large.tile_regions import TileRegions, Wish
from geohue.merge.tree import MergeTree
from geohue.regions.groups import join_pairs
from geohue.superpoint.driver import from_level, renamed
from geohue.superpoint.ward import LAB, LENGTH, POSITION, SIZE, STEP, Regions, merge_regions
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
    name : (R,) int64
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
    parts: list[TileRegions], region_of: Callable[[int, Positions], NDArray[np.int32]]
) -> tuple[Regions, Floats, Positions]:
    """Put the regions of all tiles together, those that touch across a face as neighbours.

    Parameters
    ----------
    parts : list of TileRegions
        Of each tile.
    region_of : callable
        Given a tile and rows of its points, returns their regions.

    Returns
    -------
    regions : Regions
        Of the whole cloud.
    color : (R, 3) float64
        Sums of sRGB.
    starts : (T,) int64
        The first region of each tile.
    """
    starts = np.cumsum([0, *(len(part.region) for part in parts)])
    ends, borders = [], []
    for tile, part in enumerate(parts):
        ends.append(part.ends + starts[tile])
        borders.append(part.border)
        far = np.empty(len(part.tile), np.int64)
        for other in np.unique(part.tile).tolist():
            there = part.tile == other
            far[there] = region_of(other, part.row[there]) + starts[other]
        across, border = _summed(part.inside + starts[tile], far, part.step, int(starts[-1]))
        ends.append(across)
        borders.append(border)
    region = np.concatenate([part.region for part in parts])
    color = np.concatenate([part.color for part in parts])
    # Two regions touch inside of a tile or across one face: no border comes twice.
    return Regions(region, np.concatenate(borders), np.concatenate(ends)), color, starts[:-1]


def merged(
    regions: Regions, color: Floats, starts: Positions, wish: Wish, wanted: int
) -> tuple[Whole, int]:
    """Merge the regions of a whole cloud; returns how many superpoints were reached, too."""
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
    total = np.stack([np.bincount(name, column, k) for column in sums.T], axis=1)
    apart = name[ends[:, 0]] != name[ends[:, 1]]
    pairs, border = _summed(*name[ends[apart]].T, contact[apart], k)
    graph: dict[str, NDArray[np.generic]] = {
        "size": total[:, 0].astype(np.int64),
        "center": total[:, 1:4] / total[:, :1] + wish.origin,
        "color": total[:, 4:] / total[:, :1],
        "edges": pairs,
        "contact": border[:, STEP].astype(np.int64),
    }
    return Whole(starts, np.append(name, -1), renamed(tree, old.astype(np.int32)), graph), k


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


def _summed(one: Positions, other: Positions, step: Floats, n: int) -> tuple[Positions, Floats]:
    """Return the different pairs among 0..n-1, (B, 2), with how often each comes and its sum."""
    keys = np.minimum(one, other) * n + np.maximum(one, other)
    there, place, count = np.unique(keys, return_inverse=True, return_counts=True)
    total = np.bincount(place.reshape(-1), step, len(there))
    border = np.stack([count.astype(np.float64), total], axis=1)
    return np.stack([there // max(n, 1), there % max(n, 1)], axis=1), border
