"""LAS, LAZ and COPC clouds piece by piece, with laspy.

A LAZ file is compressed in chunks of its own (usually 50,000 points); a stretch that begins inside
one costs the decompression from its beginning. Where chunks differ in size (COPC), it costs that of
all before it, so stretches are best read in order.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.read.clouds.chunk import Chunk
from geohue.read.clouds.chunks_color import ColorScale, as_bytes, find_scale
from geohue.read.clouds.cloud import TOO_FAR
from geohue.read.clouds.las_head import read_head
from geohue.read.clouds.laz_check import check_laz
from geohue.read.extras import optional
from geohue.read.files import broken, reason

_COLORS = ("red", "green", "blue")
_SKIP = 100_000  # points that are read at once to get past them
_PLACES = 16  # each may cost the decompression of a whole chunk


@dataclass
class LasChunks:
    """A LAS or LAZ file. See `Chunks`."""

    path: Path
    n_points: int
    compressed: bool
    has_colors: bool = False
    scale: ColorScale = "byte"
    is_double: bool = True
    is_variable: bool = False
    """Whether the compressed chunks differ in their points, as in COPC: no seeking in it."""
    _reader: Any = field(default=None, repr=False, compare=False)

    def read(self, start: int, stop: int) -> Chunk:
        """Read the points from `start` to `stop` (exclusive)."""
        points = self._points(start, stop)
        with np.errstate(all="ignore"):  # a damaged header may scale beyond all numbers
            xyz = np.stack([np.asarray(points[axis], np.float64) for axis in "xyz"], axis=-1)
        xyz[~(np.abs(xyz) < TOO_FAR)] = np.nan
        if not self.has_colors:
            return xyz, np.zeros(xyz.shape, np.uint8)
        return xyz, as_bytes(_colors_of(points), self.scale, self.path)

    def close(self) -> None:
        """Let go of the file; the next `read` opens it again."""
        if self._reader is not None:
            self._reader.close()
            self._reader = None

    def raw_colors(self, start: int, stop: int) -> NDArray[Any]:
        """Return the file's own colour values, (m, 3)."""
        return _colors_of(self._points(start, stop))

    def dimensions(self) -> set[str]:
        """Return the names of what a point has."""
        with self._decoding("in its header"):
            return set(self._open().header.point_format.dimension_names)

    def _points(self, start: int, stop: int) -> Any:
        with self._decoding(f"near point {start}"):
            reader = self._open()
            if reader.points_read != start:
                reader = self._at(int(start))  # laspy counts up to a NumPy integer, one by one
            points = reader.read_points(stop - start)
        if len(points) < stop - start:
            self.close()
            raise broken(self.path, f"is cut short near point {start}; copy or export it again")
        return points

    def _at(self, start: int) -> Any:
        """Return the reader, its next point being `start`."""
        reader = self._open()
        if not self.is_variable:
            reader.seek(start)
            return reader
        # lazrs seeks as if all chunks had as many points as the first, and gives wrong points.
        if reader.points_read > start:
            self.close()
            reader = self._open()
        while reader.points_read < start:
            before = reader.points_read
            reader.read_points(min(_SKIP, start - before))
            if reader.points_read == before:
                break  # cut short; the next read says so
        return reader

    @contextmanager
    def _decoding(self, where: str) -> Iterator[None]:
        """Turn whatever goes wrong inside into one error that names the place."""
        try:
            yield
        except (GeohueError, KeyboardInterrupt, SystemExit):
            raise
        except BaseException as error:  # lazrs is Rust: a panic is no Exception
            self.close()
            cause = f"is damaged {where} ({reason(error)})"
            raise broken(self.path, f"{cause}; export it again") from error

    def _open(self) -> Any:
        if self._reader is None:
            laspy = optional("laspy", "clouds", self.path)
            # One thread: the processes of a run share the cores.
            wanted = laspy.DecompressionSelection
            self._reader = laspy.open(
                self.path,
                laz_backend=laspy.LazBackend.Lazrs,
                decompression_selection=wanted.XY_RETURNS_CHANNEL | wanted.Z | wanted.RGB,
            )
        return self._reader

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_reader": None}


def open_las(path: Path) -> LasChunks:
    """Open a LAS or LAZ file, its header and tables held against its size first."""
    optional("laspy", "clouds", path)
    chunks = _checked(path)
    try:
        if not chunks.dimensions().issuperset(_COLORS):
            return chunks
        scale = find_scale(chunks.raw_colors, chunks.n_points, _PLACES)
    finally:
        chunks.close()
    return replace(chunks, has_colors=True, scale=scale)


def _checked(path: Path) -> LasChunks:
    with path.open("rb") as file:
        head = read_head(file, path.stat().st_size, path)
        if head.compressed:
            layout = check_laz(file, head, optional("lazrs", "clouds", path), path)
            return LasChunks(path, head.count, True, is_variable=layout.is_variable)
    return LasChunks(path, head.count, False)


def _colors_of(points: Any) -> NDArray[Any]:
    return np.stack([np.asarray(points[name]) for name in _COLORS], axis=-1)
