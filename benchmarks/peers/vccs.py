"""Voxel cloud connectivity segmentation, the usual way to superpoints, for comparison.

After J. Papon, A. Abramov, M. Schoeler, F. Wörgötter, "Voxel cloud connectivity segmentation -
supervoxels for point clouds", CVPR 2013, with the weights of the Point Cloud Library (colour 0.2,
space 0.4, normals 1): points become voxels, seeds lie on a coarser grid, and all supervoxels grow
at the same pace from voxel to neighbouring voxel, each taking those that are nearer to it than to
the one that has them. The Point Cloud Library's normals stand in for the paper's FPFH, as there.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from geohue.compute.compiled import compiled
from geohue.features import lab_of
from geohue.superpoint import loops

Floats = NDArray[np.float64]
Positions = NDArray[np.int64]

COLOR, SPACE, NORMAL = 0.2, 0.4, 1.0
ROUNDS = 1.8
"""How far a supervoxel grows, in its own radius."""


def supervoxels(
    points: Floats, colors: NDArray[np.uint8], voxel: float, seed: float
) -> NDArray[np.int32]:
    """Split a cloud into supervoxels.

    Parameters
    ----------
    points : (n, 3)
    colors : (n, 3) uint8
    voxel, seed : float
        Edge of a voxel, and distance of the seeds.

    Returns
    -------
    (n,) int32
    """
    cell = np.floor((points - points.min(axis=0)) / voxel).astype(np.int64)
    _, place = np.unique(cell, axis=0, return_inverse=True)
    place = place.reshape(-1)
    count = np.bincount(place)
    center = _mean(place, points, count)
    lab = _mean(place, lab_of(colors).astype(np.float64), count)
    pairs = cKDTree(center).query_pairs(voxel * 2.0, output_type="ndarray").astype(np.int64)
    start, beside = loops.csr(pairs[:, 0].copy(), pairs[:, 1].copy(), len(center))
    normals = _normals(center, start, beside)
    seeds = _seeds(center, voxel, seed)
    owner = np.full(len(center), -1, np.int64)
    owner[seeds] = np.arange(len(seeds))
    features = np.hstack([center, lab, normals])
    means = features[seeds].copy()
    distance = np.full(len(center), np.inf)
    distance[seeds] = 0.0
    weights = np.array([SPACE / (3 * seed**2), COLOR / 100**2, NORMAL])
    for _ in range(max(1, int(ROUNDS * seed / voxel))):
        grow(features, means, start, beside, owner, distance, weights, owner.copy())
        _recentre(features, means, owner)
    lost = owner < 0
    if lost.any() and not lost.all():
        nearest = np.asarray(cKDTree(center[~lost]).query(center[lost])[1])
        owner[lost] = owner[~lost][nearest]
    return np.unique(owner, return_inverse=True)[1].reshape(-1)[place].astype(np.int32)


@compiled
def grow(
    features: Floats,
    means: Floats,
    start: Positions,
    beside: Positions,
    owner: Positions,
    distance: Floats,
    weights: Floats,
    before: Positions,
) -> None:
    """Let each supervoxel take the neighbours of its voxels that are nearer to it."""
    for i in range(before.size):
        s = before[i]
        if s < 0:
            continue
        for at in range(start[i], start[i + 1]):
            j = beside[at]
            if owner[j] == s:
                continue
            space, color, dot = 0.0, 0.0, 0.0
            for c in range(3):
                space += (features[j, c] - means[s, c]) ** 2
                color += (features[j, c + 3] - means[s, c + 3]) ** 2
                dot += features[j, c + 6] * means[s, c + 6]
            turn = 1.0 - abs(dot)
            d = np.sqrt(weights[0] * space + weights[1] * color + weights[2] * turn * turn)
            if d < distance[j]:
                owner[j], distance[j] = s, d


def _recentre(features: Floats, means: Floats, owner: Positions) -> None:
    """Set the mean of each supervoxel anew; normals keep the sign of the one before."""
    held = np.flatnonzero(owner >= 0)
    names = owner[held]
    count = np.maximum(np.bincount(names, minlength=len(means)), 1)
    rows = features[held].copy()
    against = (rows[:, 6:] * means[names, 6:]).sum(axis=1) < 0
    rows[against, 6:] *= -1
    for c in range(9):
        means[:, c] = np.bincount(names, rows[:, c], len(means)) / count
    length = np.sqrt((means[:, 6:] ** 2).sum(axis=1, keepdims=True))
    means[:, 6:] /= np.maximum(length, 1e-12)


def _seeds(center: Floats, voxel: float, seed: float) -> Positions:
    """The voxels nearest to the middles of the seeds' cells, where enough lie around."""
    low = center.min(axis=0)
    cell = np.floor((center - low) / seed).astype(np.int64)
    cells = np.unique(cell, axis=0)
    tree = cKDTree(center)
    found = np.unique(np.asarray(tree.query(low + (cells + 0.5) * seed)[1], np.int64))
    # Fewer than a plane through half the search radius would give: an edge or noise.
    near = tree.query_ball_point(center[found], seed / 2, return_length=True)
    around = np.asarray(near)
    enough = around > 0.5 * np.pi * (seed / 2) ** 2 / voxel**2 / 2
    return found[enough] if enough.any() else found


def _mean(place: Positions, values: Floats, count: Positions) -> Floats:
    sums = np.stack([np.bincount(place, column) for column in values.T], axis=1)
    return np.asarray(sums / count[:, None])


def _normals(center: Floats, start: Positions, beside: Positions) -> Floats:
    local = center - center.mean(axis=0)
    sums, into, normals = (
        np.empty((len(center), 10)),
        np.empty((len(center), 10)),
        np.zeros_like(local),
    )
    loops.moments(local, sums)
    loops.gather(sums, start, beside, into, 0, len(center))
    loops.least_spread(into, normals, np.empty(6), 0, len(center))
    return np.asarray(normals)
