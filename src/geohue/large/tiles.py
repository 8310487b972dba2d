"""A cloud on disk sorted into boxes of about as many points each, in one pass over its file."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geohue.large.passes import BLOCK
from geohue.large.sample import SAMPLE_ROW
from geohue.read.clouds.chunk import Chunks
from geohue.read.files import broken

Floats = NDArray[np.float64]
Positions = NDArray[np.int64]

TILE = 500_000
"""Points of a tile, at most, but for the chance of the sample. Fixed: the labels then do not depend
on the memory."""

_MARGIN = 64 * 2**20
_LEAST = 8  # points of the sample in a box that is still halved


@dataclass(frozen=True, slots=True, eq=False)
class Tiles:
    """Boxes that fill space, as a tree of halvings.

    Attributes
    ----------
    axis : (H,) int64
        Along which axis each box is halved, -1 = it is a tile.
    cut : (H,) float64
        Where: points below lie in the first half.
    child : (H, 2) int64
        The two halves; of a tile, its number twice.
    low, high : (T, 3) float64
        Corners of the tiles, infinite outside.
    """

    axis: Positions
    cut: Floats
    child: Positions
    low: Floats
    high: Floats

    @classmethod
    def of(cls, sample: Floats, most: float) -> Tiles:
        """Halve the space of a sample, (m, 3), until no box has more than `most` of its points.

        Examples
        --------
        >>> tiles = Tiles.of(np.arange(96.0).reshape(32, 3), 16)
        >>> len(tiles), tiles.find(np.array([[0.0, 1, 2], [93, 94, 95]])).tolist()
        (2, [0, 1])
        """
        rows: list[tuple[int, float, int, int]] = []
        corners: list[Floats] = []

        def halve(points: Floats, box: Floats) -> int:
            at = len(rows)
            rows.append((-1, 0.0, len(corners), len(corners)))
            size = np.ptp(points, axis=0) if len(points) else np.zeros(3)
            if len(points) <= max(most, _LEAST) or not size.any():
                corners.append(box)
                return at
            axis = int(size.argmax())
            along = points[:, axis]
            cut = float(np.median(along))
            if cut == along.min():
                cut = float(along[along > cut].min())
            below = along < cut
            first, second = box.copy(), box.copy()
            first[1, axis] = second[0, axis] = cut
            rows[at] = axis, cut, halve(points[below], first), halve(points[~below], second)
            return at

        halve(sample, np.array([[-np.inf] * 3, [np.inf] * 3]))
        axis, cut, one, two = zip(*rows, strict=True)
        low, high = np.stack(corners, axis=1)
        return cls(np.array(axis), np.array(cut), np.array([one, two]).T, low, high)

    def __len__(self) -> int:
        return len(self.low)

    def find(self, xyz: Floats) -> NDArray[np.int32]:
        """Return the tile of each of (n, 3) points, -1 for those without a position."""
        known = np.isfinite(xyz).all(axis=1)
        found = np.full(len(xyz), -1, np.int32)
        waiting = [(0, np.flatnonzero(known))]
        while waiting:
            at, rows = waiting.pop()
            if self.axis[at] < 0:
                found[rows] = self.child[at, 0]
                continue
            below = xyz[rows, self.axis[at]] < self.cut[at]
            waiting += [(self.child[at, 0], rows[below]), (self.child[at, 1], rows[~below])]
        return found


@dataclass(frozen=True, slots=True)
class Buckets:
    """The points of each tile in files of their own, in the order of the cloud.

    Attributes
    ----------
    folder : Path
        Where they are: ``points-T.bin`` of each tile with rows of `SAMPLE_ROW`, and ``tiles.bin``,
        int32, the tile of each point of the cloud.
    """

    folder: Path

    def points(self, tile: int) -> Path:
        """Return the file of the points of a tile."""
        return self.folder / f"points-{tile}.bin"

    def regions(self, tile: int) -> Path:
        """Return the file of the region of each point of a tile, int32."""
        return self.folder / f"regions-{tile}.bin"

    def rows(self, tile: int) -> NDArray[np.void]:
        """Return the points of a tile."""
        return np.fromfile(self.points(tile), SAMPLE_ROW)

    def fill(self, source: Chunks, tiles: Tiles) -> Iterator[int]:
        """Sort a cloud into the tiles; yields how many of its points are done.

        Raises
        ------
        GeohueError
            If the disk is too small.
        """
        needed = source.n_points * (SAMPLE_ROW.itemsize + 8 + 16)
        free = shutil.disk_usage(self.folder).free
        if free < needed + _MARGIN:
            wish = f"{needed / 1e9:.3g} GB are needed, {free / 1e9:.3g} GB free"
            raise broken(self.folder, f"the tiles do not fit on the disk: {wish}")
        for tile in range(len(tiles)):
            self.points(tile).write_bytes(b"")
        with (self.folder / "tiles.bin").open("wb") as places:
            for start, (xyz, rgb) in blocks_of(source):
                found = tiles.find(xyz)
                places.write(found.tobytes())
                rows = np.empty(len(xyz), SAMPLE_ROW)
                rows["xyz"], rows["rgb"] = xyz, rgb
                order = np.argsort(found, kind="stable")
                for tile, part in _runs(found[order], order):
                    with self.points(tile).open("ab") as file:
                        file.write(rows[part].tobytes())
                yield start + len(xyz)

    def around(
        self, tile: int, tiles: Tiles, bounds: Floats, width: float
    ) -> Iterator[tuple[int, Positions, NDArray[np.void]]]:
        """Yield the points of other tiles near a tile: which tile, which of its rows, the points.

        Parameters
        ----------
        tile : int
            The tile.
        tiles : Tiles
            All of them.
        bounds : (T, 2, 3) float64
            The box of the points of each tile.
        width : float
            How far from the tile they lie at most, along each axis.
        """
        low, high = tiles.low[tile] - width, tiles.high[tile] + width
        near = (bounds[:, 0] <= high).all(axis=1) & (bounds[:, 1] >= low).all(axis=1)
        for other in np.flatnonzero(near).tolist():
            if other == tile:
                continue
            rows = np.memmap(self.points(other), SAMPLE_ROW, "r")
            for start in range(0, len(rows), BLOCK):
                block = np.array(rows[start : start + BLOCK])
                inside = ((block["xyz"] >= low) & (block["xyz"] <= high)).all(axis=1)
                if inside.any():
                    yield other, start + np.flatnonzero(inside), block[inside]


def blocks_of(source: Chunks) -> Iterator[tuple[int, tuple[Floats, NDArray[np.uint8]]]]:
    """Yield the points of a cloud, block by block, with the number of the first one."""
    try:
        for start in range(0, source.n_points, BLOCK):
            yield start, source.read(start, min(start + BLOCK, source.n_points))
    finally:
        source.close()


def in_file_order(buckets: Buckets, n_points: int, starts: Positions) -> Iterator[Positions]:
    """Yield the region of each point of a cloud, in blocks, -1 = none.

    Parameters
    ----------
    buckets : Buckets
        With the regions of each tile.
    n_points : int
        Points in the cloud.
    starts : (T,) int64
        What is added to the regions of each tile.
    """
    done = np.zeros(len(starts), np.int64)
    with (buckets.folder / "tiles.bin").open("rb") as places:
        for start in range(0, n_points, BLOCK):
            found = np.fromfile(places, np.int32, min(BLOCK, n_points - start))
            regions = np.full(len(found), -1, np.int64)
            order = np.argsort(found, kind="stable")
            for tile, part in _runs(found[order], order):
                file = buckets.regions(tile)
                own = np.fromfile(file, np.int32, len(part), offset=4 * int(done[tile]))
                regions[part] = own + starts[tile]
                done[tile] += len(part)
            yield regions


def _runs(tiles: NDArray[np.int32], order: Positions) -> Iterator[tuple[int, Positions]]:
    """Yield each tile among sorted ones with its part of `order`; -1 is left out."""
    edges = np.flatnonzero(np.diff(tiles, prepend=-2, append=-2))
    for start, stop in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        if tiles[start] >= 0:
            yield int(tiles[start]), order[start:stop]
