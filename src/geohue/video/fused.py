"""All frames in one coloured cloud with the labels of the tracks, in bounded memory."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.results.ply import write_ply
from geohue.scene import Scene

MOST = 2_000_000
"""Voxels beyond which they are made twice as large."""

EVERY = 2
"""Rows and columns of a frame of which one is taken."""

_REACH = 1 << 20
_WAITING = 400_000


class FusedCloud:
    """Voxels with the mean colour and place of the points that fell into each, and its label.

    The label is that of the majority, found with one counter (Boyer and Moore 1981), so that a
    voxel takes 72 bytes however many points fall into it. A thing that moves leaves its trace.

    Parameters
    ----------
    size : float
        Edge of a voxel in the unit of the poses, positive.
    most : int
        Voxels beyond which their edge is doubled.

    Raises
    ------
    GeohueError
        For a size that is not positive.
    """

    def __init__(self, size: float = 0.01, most: int = MOST) -> None:
        if not (np.isfinite(size) and size > 0):
            raise GeohueError(f"the voxels' size is {size}: expected a length above 0")
        self.size, self._most = float(size), most
        self._key = np.zeros(0, np.int64)
        self._sums = np.zeros((0, 7))  # x, y, z, red, green, blue, count
        self._label, self._lead = np.zeros(0, np.int32), np.zeros(0, np.int64)
        self._waiting: list[tuple[NDArray[np.float64], NDArray[np.int32]]] = []

    def __len__(self) -> int:
        self._settle()
        return len(self._key)

    def add(
        self, scene: Scene, labels: NDArray[np.int32], pose: NDArray[np.float64] | None
    ) -> None:
        """Add a frame; one without a pose or without depth adds nothing."""
        if pose is None:
            return
        points = scene.points[::EVERY, ::EVERY].reshape(-1, 3)
        there = np.isfinite(points[:, 2])
        world = points[there] @ pose[:3, :3].T + pose[:3, 3]
        colors = scene.colors[::EVERY, ::EVERY].reshape(-1, 3)[there]
        names = labels[::EVERY, ::EVERY].reshape(-1)[there]
        rows = np.concatenate([world, colors, np.ones((len(world), 1))], axis=1)
        self._waiting.append((rows, names))
        if sum(len(one) for _, one in self._waiting) > _WAITING:
            self._settle()

    def write(self, path: str | Path) -> None:
        """Write the cloud as PLY with the properties ``label`` and ``scalar_label``."""
        self._settle()
        mean = self._sums[:, :6] / np.maximum(self._sums[:, 6:], 1)
        write_ply(path, mean[:, :3], np.rint(mean[:, 3:]).astype(np.uint8), self._label)

    def _settle(self) -> None:
        """Put what waits into the voxels."""
        if not self._waiting:
            return
        rows = np.concatenate([rows for rows, _ in self._waiting])
        names = np.concatenate([names for _, names in self._waiting])
        self._waiting = []
        key, known = _keys(rows[:, :3], self.size)
        self._merge(key[known], rows[known], names[known], np.ones(int(known.sum()), np.int64))
        while len(self._key) > self._most:
            self.size *= 2
            middle = self._sums[:, :3] / self._sums[:, 6:]
            key, sums, names, lead = self._key, self._sums, self._label, self._lead
            key, known = _keys(middle, self.size)
            self._key, self._sums = np.zeros(0, np.int64), np.zeros((0, 7))
            self._label, self._lead = np.zeros(0, np.int32), np.zeros(0, np.int64)
            self._merge(key[known], sums[known], names[known], lead[known])

    def _merge(
        self,
        key: NDArray[np.int64],
        sums: NDArray[np.float64],
        names: NDArray[np.int32],
        lead: NDArray[np.int64],
    ) -> None:
        key = np.concatenate([self._key, key])
        cells, place = np.unique(key, return_inverse=True)
        sums = np.concatenate([self._sums, sums])
        total = [np.bincount(place, column, len(cells)) for column in sums.T]
        names, lead = np.concatenate([self._label, names]), np.concatenate([self._lead, lead])
        self._label, self._lead = _majority(place, names, lead, len(cells))
        self._key, self._sums = cells, np.stack(total, axis=1)


def _keys(points: NDArray[np.float64], size: float) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """The voxel of each point as one number, and which lie within reach of it."""
    cell = np.floor(points / size)
    known = np.asarray((np.abs(cell) < _REACH).all(axis=1))
    part = np.where(known[:, None], cell, 0).astype(np.int64) + _REACH
    return (part[:, 0] << 42) | (part[:, 1] << 21) | part[:, 2], known


def _majority(
    place: NDArray[np.int64], names: NDArray[np.int32], lead: NDArray[np.int64], n: int
) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """The label with the most votes in each voxel, and by how many it leads all others."""
    width = int(names.max(initial=0)) + 2
    pairs, inverse = np.unique(place * width + names + 1, return_inverse=True)
    votes = np.bincount(inverse, lead, len(pairs)).astype(np.int64)
    voxel = pairs // width
    order = np.lexsort((votes, voxel))
    last = np.append(voxel[order][1:] != voxel[order][:-1], True)
    best = order[last]
    label = (pairs[best] % width - 1).astype(np.int32)
    rest = np.bincount(voxel, votes, n).astype(np.int64) - votes[best]
    return label, np.maximum(votes[best] - rest, 0)
