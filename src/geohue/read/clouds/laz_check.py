"""Is a LAZ file's inner structure true? The decoder allocates what its tables announce.

Sizes that lie make it ask for gigabytes, and end the whole program where it does not get them. So
the table of chunks and, in each chunk, the sizes of its layers are held against the file first.
"""

from __future__ import annotations

import io
import struct
from pathlib import Path
from typing import Any

from geohue.read.files import broken, reason

_VLR_HEAD = 54
_RECORD = 22204  # of "laszip encoded"
_LAYERED = 3  # compressor of point formats 6 to 10
_LAYERS = {10: 9, 11: 1, 12: 2, 13: 1}  # by kind of item; extra bytes have one each
_EXTRA_BYTES = 14
_MOST_ITEMS = 64


def check_laz(data: bytes, start: int, header: int, n_vlrs: int, lazrs: Any, path: Path) -> None:
    """Raise GeohueError unless the chunks and their layers lie within the file.

    Parameters
    ----------
    data : bytes
        The file.
    start : int
        Where the points begin.
    header : int
        Size of the LAS header.
    n_vlrs : int
        Number of its variable-length records.
    lazrs : module
        The decoder, whose table reader is used once the table's own count is plausible.
    path : path-like
        Named in errors.
    """
    _check_table(data, start, path)
    record = _laszip_record(data, header, n_vlrs, start)
    if record is None or len(record) < 34:
        raise broken(
            path, "is compressed, but does not say how (no laszip record); export it again"
        )
    (compressor,) = struct.unpack_from("<H", record)
    (count,) = struct.unpack_from("<H", record, 32)
    if count > _MOST_ITEMS or len(record) < 34 + 6 * count:
        raise broken(path, "has a damaged laszip record; export it again")
    items = [struct.unpack_from("<HHH", record, 34 + 6 * i) for i in range(count)]
    (length,) = struct.unpack_from("<H", data, 105)
    if sum(size for _, size, _ in items) != length:
        raise broken(path, "has a laszip record for other points; export it again")
    source = io.BytesIO(data)
    source.seek(start)
    try:
        chunks = lazrs.read_chunk_table(source, lazrs.LazVlr(record))
    except lazrs.LazrsError as error:
        raise broken(path, f"has a damaged chunk table ({reason(error)})") from error
    layers = sum(_LAYERS.get(kind, size if kind == _EXTRA_BYTES else 0) for kind, size, _ in items)
    _check_chunks(data, start + 8, chunks, length, layers if compressor == _LAYERED else 0, path)


def _check_table(data: bytes, start: int, path: Path) -> None:
    fits = len(data) >= start + 8
    (table,) = struct.unpack_from("<q", data, start) if fits else (0,)
    if table == -1:  # written by a stream: the place of the table comes last
        (table,) = struct.unpack_from("<q", data, len(data) - 8)
    if not (fits and start + 8 <= table <= len(data) - 8):
        raise broken(path, "is cut short: its chunk table is missing; copy or export it again")
    _, chunks = struct.unpack_from("<II", data, table)
    if chunks > len(data):
        raise broken(path, f"is damaged: it announces {chunks} chunks; export it again")


def _laszip_record(data: bytes, header: int, n_vlrs: int, start: int) -> bytes | None:
    position = header
    for _ in range(n_vlrs):
        if position + _VLR_HEAD > start:
            return None
        user = data[position + 2 : position + 18].rstrip(b"\0")
        number, size = struct.unpack_from("<HH", data, position + 18)
        position += _VLR_HEAD
        if user == b"laszip encoded" and number == _RECORD:
            return data[position : min(position + size, start)]
        position += size
    return None


def _check_chunks(
    data: bytes, start: int, chunks: list[tuple[int, int]], length: int, layers: int, path: Path
) -> None:
    position = start
    for _, size in chunks:
        end = position + size
        if end > len(data):
            raise broken(path, "is cut short: its chunks do not fit in it; copy or export it again")
        if layers and size:
            first = position + length + 4
            if first + 4 * layers > end:
                raise broken(path, "has a damaged chunk; export it again")
            inner = sum(struct.unpack_from(f"<{layers}I", data, first))
            if first + 4 * layers + inner > end:
                raise broken(path, "has a chunk with damaged layers; export it again")
        position = end
