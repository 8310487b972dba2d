"""LAS, LAZ and COPC clouds, with laspy (and lazrs for the compressed ones).

The sizes in the header are held against the file before laspy sees it: it allocates what a header
announces. A COPC file is a LAZ file whose octree is not needed to read all points.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.read.clouds.cloud import CloudData, build_cloud
from geohue.read.clouds.laz_check import check_laz
from geohue.read.extras import optional
from geohue.read.files import broken, read_bytes, reason

MAX_POINTS = 1 << 28
"""Most points that a compressed file may announce."""

_CHUNK = 1_000_000
_MOST_PER_BYTE = 100  # points that a byte of compressed data stands for
_HEADER = struct.Struct("<4s20xBB68xHIIBHI")  # up to the old count of points
_COLORS = ("red", "green", "blue")
_LABELS = ("segment_id", "label", "scalar_label")


@dataclass(frozen=True, slots=True)
class _Head:
    """What the header says, as far as it must fit the file."""

    count: int
    start: int
    size: int
    n_vlrs: int
    compressed: bool


def read_las(path: str | Path) -> CloudData:
    """Read a LAS, LAZ or COPC file.

    Parameters
    ----------
    path : path-like
        LAS 1.0 to 1.4, any point format; compressed files need lazrs too.

    Returns
    -------
    CloudData
        points (N, 3) less `offset`; colours where the point format has them, 16-bit ones
        recognised; labels from an extra dimension ``segment_id`` or ``label``.

    Raises
    ------
    GeohueError
        If laspy is not installed, or the file is missing, damaged or cut short.
    """
    data = read_bytes(path)
    head = _check_header(data, path)
    laspy = optional("laspy", "clouds", path)
    if head.compressed:
        lazrs = optional("lazrs", "clouds", path)
        check_laz(data, head.start, head.size, head.n_vlrs, lazrs, Path(path))
    try:
        columns = _columns(laspy, data, head)
    except GeohueError:
        raise
    except MemoryError as error:
        raise broken(path, "needs more memory than there is; thin it first") from error
    except BaseException as error:  # lazrs is Rust: a panic is no Exception
        if isinstance(error, KeyboardInterrupt | SystemExit):
            raise
        raise broken(path, f"is damaged ({reason(error)}); export it again") from error
    count = len(columns["x"])
    if count < head.count:
        cause = f"is cut short: {count} of {head.count} points"
        raise broken(path, f"{cause}; copy or export it again")
    return build_cloud(columns, (count,), path)


def _check_header(data: bytes, path: str | Path) -> _Head:
    if not data.startswith(b"LASF"):
        raise broken(path, "is not a LAS file (it does not start with 'LASF')")
    if len(data) < 227:
        raise broken(path, "is cut short within its header; copy or export it again")
    _, major, minor, size, start, n_vlrs, form, record, count = _HEADER.unpack_from(data)
    if (major, minor) >= (1, 4):
        if len(data) < 375:
            raise broken(path, "is cut short within its header; copy or export it again")
        (count,) = struct.unpack_from("<Q", data, 247)
        _check_extended(data, path)
    compressed = bool(form & 0x80)
    body = len(data) - start
    if major != 1 or not 227 <= size <= start or body < 0 or n_vlrs * 54 > len(data) or record < 20:
        raise broken(path, "has a damaged LAS header; export it again")
    if count == 0:
        raise broken(path, "has no points; export it again")
    most = body * _MOST_PER_BYTE if compressed else body // record
    if count > min(most, MAX_POINTS):
        cause = f"announces {count} points, which do not fit in its {len(data)} bytes"
        raise broken(path, f"{cause}; copy or export it again")
    return _Head(count, start, size, n_vlrs, compressed)


def _check_extended(data: bytes, path: str | Path) -> None:
    """Check that the extended records of LAS 1.4 lie in the file, each of them."""
    position, count = struct.unpack_from("<QI", data, 235)
    for _ in range(min(count, len(data) // 60 + 1)):
        if position + 60 > len(data):
            raise broken(path, "is cut short within its extended records; copy it again")
        (length,) = struct.unpack_from("<Q", data, position + 20)
        position += 60 + length
    if count and position > len(data):
        raise broken(path, "is cut short within its extended records; copy it again")


def _columns(laspy: Any, data: bytes, head: _Head) -> dict[str, NDArray[Any]]:
    """Read chunk by chunk, so that a lying header costs no more than the data behind it."""
    import io

    parts: dict[str, list[NDArray[Any]]] = {}
    with laspy.open(io.BytesIO(data)) as reader:
        names = set(reader.header.point_format.dimension_names)
        wanted = [n for n in _COLORS if names.issuperset(_COLORS)]
        label = next((n for n in _LABELS if n in names), None)
        for chunk in reader.chunk_iterator(min(_CHUNK, head.count)):
            for name in ("x", "y", "z"):
                parts.setdefault(name, []).append(np.array(chunk[name], np.float64))
            for name in wanted:
                parts.setdefault(name, []).append(np.array(chunk[name]))
            if label is not None:
                parts.setdefault("label", []).append(np.array(chunk[label]))
    return {name: np.concatenate(values) for name, values in parts.items()} or {
        name: np.empty(0) for name in "xyz"
    }
