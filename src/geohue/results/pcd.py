"""Labelled clouds as binary PCD."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from geohue.read.files import broken
from geohue.results.atomic import atomic_write

_ROW = np.dtype([("xyz", "<f4", 3), ("rgb", "<u4"), ("label", "<i4")])


def write_pcd(path: str | Path, points: ArrayLike, colors: ArrayLike, labels: ArrayLike) -> None:
    """Write a labelled cloud as binary PCD 0.7, whole or not at all.

    Parameters
    ----------
    path : path-like
        The file to write; folders are made.
    points : (N, 3) or (H, W, 3)
        Written as float32; an organised cloud keeps its grid, with NaN where there is no point.
    colors : uint8, same shape
        sRGB, packed into ``rgb``.
    labels : (N,) or (H, W) integers
        Written as int32 ``label``, -1 for none.

    Raises
    ------
    GeohueError
        If the shapes do not fit together or the file cannot be written.
    """
    xyz, rgb = np.asarray(points, np.float32), np.asarray(colors, np.uint8)
    label = np.asarray(labels, np.int32)
    if xyz.shape != (*label.shape, 3) or rgb.shape != xyz.shape or label.ndim not in (1, 2):
        shapes = f"points {xyz.shape}, colours {rgb.shape}, labels {label.shape}"
        raise broken(path, f"not written: {shapes} do not fit together")
    rows = np.empty(label.size, _ROW)
    rows["xyz"] = xyz.reshape(-1, 3)
    red, green, blue = rgb.reshape(-1, 3).astype(np.uint32).T
    rows["rgb"] = red << 16 | green << 8 | blue
    rows["label"] = label.ravel()
    height, width = label.shape if label.ndim == 2 else (1, label.size)
    header = (
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb label\n"
        "SIZE 4 4 4 4 4\nTYPE F F F U I\nCOUNT 1 1 1 1 1\n"
        f"WIDTH {width}\nHEIGHT {height}\nVIEWPOINT 0 0 0 1 0 0 0\n"
        f"POINTS {label.size}\nDATA binary\n"
    )
    with atomic_write(path) as temporary, temporary.open("wb") as file:
        file.write(header.encode())
        file.write(rows.tobytes())
