"""From filtered pixels to regions: connected plateaus, close modes, small regions.

What EDISON does after its filter, in its order:

1. neighbouring pixels whose modes are (almost) equal are connected;
2. neighbouring regions with modes closer than half a bandwidth join, unless there is an edge
   between them, transitively, with the modes taken anew, until nothing changes;
3. regions below the least size join the neighbour with the closest mode, until there are none.

Lengths are in units of the range bandwidth throughout.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.baselines.kernels import compiled, compiled_part, find_root, flatten, join_roots

SAME = 1 / 6.5
"""Modes that differ by less in each channel are connected: 1 Luv unit of EDISON's 6.5."""

CLOSE = 0.5
"""Neighbouring modes closer than this join."""

MOST_ROUNDS = 10
"""Most rounds of joining close modes, as in EDISON."""


@dataclass(frozen=True, slots=True, eq=False)
class RegionMap:
    """Regions of an image and their modes.

    Attributes
    ----------
    labels : (H, W) int32
        0..R-1; -1 outside the mask.
    size : (R,) int64
        Pixels.
    modes : (R, 5) float64
        Mean of the values, the depth (over the pixels with confidence), and its confidence.
    """

    labels: NDArray[np.int32]
    size: NDArray[np.int64]
    modes: NDArray[np.float64]


def grow_regions(
    modes: NDArray[np.float32],
    mask: NDArray[np.bool_],
    strength: NDArray[np.float32],
    edge_threshold: float,
    min_size: int,
) -> NDArray[np.int32]:
    """Turn the filtered image into regions.

    Parameters
    ----------
    modes : (H, W, 5) float32
        Result of `shift_filter`.
    mask : (H, W) bool
        The pixels that take part.
    strength : (H, W) float32
        Of the edge that a pixel lies on, 0 to 1.
    edge_threshold : float
        Regions join only if the mean strength along their border is below it.
    min_size : int
        Pixels.

    Returns
    -------
    (H, W) int32
        Labels from 0; -1 outside the mask.
    """
    regions = measure(connect(modes, mask, SAME), modes)
    for _ in range(MOST_ROUNDS):
        pairs, edge = borders(regions.labels, strength)
        near = mode_distance(regions, pairs) < CLOSE**2
        joined = join(regions, pairs[near & (edge < edge_threshold)], modes)
        if len(joined.size) == len(regions.size):
            break
        regions = joined
    return prune(regions, strength, modes, min_size).labels


def prune(
    regions: RegionMap,
    strength: NDArray[np.float32],
    modes: NDArray[np.float32],
    min_size: int,
) -> RegionMap:
    """Join each small region to the neighbour with the closest mode (the first of equals)."""
    while (regions.size < min_size).any():
        pairs, _ = borders(regions.labels, strength)
        both = np.concatenate([pairs, pairs[:, ::-1]])
        both = both[regions.size[both[:, 0]] < min_size]
        order = np.lexsort((both[:, 1], mode_distance(regions, both), both[:, 0]))
        both = both[order]
        first = np.flatnonzero(np.diff(both[:, 0], prepend=-1))
        if len(first) == 0:  # islands without neighbours
            break
        regions = join(regions, both[first], modes)
    return regions


def measure(labels: NDArray[np.int32], modes: NDArray[np.float32]) -> RegionMap:
    """Take the size and the mean mode of each region."""
    inside = labels >= 0
    region, values = labels[inside], modes[inside].astype(np.float64)
    size = np.bincount(region)
    sums = [np.bincount(region, values[:, c], len(size)) for c in (0, 1, 2, 4)]
    depth = np.bincount(region, values[:, 3] * values[:, 4], len(size))
    confident = np.where(sums[3] > 0, sums[3], 1.0)
    columns = [total / size for total in sums]
    columns.insert(3, depth / confident)
    return RegionMap(labels, size, np.stack(columns, axis=1))


def borders(
    labels: NDArray[np.int32], strength: NDArray[np.float32]
) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """Return the 4-adjacent pairs of regions and the mean edge strength on each border."""
    keys, edges = [], []
    count = int(labels.max(initial=-1)) + 1
    views = ((slice(None), slice(None, -1)), (slice(None), slice(1, None)))
    for here, there in (views, (views[0][::-1], views[1][::-1])):
        one, other = labels[here], labels[there]
        apart = (one != other) & (one >= 0) & (other >= 0)
        low, high = np.minimum(one, other)[apart], np.maximum(one, other)[apart]
        keys.append(low.astype(np.int64) * count + high)
        edges.append((strength[here][apart] + strength[there][apart]) / 2)
    unique, group = np.unique(np.concatenate(keys), return_inverse=True)
    total = np.bincount(group, np.concatenate(edges), len(unique))
    edge = total / np.bincount(group, minlength=len(unique))
    return np.stack(np.divmod(unique, max(count, 1)), axis=1).astype(np.int32), edge


def mode_distance(regions: RegionMap, pairs: NDArray[np.int32]) -> NDArray[np.float64]:
    """Return the squared distance of the modes of each pair, depth by its confidence."""
    one, other = regions.modes[pairs[:, 0]], regions.modes[pairs[:, 1]]
    squared = (one[:, :4] - other[:, :4]) ** 2
    squared[:, 3] *= one[:, 4] * other[:, 4]
    return np.asarray(squared.sum(axis=1), np.float64)


def join(regions: RegionMap, pairs: NDArray[np.int32], modes: NDArray[np.float32]) -> RegionMap:
    """Join pairs of regions, transitively, and measure anew."""
    if len(pairs) == 0:
        return regions
    merged = _union(len(regions.size), pairs)
    labels = np.where(regions.labels < 0, np.int32(-1), merged[regions.labels])
    return measure(labels, modes)


@compiled
def _union(n: int, pairs: NDArray[np.int32]) -> NDArray[np.int32]:
    parent = np.arange(n).astype(np.int32)
    for e in range(len(pairs)):
        one, other = find_root(parent, pairs[e, 0]), find_root(parent, pairs[e, 1])
        if one != other:
            join_roots(parent, one, other)
    return flatten(parent)


@compiled_part
def _are_alike(modes: NDArray[np.float32], y: int, x: int, v: int, u: int, same: float) -> bool:
    """Say whether the modes of two pixels differ by less than `same` in every channel."""
    for c in range(3):
        if abs(modes[y, x, c] - modes[v, u, c]) >= same:
            return False
    step = modes[y, x, 3] - modes[v, u, 3]
    return bool(modes[y, x, 4] * modes[v, u, 4] * step * step < same * same)


@compiled
def connect(modes: NDArray[np.float32], mask: NDArray[np.bool_], same: float) -> NDArray[np.int32]:
    """Number the sets of 8-connected pixels whose modes are alike from each to the next."""
    height, width = mask.shape
    parent = np.arange(height * width).astype(np.int32)
    for y in range(height):
        for x in range(width):
            for v, u in ((y, x + 1), (y + 1, x - 1), (y + 1, x), (y + 1, x + 1)):
                inside = v < height and u >= 0 and u < width
                if inside and mask[y, x] and mask[v, u] and _are_alike(modes, y, x, v, u, same):
                    one, other = find_root(parent, y * width + x), find_root(parent, v * width + u)
                    join_roots(parent, one, other)
    return _numbered(flatten(parent), mask)


@compiled_part
def _numbered(sets: NDArray[np.int32], mask: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Number the sets of the pixels of the mask 0..R-1 in their order; -1 elsewhere."""
    labels = np.full(mask.shape, -1, np.int32)
    seen = np.full(len(sets), -1, np.int32)
    count = 0
    for p in range(len(sets)):
        y, x = p // mask.shape[1], p % mask.shape[1]
        if mask[y, x]:
            if seen[sets[p]] < 0:
                seen[sets[p]] = count
                count += 1
            labels[y, x] = seen[sets[p]]
    return labels
