"""Calderero and Marques [9]: region merging by colour and by depth, in consensus (Fig. 13b).

Two merging processes with statistical criteria (`merging`), one on colour and one on depth, work
independently and cooperate on the partition. Our reading, in steps:

1. Start from a fine partition: superpixels of colour and depth, for speed.
2. Both processes merge the current partition, each by its own criterion alone, down to a share
   `STEP` of its regions.
3. Consensus: neighbouring regions that both processes put together become one. Where they agree
   on nothing, both go on to fewer regions until they do.
4. Repeat from 2 until k regions are left. In the last step, which may agree on more than is
   needed, pairs merge in the order of their cost, colour and depth each in shares of its sum.

Before every step, regions that are small for the number of regions (the authors' scale-based
order) join the neighbour of the least such cost; so do regions without any depth, which are
colour's to decide. Every pixel gets a label.

Unclear: the start (the authors have a partition from pixels), the number of bins, how far the
processes go between two agreements, and what is done if they agree on nothing; the authors keep
the hierarchy of partitions, of which k picks one here. Their criteria include KL and
Bhattacharyya distances; KL, the log-likelihood, is the default.

References
----------
F. Calderero, F. Marques, "Hierarchical fusion of color and depth information at partition level
by cooperative region merging", ICASSP 2009.
F. Calderero, F. Marques, "Region merging techniques using information theory statistical
measures", IEEE Trans. Image Process. 19(6), 2010.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.baselines.kernels import compiled, find_root, flatten, join_roots
from geohue.baselines.merging import Criterion, merge_costs, merge_regions, soft_histograms
from geohue.baselines.planes import depth_of, filled
from geohue.baselines.regions import borders
from geohue.baselines.registry import Job
from geohue.features import lab_of

SUPERPIXELS = 1_000
"""Regions to start from, about."""

LEAST_PIXELS = 60
"""Of a superpixel, about: fewer make no histogram."""

BINS = 20
"""Bins of a channel's histogram."""

STEP = 0.8
"""Share of the regions that a process leaves before the next agreement."""


SMALL = 0.15
"""Regions below this share of the mean size merge first."""


def run(job: Job) -> NDArray[np.int32]:
    """Segment an image into `job.k` regions, or as many as it has islands."""
    return segment_image(lab_of(job.scene.colors), depth_of(job.scene), job.k)


def segment_image(
    lab: NDArray[np.float32],
    depth: NDArray[np.float32],
    k: int,
    criterion: Criterion = "kl",
    superpixels: int = SUPERPIXELS,
    bins: int = BINS,
) -> NDArray[np.int32]:
    """Merge superpixels by consensus.

    Parameters
    ----------
    lab : (H, W, 3) float32
    depth : (H, W) float32
        NaN where missing.
    k : int
        Regions to stop at.
    criterion : {"kl", "bhattacharyya"}
    superpixels, bins : int

    Returns
    -------
    (H, W) int32
        Labels from 0.
    """
    start = fine_partition(lab, depth, max(1, min(superpixels, depth.size // LEAST_PIXELS)))
    known = np.isfinite(depth)
    n = int(start.max()) + 1
    color = soft_histograms(lab.reshape(-1, 3), start.reshape(-1), n, bins)
    range_ = soft_histograms(depth[known][:, None], start[known], n, bins)
    pairs, _ = borders(start, np.zeros(depth.shape, np.float32))
    merged = consensus(color, range_, pairs, k, criterion)
    return merged[start]


def fine_partition(
    lab: NDArray[np.float32], depth: NDArray[np.float32], superpixels: int
) -> NDArray[np.int32]:
    """Divide the image into superpixels of one colour and depth (SLIC)."""
    from skimage.segmentation import slic

    known = np.isfinite(depth)
    channels = np.dstack([lab, filled(depth, known)]).astype(np.float64)
    channels -= channels.mean(axis=(0, 1))
    spread = channels.std(axis=(0, 1))
    scale = np.array([*[spread[:3].mean()] * 3, spread[3]])
    channels /= np.where(scale > 1e-6, scale, np.inf)
    labels = slic(
        channels,
        n_segments=superpixels,
        compactness=0.3,
        channel_axis=2,
        convert2lab=False,
        start_label=0,
    )
    _, compact = np.unique(labels, return_inverse=True)
    return np.asarray(compact.reshape(depth.shape), np.int32)


def consensus(
    color: NDArray[np.float64],
    depth: NDArray[np.float64],
    pairs: NDArray[np.int32],
    k: int,
    criterion: Criterion = "kl",
) -> NDArray[np.int32]:
    """Merge regions where the process on colour and the process on depth agree.

    Parameters
    ----------
    color, depth : (R, C, B) float
        Histograms of each region.
    pairs : (E, 2) int32
        Neighbours, each pair once.
    k : int
        Regions to stop at.
    criterion : {"kl", "bhattacharyya"}

    Returns
    -------
    (R,) int32
        The final region of each one.
    """
    groups, color, depth, pairs = _settle(color, depth, pairs, k, criterion)
    target = len(color)
    while len(color) > k and len(pairs):
        target = max(1, min(int(target * STEP), len(color) - 1))
        by_color = merge_regions(color, pairs, target, criterion)
        by_depth = merge_regions(depth, pairs, target, criterion)
        together = by_color[pairs[:, 0]] == by_color[pairs[:, 1]]
        together &= by_depth[pairs[:, 0]] == by_depth[pairs[:, 1]]
        if together.any():
            agreed = pairs[together]
            order = _order(color, depth, agreed, criterion)
            joined = unite(len(color), agreed[order], k)
            groups = joined[groups]
            color, depth, pairs = _collapse(color, depth, pairs, joined)
            joined, color, depth, pairs = _settle(color, depth, pairs, k, criterion)
            groups = joined[groups]
            target = len(color)
    return groups


def _settle(
    color: NDArray[np.float64],
    depth: NDArray[np.float64],
    pairs: NDArray[np.int32],
    k: int,
    criterion: Criterion,
) -> tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.float64], NDArray[np.int32]]:
    """Join regions that are small for their number, or without depth, to the best neighbour."""
    groups = np.arange(len(color), dtype=np.int32)
    while len(color) > k:
        size, known = color[:, 0].sum(axis=1), depth.sum(axis=(1, 2)) > 0
        odd = size < SMALL * size.mean()
        if known.any():
            odd |= ~known
        both = np.concatenate([pairs, pairs[:, ::-1]])
        both = both[odd[both[:, 0]]]
        if len(both) == 0:
            break
        rank = np.argsort(_order(color, depth, both, criterion))
        both = both[np.lexsort((rank, both[:, 0]))]
        first = np.flatnonzero(np.diff(both[:, 0], prepend=-1))
        joined = unite(len(color), both[first], k)
        groups = joined[groups]
        color, depth, pairs = _collapse(color, depth, pairs, joined)
    return groups, color, depth, pairs


def _order(
    color: NDArray[np.float64],
    depth: NDArray[np.float64],
    pairs: NDArray[np.int32],
    criterion: Criterion,
) -> NDArray[np.intp]:
    """Order pairs by the costs of merging them, each cue's in shares of its sum."""
    total = np.zeros(len(pairs))
    for counts in (color, depth):
        costs = merge_costs(counts, pairs, criterion)
        total += costs / (costs.sum() or 1.0)
    return np.argsort(total, kind="stable")


def _collapse(
    color: NDArray[np.float64],
    depth: NDArray[np.float64],
    pairs: NDArray[np.int32],
    joined: NDArray[np.int32],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int32]]:
    """Add up the histograms of joined regions; renumber their neighbours."""
    n = int(joined.max()) + 1
    sums = []
    for counts in (color, depth):
        total = np.zeros((n, *counts.shape[1:]))
        np.add.at(total, joined, counts)
        sums.append(total)
    ends = np.sort(joined[pairs], axis=1)
    ends = np.unique(ends[ends[:, 0] != ends[:, 1]], axis=0)
    return sums[0], sums[1], ends.astype(np.int32)


@compiled
def unite(n: int, pairs: NDArray[np.int32], least: int) -> NDArray[np.int32]:
    """Join pairs in their order until `least` sets are left; number the sets."""
    parent = np.arange(n).astype(np.int32)
    count = n
    for e in range(len(pairs)):
        one, other = find_root(parent, pairs[e, 0]), find_root(parent, pairs[e, 1])
        if one != other and count > least:
            join_roots(parent, one, other)
            count -= 1
    return flatten(parent)
