"""The header and the records of a LAS file as bytes, and one field more in its points."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from geohue.read.clouds.las_head import LasHead
from geohue.read.files import broken

FIELD = b"segment_id"
"""The extra dimension that labels go to."""

STANDARD_BYTES = (20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67)
"""Bytes of a point of each format, without extra dimensions."""

_HEAD = struct.Struct("<2s16sHH32s")  # of a record: reserved, who, number, bytes, what
_SPEC, _EXTRA_BYTES = b"LASF_Spec", 4
_LASZIP, _COPC = b"laszip encoded", b"copc"
_DESCRIPTOR = 192  # bytes that describe an extra dimension
_TYPE_BYTES = (1, 1, 2, 2, 4, 4, 8, 8, 4, 8)  # of the data types 1 to 10
_INT32 = 6
_NO_DATA = 1  # option: there is a value for "none"
_MOST_UNNAMED = 255  # bytes without a description that a descriptor can stand for


@dataclass(slots=True)
class Record:
    """A variable-length record: who defined it, its number there, its description and content."""

    user: bytes
    number: int
    about: bytes
    content: bytes

    def to_bytes(self) -> bytes:
        """Return the record as it stands in the file."""
        head = _HEAD.pack(b"\0\0", self.user, self.number, len(self.content), self.about)
        return head + self.content


@dataclass(slots=True)
class Records:
    """What stands before the points of a LAS file.

    Attributes
    ----------
    header : bytes
        The header itself.
    items : list of Record
        Without those that describe the compression or the octree of COPC.
    gap : bytes
        What is between the last record and the points.
    laszip : bytes
        How the points are compressed; empty if they are not.
    """

    header: bytes
    items: list[Record]
    gap: bytes
    laszip: bytes

    def body(self) -> bytes:
        """Return all between the header and the points."""
        return b"".join(item.to_bytes() for item in self.items) + self.gap


def read_records(file: BinaryIO, head: LasHead, path: Path) -> Records:
    """Read what stands before the points.

    Raises
    ------
    GeohueError
        If a record reaches into the points.
    """
    file.seek(0)
    data = file.read(head.start)
    position, items, laszip = head.size, list[Record](), b""
    for _ in range(head.n_vlrs):
        if position + _HEAD.size > len(data):
            raise broken(path, "has a damaged LAS header: its records overlap its points")
        _, user, number, size, about = _HEAD.unpack_from(data, position)
        position += _HEAD.size
        if position + size > len(data):
            raise broken(path, "has a damaged LAS header: its records overlap its points")
        record = Record(user, number, about, data[position : position + size])
        position += size
        name = user.rstrip(b"\0")
        if name == _LASZIP:
            laszip = record.content
        elif name != _COPC:
            items.append(record)
    return Records(data[: head.size], items, data[position:], laszip)


def is_copc(user: bytes) -> bool:
    """Whether a record belongs to the octree of a COPC file."""
    return user.rstrip(b"\0") == _COPC


def add_segment_field(records: Records, head: LasHead, path: Path) -> tuple[int, int]:
    """Describe the extra dimension for the segments, in place of an earlier one of its type.

    Parameters
    ----------
    records : Records
        Its record of the extra bytes is changed, or added.
    head : LasHead
    path : Path
        Named in errors.

    Returns
    -------
    place, width : int
        Where in a point its segment stands, and the bytes of a point then.

    Raises
    ------
    GeohueError
        If the point format is unknown or the extra dimensions do not fit the points.
    """
    form = records.header[104] & 0x3F
    if form >= len(STANDARD_BYTES) or head.width < STANDARD_BYTES[form]:
        raise broken(path, f"has points of format {form} with {head.width} bytes; export it again")
    named = (r for r in records.items if (r.user.rstrip(b"\0"), r.number) == (_SPEC, _EXTRA_BYTES))
    record = next(named, None)
    if record is None:
        record = Record(_SPEC, _EXTRA_BYTES, b"Extra Bytes", b"")
        records.items.append(record)
    place, content = STANDARD_BYTES[form], bytearray(record.content)
    for at in range(0, len(content) - _DESCRIPTOR + 1, _DESCRIPTOR):
        kind, name = content[at + 2], bytes(content[at + 4 : at + 36]).rstrip(b"\0")
        if name == FIELD and kind == _INT32 and place + 4 <= head.width:
            return place, head.width
        if name == FIELD:  # of another type: kept, by another name
            content[at + 4 : at + 36] = (FIELD + b"_before").ljust(32, b"\0")
        place += _bytes_of(kind, content[at + 3])
    if place > head.width:
        raise broken(path, "describes more extra dimensions than its points have; export it again")
    content += _unnamed(head.width - place)
    content += _descriptor(_INT32, _NO_DATA, FIELD, b"geohue, -1 = none", -1)
    if len(content) >= 1 << 16 or head.width + 4 >= 1 << 16:
        raise broken(path, "has so many extra dimensions that no other one has room")
    record.content = bytes(content)
    return head.width, head.width + 4


def _bytes_of(kind: int, options: int) -> int:
    """Bytes of an extra dimension: 0 is "unknown", 11 to 30 are pairs and triples."""
    if kind == 0:
        return options
    return _TYPE_BYTES[(kind - 1) % 10] * ((kind - 1) // 10 + 1)


def _unnamed(size: int) -> bytes:
    """Describe bytes that no descriptor tells of, as the place of the next one counts on them."""
    parts = [min(_MOST_UNNAMED, size - at) for at in range(0, size, _MOST_UNNAMED)]
    return b"".join(
        _descriptor(0, part, b"undescribed" + str(i).encode(), b"") for i, part in enumerate(parts)
    )


def _descriptor(kind: int, options: int, name: bytes, about: bytes, none: int = 0) -> bytes:
    return struct.pack("<2xBB32s4xq112x32s", kind, options, name, none, about)
