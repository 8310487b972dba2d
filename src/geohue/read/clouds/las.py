"""LAS, LAZ and COPC clouds, with laspy (and lazrs for the compressed ones).

The sizes in the header are held against the file before laspy sees it: it allocates what a header
announces. A COPC file is a LAZ file whose octree is not needed to read all points.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.read.clouds.cloud import CloudData, build_cloud
from geohue.read.clouds.las_head import LasHead, read_head
from geohue.read.clouds.laz_check import check_laz
from geohue.read.extras import optional
from geohue.read.files import broken, read_bytes, reason

MAX_POINTS = 1 << 28
"""Most points that a compressed file may announce."""

_CHUNK = 1_000_000
_MOST_PER_BYTE = 100  # points that a byte of compressed data stands for
_MOST_AT_ONCE = 1 << 28  # bytes of a chunk, uncompressed, that is read by several threads
_COLORS = ("red", "green", "blue")
_LABELS = ("segment_id", "label", "scalar_label")


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
    file = io.BytesIO(data)
    head = read_head(file, len(data), path)
    laspy = optional("laspy", "clouds", path)
    largest = _check(file, head, path)
    try:
        columns = _columns(laspy, file, head, largest)
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


def _check(file: io.BytesIO, head: LasHead, path: str | Path) -> int:
    """Hold what will be allocated against the file; returns the points of its largest chunk."""
    most = min(head.body * _MOST_PER_BYTE, MAX_POINTS) if head.compressed else MAX_POINTS
    if head.count > most:
        cause = f"announces {head.count} points, which do not fit in its {head.length} bytes"
        raise broken(path, f"{cause}; copy or export it again")
    if not head.compressed:
        return head.count
    return check_laz(file, head, optional("lazrs", "clouds", path), Path(path)).largest


def _columns(laspy: Any, file: BinaryIO, head: LasHead, largest: int) -> dict[str, NDArray[Any]]:
    """Read chunk by chunk, so that a lying header costs no more than the data behind it."""
    parts: dict[str, list[NDArray[Any]]] = {}
    # Several threads make room for a whole chunk, as large as the file says. They gain nothing
    # where there is one chunk; where that is gigabytes, room that is not there ends the program.
    threads = largest < head.count and largest * head.width <= _MOST_AT_ONCE
    decoder = laspy.LazBackend.LazrsParallel if threads else laspy.LazBackend.Lazrs
    file.seek(0)
    with laspy.open(file, laz_backend=decoder) as reader:
        names = set(reader.header.point_format.dimension_names)
        wanted = [n for n in _COLORS if names.issuperset(_COLORS)]
        label = next((n for n in _LABELS if n in names), None)
        for chunk in reader.chunk_iterator(min(_CHUNK, head.count)):
            with np.errstate(all="ignore"):  # a damaged header may scale beyond all numbers
                for name in ("x", "y", "z"):
                    parts.setdefault(name, []).append(np.array(chunk[name], np.float64))
            for name in wanted:
                parts.setdefault(name, []).append(np.array(chunk[name]))
            if label is not None:
                parts.setdefault("label", []).append(np.array(chunk[label]))
    return {name: np.concatenate(values) for name, values in parts.items()} or {
        name: np.empty(0) for name in "xyz"
    }
