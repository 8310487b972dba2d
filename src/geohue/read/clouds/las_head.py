"""The header of a LAS or LAZ file, held against the size of the file.

laspy reads as many records as a header announces. So no reader hands it a file before this.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from geohue.read.files import broken

_HEADER = struct.Struct("<4s20xBB68xHIIBHI")  # up to the old count of points
_SHORTEST, _LONGEST = 227, 375  # bytes of the headers of LAS 1.0 and 1.4
_VLR_HEAD, _EVLR_HEAD = 54, 60  # bytes before the content of a record


@dataclass(frozen=True, slots=True)
class LasHead:
    """What the header says, as far as it must fit the file.

    Attributes
    ----------
    count : int
        Points, at least one.
    start : int
        Offset of the first point, in bytes.
    size : int
        Bytes of the header itself.
    n_vlrs : int
        Variable-length records between the header and the points.
    width : int
        Bytes of a point, uncompressed.
    compressed : bool
        Whether this is LAZ.
    length : int
        Bytes of the file.
    """

    count: int
    start: int
    size: int
    n_vlrs: int
    width: int
    compressed: bool
    length: int

    @property
    def body(self) -> int:
        """Bytes from the first point to the end of the file."""
        return self.length - self.start


def read_head(file: BinaryIO, length: int, path: str | Path) -> LasHead:
    """Read the header of LAS 1.0 to 1.4.

    Parameters
    ----------
    file : binary file
        Open for reading.
    length : int
        Bytes in it.
    path : path-like
        Named in errors.

    Returns
    -------
    LasHead
        Its records and, where it is not compressed, its points lie within the file.

    Raises
    ------
    GeohueError
        If the file is not LAS, is cut short, or its header announces more than there is.
    """
    file.seek(0)
    head = file.read(_LONGEST)
    if not head.startswith(b"LASF"):
        raise broken(path, "is not a LAS file (it does not start with 'LASF')")
    if len(head) < _SHORTEST or (head[25] >= 4 and len(head) < _LONGEST):
        raise broken(path, "is cut short within its header; copy or export it again")
    _, major, minor, size, start, n_vlrs, form, width, count = _HEADER.unpack_from(head)
    if major != 1 or not _SHORTEST <= size <= start or start > length or width < 20:
        raise broken(path, "has a damaged LAS header, or is cut short; export it again")
    if n_vlrs * _VLR_HEAD > start - size:
        raise broken(
            path, f"has a damaged LAS header: it announces {n_vlrs} records; export it again"
        )
    if minor >= 4:
        (count,) = struct.unpack_from("<Q", head, 247)
        _check_extended(file, struct.unpack_from("<QI", head, 235), length, path)
    if count == 0:
        raise broken(path, "has no points; export it again")
    compressed = bool(form & 0x80)
    if not compressed and count > (length - start) // width:
        cause = f"is cut short: it announces {count} points, which do not fit in its {length} bytes"
        raise broken(path, f"{cause}; copy or export it again")
    return LasHead(count, start, size, n_vlrs, width, compressed, length)


def _check_extended(file: BinaryIO, place: tuple[int, int], length: int, path: str | Path) -> None:
    """Check that the extended records of LAS 1.4 lie in the file, each of them."""
    position, count = place
    for _ in range(min(count, length // _EVLR_HEAD + 1)):
        if position + _EVLR_HEAD > length:
            raise broken(path, "is cut short within its extended records; copy it again")
        file.seek(position + 20)
        (content,) = struct.unpack("<Q", file.read(8))
        position += _EVLR_HEAD + content
    if count and position > length:
        raise broken(path, "is cut short within its extended records; copy it again")
