"""PCD clouds (Point Cloud Library): ascii, binary and binary_compressed, also organised ones.

The header and the arrays are read here, because pypcd4 1.5 believes the sizes that a header gives
and loses tabs, repeated blanks and the width and height of organised clouds; the LZF decoder that
it brings is used, after both sizes have been checked, and pypcd4 itself checks this in the tests.
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.read.clouds.cloud import CloudData, build_cloud, find_columns
from geohue.read.clouds.table import as_declared, read_table, text_lines
from geohue.read.files import broken, read_bytes

_HEADER_LIMIT = 1 << 16
_SIZES = {"F": (4, 8), "I": (1, 2, 4, 8), "U": (1, 2, 4, 8)}
_LZF_MOST = 100  # 3 bytes stand for at most 264


@dataclass(frozen=True, slots=True)
class _Field:
    name: str
    dtype: np.dtype[Any]
    count: int

    @property
    def itemsize(self) -> int:
        return self.dtype.itemsize * self.count


@dataclass(frozen=True, slots=True)
class _Header:
    fields: tuple[_Field, ...]
    width: int
    height: int
    encoding: str
    start: int

    @property
    def points(self) -> int:
        return self.width * self.height

    @property
    def itemsize(self) -> int:
        return sum(f.itemsize for f in self.fields)

    def wanted(self) -> list[int]:
        """Return the positions of the fields that become part of a cloud."""
        single = {f.name: i for i, f in enumerate(self.fields) if f.count == 1}
        names = [name for names in find_columns(single).values() for name in names]
        names += [name for name in ("rgb", "rgba") if name in single]
        return [single[name] for name in names]


def read_pcd(path: str | Path) -> CloudData:
    """Read a PCD file.

    Parameters
    ----------
    path : path-like
        Version 0.7 or older; ascii, binary or binary_compressed.

    Returns
    -------
    CloudData
        points (N, 3), or (H, W, 3) where the file's HEIGHT is more than 1, in the file's unit
        and frame (VIEWPOINT is not applied); colours from packed ``rgb`` or ``rgba`` or from
        ``r``, ``g``, ``b``; normals from ``normal_x`` ..; labels from ``label``.

    Raises
    ------
    GeohueError
        If the file is missing, damaged, cut short, or has no fields x, y and z.
    """
    data = read_bytes(path)
    header = _parse_header(data, path)
    if header.points == 0:
        raise broken(path, "has no points; export it again")
    reader = {"ascii": _read_text, "binary": _read_binary, "binary_compressed": _read_compressed}
    columns = reader[header.encoding](data, header, path)
    packed = next((columns.pop(name) for name in ("rgb", "rgba") if name in columns), None)
    columns.pop("rgba", None)
    colors = None if packed is None else _unpack_color(packed)
    shape = (header.height, header.width) if header.height > 1 else (header.width,)
    return build_cloud(columns, shape, path, colors)


def _parse_header(data: bytes, path: str | Path) -> _Header:
    """Parse the lines up to DATA; sizes are plausible afterwards, not yet checked with the file."""
    head = data[:_HEADER_LIMIT]
    ending = re.search(rb"^[ \t]*DATA[ \t]+(\w+)[ \t]*(?:\r\n|\n|\r)", head, re.MULTILINE)
    if ending is None:
        raise broken(path, "is not a PCD file, or its header is cut short (no DATA line)")
    values: dict[str, list[str]] = {}
    for line in head[: ending.start()].decode("latin-1").splitlines():
        words = line.split()
        if words and not words[0].startswith("#"):
            values.setdefault(words[0].upper(), words[1:])
    encoding = ending.group(1).decode().lower()
    if encoding not in ("ascii", "binary", "binary_compressed"):
        raise broken(path, f"has the unknown encoding DATA {encoding[:30]}; export it as binary")
    try:
        width, height = _size(values)
        return _Header(_fields(values), width, height, encoding, ending.end())
    except (LookupError, ValueError) as error:
        raise broken(path, f"has a damaged PCD header ({error}); export it again") from error


def _size(values: dict[str, list[str]]) -> tuple[int, int]:
    width = int(values["WIDTH"][0]) if "WIDTH" in values else int(values["POINTS"][0])
    height = int(values.get("HEIGHT", ["1"])[0])
    points = int(values["POINTS"][0]) if "POINTS" in values else width * height
    if min(width, height, points) < 0 or points != width * height or points >= 2**62:
        raise ValueError(f"WIDTH {width} x HEIGHT {height} is not POINTS {points}")
    return width, height


def _fields(values: dict[str, list[str]]) -> tuple[_Field, ...]:
    names, types, sizes = values["FIELDS"], values["TYPE"], values["SIZE"]
    counts = values.get("COUNT", ["1"] * len(names))
    fields = []
    for name, kind, size, count in zip(names, types, sizes, counts, strict=True):
        if int(size) not in _SIZES[kind.upper()] or not 0 <= int(count) < 2**31:
            raise ValueError(f"field {name[:20]}: TYPE {kind} SIZE {size} COUNT {count}")
        fields.append(_Field(name.lower(), np.dtype(f"<{kind.lower()}{size}"), int(count)))
    return tuple(fields)


def _need(path: str | Path, header: _Header, needed: int, present: int) -> None:
    if present < needed:
        cause = f"is cut short: {header.points} points need {needed} bytes, {present} are there"
        raise broken(path, f"{cause}; copy or export it again")


def _read_text(data: bytes, header: _Header, path: str | Path) -> dict[str, NDArray[Any]]:
    width = sum(f.count for f in header.fields)
    _need(path, header, header.points * 2 * width - 1, len(data) - header.start)
    wanted = header.wanted()
    if not wanted:
        return {}
    first = np.cumsum([0, *(f.count for f in header.fields)])
    lines = text_lines(data[header.start :])
    table = read_table(lines, header.points, [int(first[i]) for i in wanted], width, path)
    columns: dict[str, NDArray[Any]] = {}
    for j, i in enumerate(wanted):
        field = header.fields[i]
        unpack = _pack_text if field.name in ("rgb", "rgba") else as_declared
        columns[field.name] = unpack(table[:, j], field.dtype)
    return columns


def _pack_text(values: NDArray[np.float64], dtype: np.dtype[Any]) -> NDArray[Any]:
    """Bring a packed colour that was written as a number back to its 4-byte form."""
    with np.errstate(all="ignore"):
        if dtype.kind == "f":
            return values.astype(np.float32)
        inside = np.abs(values) < 2**32
        return np.where(inside, values, 0.0).astype(np.int64).astype(np.uint32)


def _read_binary(data: bytes, header: _Header, path: str | Path) -> dict[str, NDArray[Any]]:
    _need(path, header, header.points * header.itemsize, len(data) - header.start)
    starts = np.cumsum([0, *(f.itemsize for f in header.fields)]).tolist()
    wanted = header.wanted()
    if not wanted:
        return {}
    row = np.dtype(
        {
            "names": [f"{i}" for i in wanted],
            "formats": [header.fields[i].dtype for i in wanted],
            "offsets": [starts[i] for i in wanted],
            "itemsize": header.itemsize,
        }
    )
    rows = np.frombuffer(data, row, header.points, header.start)
    return {header.fields[i].name: np.ascontiguousarray(rows[f"{i}"]) for i in wanted}


def _read_compressed(data: bytes, header: _Header, path: str | Path) -> dict[str, NDArray[Any]]:
    """Decompress; the fields follow one another, all values of the first coming first."""
    lzf: Any = import_module("lzf")  # the decoder that pypcd4 depends on; it has no types
    _need(path, header, 8, len(data) - header.start)
    compressed, size = struct.unpack_from("<II", data, header.start)
    start = header.start + 8
    _need(path, header, compressed, len(data) - start)
    if size != header.points * header.itemsize or size > _LZF_MOST * compressed:
        cause = f"has {size} bytes of data instead of {header.points * header.itemsize}"
        raise broken(path, f"is damaged: {cause}; export it again")
    try:
        raw = lzf.decompress(data[start : start + compressed], size)
    except (ValueError, MemoryError) as error:
        raise broken(path, f"has damaged compressed data ({error}); export it again") from error
    if raw is None or len(raw) != size:
        raise broken(path, "has damaged compressed data; export it again")
    columns = {}
    starts = np.cumsum([0, *(f.itemsize * header.points for f in header.fields)]).tolist()
    for i in header.wanted():
        field = header.fields[i]
        columns[field.name] = np.frombuffer(raw, field.dtype, header.points, starts[i])
    return columns


def _unpack_color(packed: NDArray[Any]) -> NDArray[np.uint8] | None:
    """Split 0xAARRGGBB, held in 4 bytes of any type, into (N, 3) red, green, blue."""
    if packed.dtype.itemsize != 4:
        return None
    bits = np.ascontiguousarray(packed).view(np.uint32)
    channels = [(bits >> shift & 255).astype(np.uint8) for shift in (16, 8, 0)]
    return np.stack(channels, axis=-1)
