"""Labelled clouds as PLY."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geohue.read.files import broken
from geohue.results.atomic import atomic_write


def write_ply(
    path: str | Path,
    points: ArrayLike,
    colors: ArrayLike,
    labels: ArrayLike,
    *,
    double: bool = False,
) -> None:
    """Write a labelled cloud as binary little-endian PLY, whole or not at all.

    Parameters
    ----------
    path : path-like
        The file to write; folders are made.
    points : (..., 3)
        Coordinates; not finite ones stay so.
    colors : (..., 3) uint8
        sRGB.
    labels : (...) integers
        Written twice: as int ``label`` and as float ``scalar_label``, which CloudCompare shows.
    double : bool
        Whether coordinates are written as double, for those that float32 would blur.

    Raises
    ------
    GeohueError
        If the shapes do not fit together or the file cannot be written.
    """
    columns: dict[str, NDArray[Any]] = {
        "xyz": np.asarray(points, np.float64 if double else np.float32),
        "rgb": np.asarray(colors, np.uint8),
    }
    label = np.asarray(labels, np.int32)
    for name, values in columns.items():
        if values.shape != (*label.shape, 3):
            shapes = f"{name} has the shape {values.shape}, labels {label.shape}"
            raise broken(path, f"not written: {shapes}; one row of three a label is needed")
    rows = np.empty(label.size, ply_row(double))
    for name, values in columns.items():
        rows[name] = values.reshape(-1, 3)
    rows["label"] = label.ravel()
    rows["scalar_label"] = label.ravel()
    with atomic_write(path) as temporary, temporary.open("wb") as file:
        file.write(ply_header(label.size, double))
        file.write(rows.tobytes())


def ply_row(is_double: bool) -> np.dtype[np.void]:
    """Return the fields of a row of a labelled cloud."""
    fields = [
        ("xyz", "<f8" if is_double else "<f4", 3),
        ("rgb", "u1", 3),
        ("label", "<i4"),
        ("scalar_label", "<f4"),
    ]
    return np.dtype(fields)


def ply_header(count: int, is_double: bool) -> bytes:
    """Return what stands before the rows."""
    kind = "double" if is_double else "float"
    names = [f"{kind} x", f"{kind} y", f"{kind} z"]
    names += ["uchar red", "uchar green", "uchar blue", "int label", "float scalar_label"]
    properties = "".join(f"property {name}\n" for name in names)
    start = "ply\nformat binary_little_endian 1.0\n"
    return f"{start}element vertex {count}\n{properties}end_header\n".encode()
