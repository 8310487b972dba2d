"""LAS, LAZ and COPC clouds, with laspy (and lazrs for the compressed ones).

The sizes in the header are held against the file before laspy sees it: it allocates what a header
announces. A COPC file is a LAZ file whose octree is not needed to read all points.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geohue.errors import GeohueError
from geohue.io.atomic import atomic_write
from geohue.io.cloud import CloudData, build_cloud
from geohue.io.extras import optional
from geohue.io.files import broken, read_bytes, reason
from geohue.io.las_head import LasHead, read_head
from geohue.io.laz_check import check_laz

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


def write_las(
    path: str | Path,
    points: ArrayLike,
    colors: ArrayLike,
    labels: ArrayLike,
    offset: ArrayLike = (0.0, 0.0, 0.0),
) -> None:
    """Write a labelled cloud as LAS 1.4, or LAZ where the name ends so; whole or not at all.

    Coordinates are kept to a millionth of the cloud's extent or finer (whole numbers of a power
    of ten), colours as 16 bits (257 times the 8-bit value), labels in the extra dimension
    ``segment_id`` (int32).

    Parameters
    ----------
    path : path-like
        ``.las`` or ``.laz``.
    points : (N, 3)
        Finite coordinates.
    colors : (N, 3) uint8
        sRGB.
    labels : (N,) integers
        -1 for none.
    offset : (3,)
        Added to the coordinates in float64: `CloudData.offset`.

    Raises
    ------
    GeohueError
        If laspy is not installed, the shapes do not fit, or the file cannot be written.
    """
    laspy = optional("laspy", "clouds", path)
    xyz, rgb = np.asarray(points, np.float64), np.asarray(colors, np.uint8)
    label, place = np.asarray(labels, np.int32), np.asarray(offset, np.float64)
    if xyz.shape != (label.size, 3) or rgb.shape != xyz.shape or label.size == 0:
        shapes = f"points {xyz.shape}, colours {rgb.shape}, labels {label.shape}"
        raise broken(path, f"not written: {shapes} do not fit together")
    if not np.isfinite(xyz).all():
        raise broken(path, "not written: LAS has no place for points without coordinates")
    header = laspy.LasHeader(point_format=7, version="1.4")
    header.add_extra_dim(laspy.ExtraBytesParams(name="segment_id", type=np.int32))
    low, high = xyz.min(axis=0), xyz.max(axis=0)
    extent = float((high - low).max()) or float(np.abs(high).max()) or 1.0
    header.scales = np.full(3, 10.0 ** np.floor(np.log10(extent / 1e8)))
    header.offsets = place + (low + high) / 2
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = (xyz[:, i] + place[i] for i in range(3))
    cloud.red, cloud.green, cloud.blue = (rgb[:, i].astype(np.uint16) * 257 for i in range(3))
    cloud.segment_id = label
    with atomic_write(path) as temporary:
        try:
            cloud.write(temporary)
        except OSError:
            raise
        except Exception as error:
            raise broken(path, f"not written ({reason(error)})") from error
