"""Is a picture file whole? Older OpenCV gives a damaged picture as a partly grey one, silently."""

from __future__ import annotations

import io
import struct
import warnings
import zlib
from pathlib import Path

from geohue.read.files import broken

MAX_PIXELS = 1 << 27  # 134 million: 0.4 GB of colours

_PNG = b"\x89PNG\r\n\x1a\n"
_JPEG = b"\xff\xd8\xff"


def check_picture(data: bytes, path: str | Path) -> None:
    """Raise GeohueError if a PNG or JPEG is cut short or damaged, or any picture is too large."""
    whole = True
    if data.startswith(_PNG):
        whole = _png_is_whole(data)
    elif data.startswith(_JPEG):
        whole = _jpeg_is_whole(data)
    elif data[:4] == b"RIFF":
        whole = len(data) >= 12 and len(data) >= 8 + struct.unpack_from("<I", data, 4)[0]
    if not whole:
        raise broken(path, "is cut short or damaged; copy or export it again")
    size = picture_size(data)
    if size is not None and size[0] * size[1] > MAX_PIXELS:
        cause = f"announces {size[0]} x {size[1]} pixels, more than {MAX_PIXELS} in all"
        raise broken(path, f"{cause}; make it smaller first")


def picture_size(data: bytes) -> tuple[int, int] | None:
    """Return (width, height) from the header, without decoding; None if it is not understood."""
    from PIL import Image

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            with Image.open(io.BytesIO(data)) as picture:
                return picture.size
        except Image.DecompressionBombError:
            return _size_of_bomb(data)
        except Exception:  # whatever a damaged header makes the many format plug-ins raise
            return None


def _size_of_bomb(data: bytes) -> tuple[int, int] | None:
    """Return the size that a header announces which Pillow refuses to open.

    Pillow's readers of the formats tell it; the refusal comes after them.
    """
    from PIL import Image

    for name in Image.ID:
        make, accept = Image.OPEN[name]
        try:
            if accept is None or accept(data[:16]) is True:
                size: tuple[int, int] = make(io.BytesIO(data), "").size
                return size
        except Exception:  # not this format, or as above
            continue
    return MAX_PIXELS, 2


def _png_is_whole(data: bytes) -> bool:
    """Follow the chunks to IEND, checking each one's sum."""
    position = len(_PNG)
    view = memoryview(data)
    while position + 12 <= len(data):
        (length,) = struct.unpack_from(">I", data, position)
        end = position + 12 + length
        if end > len(data):
            return False
        if zlib.crc32(view[position + 4 : end - 4]) != struct.unpack_from(">I", data, end - 4)[0]:
            return False
        if data[position + 4 : position + 8] == b"IEND":
            return True
        position = end
    return False


def _jpeg_is_whole(data: bytes) -> bool:
    """Follow the segments and the coded data between them to the end marker.

    The marker alone is not looked for, since a thumbnail inside has one of its own.
    """
    position = 2
    while (position := data.find(b"\xff", position)) >= 0 and position + 1 < len(data):
        marker = data[position + 1]
        if marker == 0xD9:
            return True
        if marker == 0xFF:  # padding
            position += 1
        elif marker in (0x00, 0x01) or 0xD0 <= marker <= 0xD7:  # coded 255, restarts
            position += 2
        elif position + 4 <= len(data):
            position += 2 + struct.unpack_from(">H", data, position + 2)[0]
        else:
            return False
    return False
