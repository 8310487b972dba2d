"""The scale of a file's colours, found once for the whole file from a few places in it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from geohue.read.files import broken

ColorScale = Literal["fraction", "byte", "word"]
"""Colours of 0..1, of 0..255, or of 0..65535."""

_SCALES: tuple[ColorScale, ...] = get_args(ColorScale)
_ROWS = 4096

Read = Callable[[int, int], NDArray[Any]]


def find_scale(read: Read, n_points: int, places: int) -> ColorScale:
    """Look at the colours in a few places of a file to find their scale.

    Parameters
    ----------
    read : callable
        Returns the file's own colour values, (m, 3), of the points from a start to a stop.
    n_points : int
        Points in the file.
    places : int
        How many stretches of 4096 points, spread evenly.

    Returns
    -------
    {"fraction", "byte", "word"}
        By the rule of `geohue.read.clouds.cloud.to_color`.
    """
    step = max(_ROWS, n_points // places)
    starts: Iterable[int] = range(0, n_points, step)
    scales = [_scale_of(read(start, min(start + _ROWS, n_points))) for start in starts]
    return max(scales, key=_SCALES.index)


def as_bytes(values: NDArray[Any], scale: ColorScale, path: str | Path) -> NDArray[np.uint8]:
    """Bring colours, (m, 3), to uint8; what is no number becomes 0.

    Raises
    ------
    GeohueError
        If the colours go beyond the scale that was found: it was found in too dark a part.

    Examples
    --------
    >>> as_bytes(np.array([[65535, 256, 255]], np.uint16), "word", "a.las").tolist()
    [[255, 1, 0]]
    """
    if values.dtype == np.uint8:
        return values
    if _SCALES.index(_scale_of(values)) > _SCALES.index(scale):
        cause = f"has colours up to {np.nanmax(values):g} among others that look like {scale}s"
        raise broken(path, f"{cause}; export it with 8-bit colours")
    with np.errstate(all="ignore"):
        known = np.nan_to_num(values.astype(np.float32), nan=0.0, posinf=0.0, neginf=0.0)
    if scale == "fraction":
        known *= 255.0
    elif scale == "word":
        known = np.floor(known / 256.0)
    return np.clip(np.rint(known), 0, 255).astype(np.uint8)


def _scale_of(values: NDArray[Any]) -> ColorScale:
    if values.dtype == np.uint8:
        return "byte"
    finite = values[np.isfinite(values)] if values.dtype.kind == "f" else values
    largest = finite.max(initial=0)
    if largest > 255:
        return "word"
    return "fraction" if values.dtype.kind == "f" and largest <= 1 else "byte"
