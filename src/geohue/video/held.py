"""Which regions form one segment, with the benefit of the doubt for what was one before."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.merge.tree import MergeTree

Labels = NDArray[np.int32]

TOGETHER, APART = 2.0, 0.25
"""Scores, logarithms of odds, by which regions of one track are kept together and those of two
tracks apart: near 0 the noise of a frame would decide, and the segment would flicker. With as much
for apart as for together the segments would become more and more."""


def held_level(
    tree: MergeTree,
    shares: NDArray[np.float64],
    threshold: float = 0.0,
    together: float = TOGETHER,
    apart: float = APART,
) -> Labels:
    """Return the segment of each finest region.

    As `MergeTree.at`, but two groups of regions that mostly belonged to one track are merged up to
    a score `together` above the threshold, and those of two tracks only if it is `apart` below.

    Parameters
    ----------
    tree : MergeTree
        The merges of R regions.
    shares : (R, T) float64
        How much of each region lay on each track in the frame before.
    threshold : float
        As for `MergeTree.at`.
    together, apart : float
        At least 0.

    Returns
    -------
    (R,) int32
        Segments 0..K-1, in the order of their first regions.

    Examples
    --------
    >>> tree = MergeTree(3, np.array([[0, 1], [0, 2]]), np.array([-0.2, 0.5]))
    >>> tree.at(0.0).tolist()
    [0, 0, 1]
    >>> held_level(tree, np.ones((3, 1))).tolist()  # all were one
    [0, 0, 0]
    >>> held_level(tree, np.eye(3)).tolist()  # all were apart
    [0, 1, 2]
    """
    weight = shares.copy()
    known = weight.sum(axis=1) > 0
    mostly = weight.argmax(axis=1) if weight.shape[1] else np.zeros(len(weight), np.int64)
    whole = np.ones(tree.n_regions, bool)
    root = np.arange(tree.n_regions)
    taken: list[tuple[int, int]] = []
    for (one, other), height in zip(tree.merges.tolist(), tree.heights.tolist(), strict=True):
        limit = threshold
        if known[one] and known[other]:
            limit += together if mostly[one] == mostly[other] else -apart
        whole[one] = whole[one] and whole[other] and height < limit
        if whole[one]:
            taken.append((one, other))
            weight[one] += weight[other]
            known[one] = known[one] or known[other]
            mostly[one] = weight[one].argmax() if weight.shape[1] else 0
    for one, other in reversed(taken):
        root[other] = root[one]
    names, first = np.unique(root, return_index=True)
    rank = np.empty(tree.n_regions, np.int32)
    rank[names[np.argsort(first)]] = np.arange(len(names), dtype=np.int32)
    return rank[root]
