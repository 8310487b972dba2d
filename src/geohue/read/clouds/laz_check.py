"""Is a LAZ file's inner structure true? The decoder allocates what its tables announce.

Sizes that lie make it ask for gigabytes, and end the whole program where it does not get them. So
the laszip record, the table of chunks and, in each chunk, the sizes of its layers are held against
the file first. Only these are read, not the points.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

from geohue.read.clouds.las_head import LasHead
from geohue.read.files import broken, reason

_VLR_HEAD = 54
_RECORD = 22204  # of "laszip encoded"
_LAYERED = 3  # compressor of point formats 6 to 10
_FIRST_LAYERED = 3  # version of the items that it writes; the decoder goes by this
_LAYERS = {10: 9, 11: 1, 12: 2, 13: 1}  # by kind of item; extra bytes have one each
_EXTRA_BYTES = 14
_MOST_ITEMS = 64
_HEAD = 1 << 26  # where the laszip record must be; a damaged header may put the points at 4 GB
_VARIABLE = 0xFFFFFFFF  # chunk size of files whose chunks differ in size


@dataclass(frozen=True, slots=True)
class LazLayout:
    """How a LAZ file is cut into chunks.

    Attributes
    ----------
    largest : int
        Points that the largest chunk may hold, as the file says. The decoder with several threads
        makes room for as many, however few there are.
    is_variable : bool
        Whether the chunks differ in their points, as in COPC.
    """

    largest: int
    is_variable: bool


@dataclass(frozen=True, slots=True)
class _Record:
    """The laszip record: its bytes, points in a chunk, and layers of a chunk (0 for none)."""

    content: bytes
    each: int
    layers: int


def check_laz(file: BinaryIO, head: LasHead, lazrs: Any, path: Path) -> LazLayout:
    """Raise GeohueError unless the chunks and their layers lie in the file and hold all points.

    Parameters
    ----------
    file : binary file
        The file.
    head : LasHead
        Its header.
    lazrs : module
        The decoder, whose table reader is used once the table's own count is plausible.
    path : Path
        Named in errors.

    Returns
    -------
    LazLayout
        How the file is cut into chunks.
    """
    record = _read_record(file, head, path)
    table = _find_table(file, head, path)
    file.seek(head.start)
    try:
        chunks = lazrs.read_chunk_table(file, lazrs.LazVlr(record.content))
    except BaseException as error:  # lazrs is Rust: a panic is no Exception
        if isinstance(error, KeyboardInterrupt | SystemExit):
            raise
        raise broken(path, f"has a damaged chunk table ({reason(error)})") from error
    if record.each != _VARIABLE:
        chunks = [(record.each, size) for _, size in chunks]
    here = head.start + 8
    if sum(n for n, _ in chunks) < head.count or here + sum(n for _, n in chunks) > table:
        raise broken(path, "is cut short: its chunks do not fit in it; copy or export it again")
    _check_chunks(file, here, chunks, head, record.layers, path)
    return LazLayout(max(n for n, _ in chunks), record.each == _VARIABLE)


def _read_record(file: BinaryIO, head: LasHead, path: Path) -> _Record:
    file.seek(0)
    record = _laszip_record(file.read(min(head.start, _HEAD)), head.size, head.n_vlrs)
    if record is None or len(record) < 34:
        raise broken(
            path, "is compressed, but does not say how (no laszip record); export it again"
        )
    (compressor,), (each,) = struct.unpack_from("<H", record), struct.unpack_from("<I", record, 12)
    (count,) = struct.unpack_from("<H", record, 32)
    if not 1 <= count <= _MOST_ITEMS or len(record) < 34 + 6 * count or each == 0:
        raise broken(path, "has a damaged laszip record; export it again")
    items = [struct.unpack_from("<HHH", record, 34 + 6 * i) for i in range(count)]
    if sum(size for _, size, _ in items) != head.width:
        raise broken(path, "has a laszip record for other points; export it again")
    layered = compressor == _LAYERED
    if any((version >= _FIRST_LAYERED) != layered for _, _, version in items):
        raise broken(path, "has a laszip record that contradicts itself; export it again")
    layers = sum(_LAYERS.get(kind, size if kind == _EXTRA_BYTES else 0) for kind, size, _ in items)
    return _Record(record, each, layers if layered else 0)


def _laszip_record(data: bytes, position: int, n_vlrs: int) -> bytes | None:
    """Return the content of the laszip record among those from `position` to the end."""
    for _ in range(n_vlrs):
        if position + _VLR_HEAD > len(data):
            return None
        user = data[position + 2 : position + 18].rstrip(b"\0")
        number, size = struct.unpack_from("<HH", data, position + 18)
        position += _VLR_HEAD
        if user == b"laszip encoded" and number == _RECORD:
            return data[position : position + size]
        position += size
    return None


def _find_table(file: BinaryIO, head: LasHead, path: Path) -> int:
    """Return where the table of chunks lies."""
    table = -1
    for place in (head.start, head.length - 8):  # a stream writes the place of the table last
        if table == -1 and head.body >= 16:
            file.seek(place)
            (table,) = struct.unpack("<q", file.read(8))
    if not head.start + 8 <= table <= head.length - 8:
        raise broken(path, "is cut short: its chunk table is missing; copy or export it again")
    file.seek(table)
    _, chunks = struct.unpack("<II", file.read(8))
    if not 1 <= chunks <= head.length:
        raise broken(path, f"is damaged: it announces {chunks} chunks; export it again")
    return int(table)


def _check_chunks(
    file: BinaryIO,
    position: int,
    chunks: list[tuple[int, int]],
    head: LasHead,
    layers: int,
    path: Path,
) -> None:
    """Check that each chunk with points has its first point whole, and layers as long as it is."""
    left = head.count
    for points, size in chunks:
        if min(points, left) > 0:
            inner = 0
            if layers:
                file.seek(position + head.width + 4)
                sizes = file.read(4 * layers)
                if len(sizes) < 4 * layers:
                    raise broken(path, "has a damaged chunk; export it again")
                inner = 4 + len(sizes) + sum(struct.unpack(f"<{layers}I", sizes))
            # A decoder that reads on takes the next chunk from where the layers of this one end.
            if size < head.width or (layers and head.width + inner != size):
                raise broken(path, "has a chunk with damaged layers; export it again")
        left -= points
        position += size
