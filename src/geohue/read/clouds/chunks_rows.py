"""Files whose points are rows of one length: binary PLY, and NPY. A stretch is one plain read."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from geohue.read.clouds.chunk import Chunk
from geohue.read.clouds.chunks_color import ColorScale, as_bytes, find_scale
from geohue.read.clouds.cloud import TOO_FAR, find_columns
from geohue.read.clouds.ply import _HEADER_LIMIT, _Element, _Order, _parse_header
from geohue.read.files import broken, reason

_PLACES = 256


@dataclass(frozen=True)
class RowChunks:
    """A file of rows. See `Chunks`.

    Parameters
    ----------
    path : Path
        The file.
    start : int
        Byte at which the first row begins.
    row : numpy.dtype
        A row, with a field for every number.
    n_points : int
        Number of rows.
    coordinates, colors : tuple of str
        The fields that hold them; no colours if empty.
    scale : {"fraction", "byte", "word"}
        What the colours are.
    """

    path: Path
    start: int
    row: np.dtype[Any]
    n_points: int
    coordinates: tuple[str, ...]
    colors: tuple[str, ...]
    scale: ColorScale = "byte"

    @property
    def has_colors(self) -> bool:
        """Whether the file has colours."""
        return bool(self.colors)

    @property
    def is_double(self) -> bool:
        """Whether the coordinates need more than float32."""
        return any(self.row[name].itemsize > 4 for name in self.coordinates)

    def read(self, start: int, stop: int) -> Chunk:
        """Read the points from `start` to `stop` (exclusive)."""
        rows = self._rows(start, stop)
        xyz = np.empty((len(rows), 3))
        with np.errstate(all="ignore"):
            for i, name in enumerate(self.coordinates):
                xyz[:, i] = rows[name]
            xyz[~(np.abs(xyz) < TOO_FAR)] = np.nan
        if not self.colors:
            return xyz, np.zeros((len(rows), 3), np.uint8)
        return xyz, as_bytes(_stacked(rows, self.colors), self.scale, self.path)

    def close(self) -> None:
        """Do nothing: no file stays open."""

    def raw_colors(self, start: int, stop: int) -> NDArray[Any]:
        """Return the file's own colour values, (m, 3)."""
        return _stacked(self._rows(start, stop), self.colors)

    def _rows(self, start: int, stop: int) -> NDArray[Any]:
        # A plain read: the pages of a memory map would count as memory of this process.
        place = self.start + start * self.row.itemsize
        try:
            rows = np.fromfile(self.path, self.row, stop - start, offset=place)
        except OSError as error:
            raise broken(self.path, f"cannot be read ({reason(error)}); check the disk") from error
        if len(rows) < stop - start:
            raise broken(self.path, "is cut short; copy or export it again")
        return rows


def open_ply(path: Path) -> RowChunks:
    """Open a binary PLY file; GeohueError if it is text or its vertices have lists."""
    with path.open("rb") as file:
        order, elements, start = _parse_header(file.read(_HEADER_LIMIT + 64), path)
    if order == "":
        raise broken(path, "is text, which is not read in pieces; save it as binary PLY")
    vertex = None
    for element in elements:
        if element.name == "vertex":
            vertex = element
            break
        start += element.count * _row_of(element, order, path).itemsize
    if vertex is None or vertex.count == 0:
        raise broken(path, "has no vertices; it is not a point cloud")
    row = _row_of(vertex, order, path)
    found = find_columns(dict.fromkeys(row.names or ()))
    if "points" not in found:
        raise broken(path, "has no columns x, y, z; it is not a point cloud")
    return _checked(
        RowChunks(path, start, row, vertex.count, found["points"], found.get("colors", ()))
    )


def open_npy(path: Path) -> RowChunks:
    """Open an NPY file of rows x, y, z, or x, y, z, red, green, blue."""
    with path.open("rb") as file:
        try:
            version = npy.read_magic(file)
            if version not in ((1, 0), (2, 0)):
                raise ValueError(f"NPY version {version}")
            header = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
            shape, by_columns, dtype = header(file)
        except Exception as error:  # a damaged header is evaluated as Python text
            cause = f"is not a whole NPY array ({reason(error)})"
            raise broken(path, f"{cause}; save it again") from error
        start = file.tell()
    if len(shape) != 2 or shape[1] not in (3, 6) or shape[0] < 1 or dtype.kind not in "iuf":
        cause = f"has the shape {str(shape)[:60]} and type {str(dtype)[:60]}"
        raise broken(path, f"{cause}; a cloud is numbers (N, 3), or (N, 6) with colours")
    if by_columns:
        raise broken(path, "is stored column by column; save np.ascontiguousarray of it")
    names = ("x", "y", "z", "red", "green", "blue")[: shape[1]]
    row = np.dtype([(name, dtype) for name in names])
    return _checked(RowChunks(path, start, row, shape[0], names[:3], names[3:]))


def _checked(chunks: RowChunks) -> RowChunks:
    """Hold the size against the file and find the scale of the colours."""
    needed = chunks.start + chunks.n_points * chunks.row.itemsize
    present = chunks.path.stat().st_size
    if present < needed:
        cause = f"is cut short: its header announces {chunks.n_points} points, which need {needed}"
        raise broken(chunks.path, f"{cause} bytes; it has {present}: copy or export it again")
    if not chunks.colors or all(chunks.row[name] == np.uint8 for name in chunks.colors):
        return chunks
    scale = find_scale(chunks.raw_colors, chunks.n_points, _PLACES)
    fields = {f: getattr(chunks, f) for f in chunks.__dataclass_fields__}
    return RowChunks(**(fields | {"scale": scale}))


def _row_of(element: _Element, order: _Order, path: Path) -> np.dtype[Any]:
    if any(p.length is not None for p in element.properties):
        cause = f"has lists in its rows of '{element.name}'"
        raise broken(path, f"{cause}, which are not read in pieces; save the points alone")
    try:
        return np.dtype([(p.name, p.dtype.newbyteorder(order or "=")) for p in element.properties])
    except ValueError as error:
        raise broken(path, f"has a damaged header ({reason(error)}); export it again") from error


def _stacked(rows: NDArray[Any], names: tuple[str, ...]) -> NDArray[Any]:
    return np.stack([rows[name].astype(rows[name].dtype.newbyteorder("=")) for name in names], -1)
