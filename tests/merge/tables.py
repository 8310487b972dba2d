"""Random points, neighbours and regions to merge."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.merge.evidence import Evidence


def random_evidence(
    seed: int, regions: int = 8, size: int = 6, pieces: int = 1, cuts: int = 3
) -> tuple[Evidence, NDArray[np.int32]]:
    """Evidence without any structure, and regions of at least four points.

    Points of one piece are paired with each other alone; pieces are linked as distant.
    """
    rng = np.random.default_rng(seed)
    sizes = rng.integers(4, 4 + size, regions)
    labels = np.repeat(np.arange(regions, dtype=np.int32), sizes)
    labels = rng.permutation(labels)
    n, piece = len(labels), labels % pieces
    pairs = rng.integers(0, n, (5 * n, 2))
    pairs = np.unique(np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1), axis=0)
    pairs = rng.permutation(pairs[piece[pairs[:, 0]] == piece[pairs[:, 1]]])
    links = rng.integers(0, n, (4 * pieces * (pieces > 1), 2))
    normals = rng.normal(size=(n, 3))
    e = len(pairs)
    evidence = Evidence(
        lab=rng.normal(0, 20, (n, 3)),
        points=rng.normal(size=(n, 3)),
        normals=normals / np.linalg.norm(normals, axis=1, keepdims=True),
        unit=rng.uniform(1, 3, n),
        one=pairs[:, 0],
        other=pairs[:, 1],
        share=rng.random(e),
        step=rng.random(e),
        gap=rng.random(e),
        depth_step=rng.uniform(0, 0.1, e),
        texture=rng.integers(0, 8, n),
        cuts=[rng.integers(0, k + 2, n).astype(np.int32) for k in range(cuts)],
        distant=links[labels[links[:, 0]] != labels[links[:, 1]]],
    )
    return evidence, labels
