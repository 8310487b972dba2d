"""PLY clouds (and the vertices of PLY meshes): ASCII and binary of either byte order.

An own reader, because trimesh 5.2 wraps 16-bit colours round to 8 bits, gives a text file that
was cut short as an empty cloud, drops the colours named ``diffuse_red`` and the normals and labels
of clouds. It is used by the tests as the second opinion on everything else.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geohue.errors import GeohueError
from geohue.io.atomic import atomic_write
from geohue.io.cloud import CloudData, build_cloud, find_columns
from geohue.io.files import broken, read_bytes
from geohue.io.table import as_declared, read_table, text_lines

_TYPES = {
    "char": "i1",
    "int8": "i1",
    "uchar": "u1",
    "uint8": "u1",
    "short": "i2",
    "int16": "i2",
    "ushort": "u2",
    "uint16": "u2",
    "int": "i4",
    "int32": "i4",
    "uint": "u4",
    "uint32": "u4",
    "int64": "i8",
    "uint64": "u8",
    "float": "f4",
    "float32": "f4",
    "double": "f8",
    "float64": "f8",
}
_ByteOrder = Literal["<", ">"]
_Order = Literal["", "<", ">"]
_FORMATS: dict[str, _Order] = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_HEADER_LIMIT = 1 << 18
_MAX_LIST = 1 << 16  # most values in a list that is read as part of a fixed row


@dataclass(frozen=True, slots=True)
class _Property:
    """A scalar, or (where `length` is set) a list with its length before it."""

    name: str
    dtype: np.dtype[Any]
    length: np.dtype[Any] | None = None


@dataclass(slots=True)
class _Element:
    name: str
    count: int
    properties: list[_Property] = field(default_factory=list)

    def smallest_row(self, text: bool) -> int:
        """Bytes that a row has at least (in text: a digit and a blank a value)."""
        if text:
            return 2 * len(self.properties)
        return sum((p.length or p.dtype).itemsize for p in self.properties)


def read_ply(path: str | Path) -> CloudData:
    """Read the vertices of a PLY file.

    Parameters
    ----------
    path : path-like
        ASCII, binary little-endian or binary big-endian, with any order of properties, any
        number types and any other elements (faces, edges) around the vertices.

    Returns
    -------
    CloudData
        points (N, 3) in the file's unit; colours from red, green, blue (also ``r``, ``g``, ``b``
        and ``diffuse_*``); normals from nx, ny, nz; labels from ``label`` or ``scalar_label``.

    Raises
    ------
    GeohueError
        If the file is missing, damaged, cut short, or has no vertices with x, y and z.

    Examples
    --------
    >>> file = getfixture("tmp_path") / "cloud.ply"
    >>> write_ply(file, [[0, 0, 1], [0, 1, 1]], [[255, 0, 0], [0, 255, 0]], [0, -1])
    >>> read_ply(file).labels
    array([ 0, -1], dtype=int32)
    """
    data = read_bytes(path)
    order, elements, start = _parse_header(data, path)
    vertex = next((element for element in elements if element.name == "vertex"), None)
    if vertex is None or vertex.count == 0:
        raise broken(path, "has no vertices; it is not a point cloud")
    smallest = sum(element.count * element.smallest_row(order == "") for element in elements)
    if smallest > len(data) - start + 1:
        cause = f"is cut short: its header announces {vertex.count} points, which need more bytes"
        raise broken(path, f"{cause} than the {len(data)} in the file; copy or export it again")
    if order == "":
        columns = _read_text(data[start:], elements, path)
    else:
        columns = _read_binary(data, start, order, elements, path)
    return build_cloud(columns, (vertex.count,), path)


def _parse_header(data: bytes, path: str | Path) -> tuple[_Order, list[_Element], int]:
    """Return the byte order ("" for text), the elements and where the body starts."""
    magic = re.match(rb"\s*ply[ \t]*(\r\n|\n|\r)", data[:64])
    if magic is None:
        raise broken(path, "is not a PLY file (it does not start with 'ply')")
    newline = magic.group(1)
    ending = re.search(rb"(?:^|[\r\n])[ \t]*end_header[ \t]*" + newline, data[:_HEADER_LIMIT])
    if ending is None:
        raise broken(path, "is cut short or damaged: its header has no 'end_header' line")
    order: _Order | None = None
    elements: list[_Element] = []
    for line in data[magic.end() : ending.start()].decode("latin-1").splitlines():
        words = line.split()
        if not words or words[0] in ("comment", "obj_info"):
            continue
        try:
            if words[0] == "format":
                order = _FORMATS[words[1]]
            elif words[0] == "element":
                elements.append(_Element(words[1].lower(), _count(words[2])))
            elif words[0] == "property":
                elements[-1].properties.append(_parse_property(words))
            else:
                raise KeyError(words[0])
        except (LookupError, ValueError) as error:
            cause = f"has a header line that PLY does not know: {line.strip()[:60]!r}"
            raise broken(path, f"{cause}; export it again") from error
    if order is None:
        raise broken(path, "has no 'format' line in its header; export it again")
    return order, elements, ending.end()


def _count(word: str) -> int:
    count = int(word)
    if not 0 <= count < 2**62:
        raise ValueError(word)
    return count


def _parse_property(words: list[str]) -> _Property:
    """Parse ``property TYPE NAME`` or ``property list LENGTH_TYPE TYPE NAME``."""
    if words[1] == "list":
        length = np.dtype(_TYPES[words[2]])
        if length.kind == "f":
            raise ValueError(words[2])
        return _Property(words[4].lower(), np.dtype(_TYPES[words[3]]), length)
    return _Property(words[2].lower(), np.dtype(_TYPES[words[1]]))


def _wanted(vertex: _Element) -> list[int]:
    """Return the positions of the scalar properties that become part of a cloud."""
    scalars = {p.name: i for i, p in enumerate(vertex.properties) if p.length is None}
    return [scalars[name] for names in find_columns(scalars).values() for name in names]


def _read_text(body: bytes, elements: list[_Element], path: str | Path) -> dict[str, NDArray[Any]]:
    columns: dict[str, NDArray[Any]] = {}
    lines = text_lines(body)
    for element in elements:
        if element.name == "vertex" and not columns:
            wanted = _wanted(element)
            if not wanted:
                break
            if any(p.length is not None for p in element.properties[: max(wanted)]):
                lists = "has a list before the coordinates in its rows"
                raise broken(path, f"{lists}, which is read from binary files only; export it so")
            width = len(element.properties)
            table = read_table(lines, element.count, wanted, width, path)
            chosen = [element.properties[i] for i in wanted]
            columns = {p.name: as_declared(table[:, j], p.dtype) for j, p in enumerate(chosen)}
        elif element.properties:
            _skip_text(lines, element, path)
    return columns


def _skip_text(lines: Iterator[str], element: _Element, path: str | Path) -> None:
    found = sum(1 for _ in islice(lines, element.count))
    if found < element.count:
        cause = f"is cut short: {found} of {element.count} rows of '{element.name}'"
        raise broken(path, f"{cause}; copy or export it again")


def _read_binary(
    data: bytes, start: int, order: _ByteOrder, elements: list[_Element], path: str | Path
) -> dict[str, NDArray[Any]]:
    columns: dict[str, NDArray[Any]] = {}
    for element in elements:
        rows, start = _read_rows(data, start, element, order, path)
        if element.name == "vertex" and not columns:
            columns = {
                element.properties[i].name: rows[f"{i}"].astype(element.properties[i].dtype)
                for i in _wanted(element)
            }
    return columns


def _read_rows(
    data: bytes, start: int, element: _Element, order: _ByteOrder, path: str | Path
) -> tuple[NDArray[Any], int]:
    """Return the rows with a field a scalar (named by its position) and where they end."""
    if element.count == 0 or not element.properties:
        return np.empty(0, np.void), start
    row = _row_dtype(data, start, element, order)
    end = start + element.count * row.itemsize
    if end <= len(data):
        rows = np.frombuffer(data, row, element.count, start)
        lengths = [name for name in row.names or () if name.startswith("n")]
        if all((rows[name] == rows[name][0]).all() for name in lengths):
            return rows, end
    elif all(p.length is None for p in element.properties):
        raise _cut_short(element, path)
    return _read_uneven_rows(data, start, element, order, path)


def _row_dtype(data: bytes, start: int, element: _Element, order: _ByteOrder) -> np.dtype[Any]:
    """Return the layout of the first row; lists (``n0`` values in ``v0``) fix their length."""
    fields: list[tuple[str, Any]] = []
    position = start
    for i, prop in enumerate(element.properties):
        count = 1
        if prop.length is not None:
            length = prop.length.newbyteorder(order)
            fields.append((f"n{i}", length))
            count = _list_length(data, position, length)
            position += length.itemsize
            fields.append((f"v{i}", (prop.dtype.newbyteorder(order), (min(count, _MAX_LIST),))))
        else:
            fields.append((f"{i}", prop.dtype.newbyteorder(order)))
        position += count * prop.dtype.itemsize
    return np.dtype(fields)


def _list_length(data: bytes, position: int, length: np.dtype[Any]) -> int:
    """Return the length written at a place; 0 past the end (the caller notices)."""
    raw = data[position : position + length.itemsize]
    return max(0, int(np.frombuffer(raw, length)[0])) if len(raw) == length.itemsize else 0


def _read_uneven_rows(
    data: bytes, start: int, element: _Element, order: _ByteOrder, path: str | Path
) -> tuple[NDArray[Any], int]:
    """Walk over rows whose lists differ in length, one by one."""
    byteorder: Literal["little", "big"] = "little" if order == "<" else "big"
    scalars = [(i, p) for i, p in enumerate(element.properties) if p.length is None]
    row = np.dtype([(f"{i}", p.dtype.newbyteorder(order)) for i, p in scalars])
    packed = bytearray()
    steps = [(p.length.itemsize if p.length else 0, p.dtype.itemsize) for p in element.properties]
    position = start
    for _ in range(element.count):
        for length_size, size in steps:
            if length_size:
                end = position + length_size
                position = end + size * int.from_bytes(data[position:end], byteorder)
            else:
                packed += data[position : position + size]
                position += size
        if position > len(data):
            raise _cut_short(element, path)
    return np.frombuffer(packed, row) if scalars else np.empty(0, np.void), position


def _cut_short(element: _Element, path: str | Path) -> GeohueError:
    cause = f"is cut short or damaged within its {element.count} rows of '{element.name}'"
    return broken(path, f"{cause}; copy or export it again")


def write_ply(path: str | Path, points: ArrayLike, colors: ArrayLike, labels: ArrayLike) -> None:
    """Write a labelled cloud as binary little-endian PLY, whole or not at all.

    Parameters
    ----------
    path : path-like
        The file to write; folders are made.
    points : (..., 3)
        Coordinates, written as float32; not finite ones stay so.
    colors : (..., 3) uint8
        sRGB.
    labels : (...) integers
        Written twice: as int ``label`` and as float ``scalar_label``, which CloudCompare shows.

    Raises
    ------
    GeohueError
        If the shapes do not fit together or the file cannot be written.
    """
    columns: dict[str, NDArray[Any]] = {
        "xyz": np.asarray(points, np.float32),
        "rgb": np.asarray(colors, np.uint8),
    }
    label = np.asarray(labels, np.int32)
    for name, values in columns.items():
        if values.shape != (*label.shape, 3):
            shapes = f"{name} has the shape {values.shape}, labels {label.shape}"
            raise broken(path, f"not written: {shapes}; one row of three a label is needed")
    rows = np.empty(label.size, _OUTPUT)
    for name, values in columns.items():
        rows[name] = values.reshape(-1, 3)
    rows["label"] = label.ravel()
    rows["scalar_label"] = label.ravel()
    with atomic_write(path) as temporary, temporary.open("wb") as file:
        file.write(_output_header(label.size).encode())
        file.write(rows.tobytes())


_OUTPUT = np.dtype(
    [
        ("xyz", "<f4", 3),
        ("rgb", "u1", 3),
        ("label", "<i4"),
        ("scalar_label", "<f4"),
    ]
)


def _output_header(count: int) -> str:
    names = ["float x", "float y", "float z"]
    names += ["uchar red", "uchar green", "uchar blue", "int label", "float scalar_label"]
    properties = "".join(f"property {name}\n" for name in names)
    start = "ply\nformat binary_little_endian 1.0\n"
    return f"{start}element vertex {count}\n{properties}end_header\n"
