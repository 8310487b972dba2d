"""Depth maps in OpenEXR, as renderers write them: scan lines, not compressed or with RLE or ZIP.

An own reader, since the wheels of OpenCV 5 are built without OpenEXR and imageio has no plug-in for
it under a permissive licence.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.read.files import broken, read_bytes

_MAGIC = b"\x76\x2f\x31\x01"
_KINDS: dict[int, np.dtype[Any]] = {0: np.dtype("<u4"), 1: np.dtype("<f2"), 2: np.dtype("<f4")}
_LINES = {0: 1, 1: 1, 2: 1, 3: 16}  # lines a block: none, RLE, ZIPS, ZIP
_DEPTH_NAMES = ("z", "depth", "d", "v", "y", "r", "x")
_MAX_PIXELS = 1 << 27
_MAX_CHANNELS = 64


@dataclass(frozen=True, slots=True)
class _Header:
    channels: list[tuple[str, np.dtype[Any]]]
    compression: int
    width: int
    height: int
    top: int
    start: int

    @property
    def line(self) -> int:
        """Bytes of a scan line."""
        return self.width * sum(kind.itemsize for _, kind in self.channels)


def read_exr(path: str | Path) -> NDArray[np.float32]:
    """Read the depth channel of an EXR file.

    Parameters
    ----------
    path : path-like
        One part, scan lines; the channel named Z or depth (also behind a layer's name), or V, Y,
        R, X, or the only one.

    Returns
    -------
    (H, W) float32
        As in the file.

    Raises
    ------
    GeohueError
        If the file is missing, damaged, cut short or of a kind that is not read.
    """
    data = read_bytes(path)
    try:
        header = _parse_header(data, path)
        return _channel(data, header, path)
    except GeohueError:
        raise
    except (struct.error, ValueError, IndexError, OverflowError, zlib.error) as error:
        raise broken(path, "is cut short or damaged; copy or export it again") from error


def _parse_header(data: bytes, path: str | Path) -> _Header:
    if not data.startswith(_MAGIC):
        raise broken(path, "is not an EXR file")
    (version,) = struct.unpack_from("<I", data, 4)
    if version & 0x1A00:
        raise broken(path, "has tiles, deep data or several parts; save it as scan lines")
    found: dict[str, bytes] = {}
    position = 8
    while data[position] != 0:
        name, position = _word(data, position)
        _, position = _word(data, position)
        (size,) = struct.unpack_from("<I", data, position)
        position += 4
        found[name] = data[position : position + size]
        position += size
    left, top, right, bottom = struct.unpack("<4i", found.get("dataWindow", b""))
    width, height = right - left + 1, bottom - top + 1
    compression = found.get("compression", b"\xff")[0]
    if compression not in _LINES:
        raise broken(path, "is compressed in a way that is not read; save it with ZIP or none")
    channels = _channels(found.get("channels", b"\0"))
    if not (width > 0 and height > 0 and width * height <= _MAX_PIXELS):
        raise broken(path, f"announces {width} x {height} pixels; at most {_MAX_PIXELS} are read")
    if not 0 < len(channels) <= _MAX_CHANNELS:
        raise broken(path, f"has {len(channels)} channels; save the depth alone")
    return _Header(channels, compression, width, height, top, position + 1)


def _word(data: bytes, position: int) -> tuple[str, int]:
    end = data.index(b"\0", position, position + 256)
    return data[position:end].decode("latin-1"), end + 1


def _channels(raw: bytes) -> list[tuple[str, np.dtype[Any]]]:
    channels: list[tuple[str, np.dtype[Any]]] = []
    position = 0
    while raw[position] != 0:
        name, position = _word(raw, position)
        kind, _, x, y = struct.unpack_from("<4i", raw, position)
        if kind not in _KINDS or (x, y) != (1, 1):
            raise ValueError(name)
        channels.append((name, _KINDS[kind]))
        position += 16
    return channels


def _channel(data: bytes, header: _Header, path: str | Path) -> NDArray[np.float32]:
    """Decode every block and keep the depth channel."""
    which = _which(header, path)
    before = header.width * sum(kind.itemsize for _, kind in header.channels[:which])
    kind = header.channels[which][1]
    lines = _LINES[header.compression]
    blocks = -(-header.height // lines)
    offsets = struct.unpack_from(f"<{blocks}Q", data, header.start)
    image = np.full((header.height, header.width), np.nan, np.float32)
    for offset in offsets:
        y, size = struct.unpack_from("<iI", data, offset)
        row = y - header.top
        count = min(lines, header.height - row)
        if row < 0 or count < 1 or offset + 8 + size > len(data):
            raise ValueError(y)
        raw = _decompressed(data[offset + 8 : offset + 8 + size], header, count)
        table = np.frombuffer(raw, np.uint8).reshape(count, header.line)
        part = np.ascontiguousarray(table[:, before : before + header.width * kind.itemsize])
        image[row : row + count] = part.view(kind)
    return image


def _which(header: _Header, path: str | Path) -> int:
    names = [name.rsplit(".", 1)[-1].lower() for name, _ in header.channels]
    if len(names) == 1:
        return 0
    for wanted in _DEPTH_NAMES[:3]:
        if wanted in names:
            return names.index(wanted)
    if {"r", "g", "b"} <= set(names):
        raise broken(path, "is a picture in colour; a depth map has a channel Z, depth or only one")
    chosen = next((names.index(name) for name in _DEPTH_NAMES if name in names), None)
    if chosen is None:
        raise broken(path, f"has no channel Z or depth (found: {', '.join(names[:8])})")
    return chosen


def _decompressed(block: bytes, header: _Header, lines: int) -> bytes:
    needed = header.line * lines
    if header.compression == 0 or len(block) == needed:
        raw = block
    else:
        coded = _unrun(block, needed) if header.compression == 1 else _inflated(block, needed)
        # Bytes are differences from the byte before, the even ones of the data first.
        steps = np.frombuffer(coded, np.uint8).astype(np.int64)
        steps[1:] -= 128
        bytes_in_halves = (np.cumsum(steps) & 255).astype(np.uint8)
        mixed = np.empty(len(coded), np.uint8)
        half = (len(coded) + 1) // 2
        mixed[0::2], mixed[1::2] = bytes_in_halves[:half], bytes_in_halves[half:]
        raw = mixed.tobytes()
    if len(raw) != needed:
        raise ValueError("block")
    return raw


def _inflated(block: bytes, needed: int) -> bytes:
    decoder = zlib.decompressobj()
    return decoder.decompress(block, needed + 1)


def _unrun(block: bytes, needed: int) -> bytes:
    """Undo run lengths: a negative count of bytes as they are, or a byte to repeat."""
    out = bytearray()
    position = 0
    while position < len(block) and len(out) <= needed:
        count = struct.unpack_from("<b", block, position)[0]
        if count < 0:
            out += block[position + 1 : position + 1 - count]
            position += 1 - count
        else:
            out += block[position + 1 : position + 2] * (count + 1)
            position += 2
    return bytes(out)
