"""`laz_check` for files that are not read into memory: only their tables are looked at."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any, BinaryIO

from geohue.read.clouds.laz_check import (
    _EXTRA_BYTES,
    _LAYERED,
    _LAYERS,
    _MOST_ITEMS,
    _laszip_record,
)
from geohue.read.files import broken, reason

_HEAD = 1 << 26  # where the laszip record must be; a damaged header may put the points at 4 GB
_VARIABLE = 0xFFFFFFFF  # chunk size of files whose chunks differ in size


def check_laz_file(path: Path, count: int, lazrs: Any) -> None:
    """Raise GeohueError unless the chunks and their layers lie in the file and hold all points.

    Parameters
    ----------
    path : Path
        The file, whose LAS header is sound.
    count : int
        Points that it announces.
    lazrs : module
        The decoder, whose table reader is used once the table's own count is plausible.
    """
    length = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(227)
        size, start, n_vlrs = struct.unpack_from("<HII", head, 94)
        (width,) = struct.unpack_from("<H", head, 105)
        file.seek(0)
        record, items = _record(file.read(min(start, _HEAD)), size, n_vlrs, width, path)
        end = _check_table(file, start, length, path)
        file.seek(start)
        try:
            chunks = lazrs.read_chunk_table(file, lazrs.LazVlr(record))
        except lazrs.LazrsError as error:
            raise broken(path, f"has a damaged chunk table ({reason(error)})") from error
        (each,) = struct.unpack_from("<I", record, 12)
        present = sum(n for n, _ in chunks) if each == _VARIABLE else each * len(chunks)
        if present < count or start + 8 + sum(n for _, n in chunks) > end:
            raise broken(path, "is cut short: its chunks do not fit in it; copy or export it again")
        if struct.unpack_from("<H", record)[0] == _LAYERED:
            layers = sum(
                _LAYERS.get(kind, n if kind == _EXTRA_BYTES else 0) for kind, n, _ in items
            )
            _check_layers(file, start + 8, chunks, width, layers, path)


def _record(
    head: bytes, size: int, n_vlrs: int, width: int, path: Path
) -> tuple[bytes, list[tuple[int, int, int]]]:
    """Return the laszip record and the items that make up a point."""
    record = _laszip_record(head, size, n_vlrs, len(head))
    if record is None or len(record) < 34:
        raise broken(
            path, "is compressed, but does not say how (no laszip record); export it again"
        )
    (count,) = struct.unpack_from("<H", record, 32)
    if count > _MOST_ITEMS or len(record) < 34 + 6 * count:
        raise broken(path, "has a damaged laszip record; export it again")
    items = [struct.unpack_from("<HHH", record, 34 + 6 * i) for i in range(count)]
    if sum(n for _, n, _ in items) != width:
        raise broken(path, "has a laszip record for other points; export it again")
    return record, items


def _check_table(file: Any, start: int, length: int, path: Path) -> int:
    """Return where the table of chunks lies."""
    table = -1
    for place in (start, length - 8):  # a stream writes the place of the table at its end
        if table == -1 and length >= start + 16:
            file.seek(place)
            (table,) = struct.unpack("<q", file.read(8))
    if not start + 8 <= table <= length - 8:
        raise broken(path, "is cut short: its chunk table is missing; copy or export it again")
    file.seek(table)
    _, chunks = struct.unpack("<II", file.read(8))
    if chunks > length:
        raise broken(path, f"is damaged: it announces {chunks} chunks; export it again")
    return int(table)


def _check_layers(
    file: BinaryIO, start: int, chunks: list[tuple[int, int]], width: int, layers: int, path: Path
) -> None:
    """Hold the sizes of each chunk's layers against the chunk."""
    position = start
    for _, size in chunks:
        file.seek(position)
        head = file.read(width + 4 + 4 * layers)
        if size and len(head) == width + 4 + 4 * layers:
            inner = sum(struct.unpack_from(f"<{layers}I", head, width + 4))
            if len(head) + inner > size:
                raise broken(path, "has a chunk with damaged layers; export it again")
        position += size
