"""Pictures and labels as PNG."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.read.files import broken
from geohue.results.atomic import atomic_write


def write_png(path: str | Path, array: NDArray[Any]) -> None:
    """Write a PNG, whole or not at all.

    Parameters
    ----------
    path : path-like
        The file to write, ending in ``.png``; folders are made.
    array : (H, W) or (H, W, 3) uint8 or uint16
        Grey or sRGB.

    Raises
    ------
    GeohueError
        If the array is of another kind or the file cannot be written.
    """
    import cv2

    pixels = np.asarray(array)
    grey, color = pixels.ndim == 2, pixels.ndim == 3 and pixels.shape[2] == 3
    if not (grey or color) or pixels.size == 0 or pixels.dtype not in (np.uint8, np.uint16):
        cause = f"not written: {pixels.dtype} {pixels.shape} is no picture"
        raise broken(path, f"{cause}; uint8 or uint16, (H, W) or (H, W, 3) is")
    ok, data = cv2.imencode(".png", np.ascontiguousarray(pixels[..., ::-1] if color else pixels))
    if not ok:
        raise broken(path, f"not written: {pixels.shape} cannot be encoded as PNG")
    with atomic_write(path) as temporary:
        temporary.write_bytes(data.tobytes())
