"""A LAS or LAZ file with its segments added: all else stays as it is, byte for byte.

Header, records and points are carried over as bytes rather than by a library, which would write
dates, bounds and the ranges of extra dimensions anew. What changes is what a longer point changes:
the sizes and places in the header, and one descriptor more in the record of the extra bytes.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geohue.read.clouds.las_head import LasHead, read_head
from geohue.read.clouds.laz_check import check_laz
from geohue.read.extras import optional
from geohue.read.files import broken, reason
from geohue.results.atomic import atomic_write
from geohue.results.las_records import (
    STANDARD_BYTES,
    Record,
    Records,
    add_segment_field,
    is_copc,
    read_records,
)

_BLOCK = 250_000  # points in memory at a time
_COPY = 1 << 22  # bytes
_WAVEFORMS, _EXTENDED = 227, 235  # where a header of 1.3 and of 1.4 says where these records are
_EXTENDED_HEAD = 60
_INSIDE = 2  # bit of the global encoding: the waveforms are in this file
_COMPRESSED = 0x80
_LOSSY = (9, 10)

Rows = NDArray[np.uint8]


def is_las(path: Path) -> bool:
    """Whether a file is LAS or LAZ, by its name."""
    return path.suffix.lower() in (".las", ".laz")


def write_las_like(path: str | Path, source: Path, labels: ArrayLike) -> None:
    """Write a LAS or LAZ file again, with the segment of each point; whole or not at all.

    Points keep their order and every attribute and extra dimension; scale, offset, coordinate
    system and all other records stay. The labels are in the extra dimension ``segment_id`` (int32,
    -1 for none), in place of an earlier one. A COPC file becomes a plain LAZ file: its octree does
    not describe the longer points.

    Parameters
    ----------
    path : path-like
        ``.las``, or ``.laz`` for a compressed file.
    source : Path
        The file that was segmented, LAS 1.0 to 1.4 of any point format.
    labels : (N,) integers
        One for each point of `source`, in its order; may be a memory map.

    Raises
    ------
    GeohueError
        If `source` is damaged or has another number of points, a library is missing, or the file
        cannot be written.
    """
    target, segment = Path(path), np.asanyarray(labels).reshape(-1)
    try:
        with source.open("rb") as file:
            head = read_head(file, source.stat().st_size, source)
            lazrs = None
            if head.compressed or target.suffix.lower() == ".laz":
                lazrs = optional("lazrs", "clouds", path)
            if head.compressed:
                check_laz(file, head, lazrs, source)
            if len(segment) != head.count:
                cause = f"has {head.count} points, but there are {len(segment)} labels"
                raise broken(source, f"{cause}; was it changed since it was read?")
            records = read_records(file, head, source)
            _check_waveforms(records.header[104] & 0x3F, head.compressed, target)
            place, width = add_segment_field(records, head, source)
            rows = _longer(_rows(file, head, records, lazrs, source), segment, place, width)
            with atomic_write(target) as temporary, temporary.open("wb") as output:
                compressor = lazrs if target.suffix.lower() == ".laz" else None
                header = _write_points(output, records, rows, width, compressor)
                _carry_extended(file, output, head, header)
                output.seek(0)
                output.write(header)
    except OSError as error:
        raise broken(source, f"cannot be read ({reason(error)}); check its permissions") from error


def _check_waveforms(form: int, compressed: bool, target: Path) -> None:
    """Refuse what lazrs 0.8 gives back changed: waveforms where scanner channels alternate."""
    if form in _LOSSY and (compressed or target.suffix.lower() == ".laz"):
        raise broken(
            target,
            f"not written: points of format {form} (waveforms) do not go through lazrs unchanged; "
            "export the input as .las and choose las",
        )


def _write_points(
    output: BinaryIO, records: Records, rows: Iterator[Rows], width: int, lazrs: Any
) -> bytearray:
    """Write header, records and points; returns the header with its new sizes."""
    header, form, vlr = bytearray(records.header), records.header[104] & 0x3F, None
    header[104] = form
    if lazrs is not None:
        header[104] |= _COMPRESSED
        vlr = lazrs.LazVlr.new_for_compression(form, width - STANDARD_BYTES[form])
        about = Record(b"laszip encoded", 22204, b"lazrs", vlr.record_data())
        records.items.append(about)
    body = records.body()
    struct.pack_into("<II", header, 96, len(header) + len(body), len(records.items))
    struct.pack_into("<H", header, 105, width)
    output.write(header)
    output.write(body)
    if vlr is None:
        for block in rows:
            output.write(block.tobytes())
        return header
    compressor = lazrs.ParLasZipCompressor(output, vlr)
    for block in rows:
        compressor.compress_many(block.reshape(-1))
    compressor.done()
    return header


def _longer(
    rows: Iterator[Rows], labels: NDArray[np.integer[Any]], place: int, width: int
) -> Iterator[Rows]:
    """Yield the points with their segments."""
    start = 0
    for block in rows:
        longer = np.zeros((len(block), width), np.uint8)
        longer[:, : block.shape[1]] = block
        part = np.ascontiguousarray(labels[start : start + len(block)], "<i4")
        longer[:, place : place + 4] = part.view(np.uint8).reshape(-1, 4)
        yield longer
        start += len(block)


def _rows(
    file: BinaryIO, head: LasHead, records: Records, lazrs: Any, source: Path
) -> Iterator[Rows]:
    """Yield the points as bytes, (m, width)."""
    file.seek(head.start)
    decompressor = lazrs.LasZipDecompressor(file, records.laszip) if head.compressed else None
    for start in range(0, head.count, _BLOCK):
        block = np.empty((min(_BLOCK, head.count - start), head.width), np.uint8)
        if decompressor is None:
            if file.readinto(block.reshape(-1)) < block.size:  # type: ignore[attr-defined]
                raise broken(source, f"is cut short near point {start}; copy or export it again")
        else:
            try:
                decompressor.decompress_many(block.reshape(-1))
            except BaseException as error:  # lazrs is Rust: a panic is no Exception
                if isinstance(error, KeyboardInterrupt | SystemExit):
                    raise
                cause = f"is damaged near point {start} ({reason(error)})"
                raise broken(source, f"{cause}; export it again") from error
        yield block


def _carry_extended(file: BinaryIO, output: BinaryIO, head: LasHead, header: bytearray) -> None:
    """Copy the records behind the points, and say in the header where they are now."""
    moved, counted = dict[int, int](), list[int]()
    for position, size, counts in _extended(file, head, header):
        moved[position] = output.seek(0, 2)
        counted += [moved[position]] if counts else []
        file.seek(position)
        for done in range(0, size, _COPY):
            output.write(file.read(min(_COPY, size - done)))
    minor = header[25]
    if minor >= 4:
        struct.pack_into("<QI", header, _EXTENDED, min(counted, default=0), len(counted))
    if minor >= 3:
        (waves,) = struct.unpack_from("<Q", header, _WAVEFORMS)
        struct.pack_into("<Q", header, _WAVEFORMS, moved.get(waves, waves))


def _extended(file: BinaryIO, head: LasHead, header: bytearray) -> Iterator[tuple[int, int, bool]]:
    """Yield place and size of each record behind the points, and whether the header counts it.

    Those of COPC are left out.
    """
    places = list[int]()
    if header[25] >= 4:
        position, count = struct.unpack_from("<QI", header, _EXTENDED)
        for _ in range(count):
            user, size = _extended_head(file, position)
            places.append(position)
            if not is_copc(user):
                yield position, size, True
            position += size
    (encoding,) = struct.unpack_from("<H", header, 6)
    if header[25] >= 3 and encoding & _INSIDE:
        (waves,) = struct.unpack_from("<Q", header, _WAVEFORMS)
        if waves not in places and head.start < waves <= head.length - _EXTENDED_HEAD:
            yield waves, head.length - waves, False


def _extended_head(file: BinaryIO, position: int) -> tuple[bytes, int]:
    """Return who defined a record, and its size with its head."""
    file.seek(position + 2)
    user = file.read(16)
    file.seek(position + 20)
    (content,) = struct.unpack("<Q", file.read(8))
    return user, _EXTENDED_HEAD + content
