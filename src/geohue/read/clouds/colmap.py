"""The sparse points of structure-from-motion models: COLMAP and Bundler.

Only points and colours are read; the names of pictures in a model lead to no file.
"""

from __future__ import annotations

import re
import struct
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geohue.read.clouds.cloud import CloudData, build_cloud
from geohue.read.clouds.table import read_table, text_lines
from geohue.read.files import broken, read_bytes

_POINT = struct.Struct("<QdddBBBdQ")  # id, x y z, r g b, error, length of the track


def read_colmap(path: str | Path) -> CloudData:
    """Read the points of a COLMAP model.

    Parameters
    ----------
    path : path-like
        ``points3D.bin``, ``points3D.txt``, or the folder of the model.

    Returns
    -------
    CloudData
        points (N, 3) at the model's arbitrary scale, and their colours.

    Raises
    ------
    GeohueError
        If the file is missing, damaged or cut short, or has no points.
    """
    file = _points_file(Path(path))
    data = read_bytes(file)
    return _read_text(data, file) if file.suffix.lower() == ".txt" else _read_binary(data, file)


def _points_file(path: Path) -> Path:
    if not path.is_dir():
        return path
    found = [path / name for name in ("points3D.bin", "points3D.txt")]
    found += [path / "sparse" / "0" / file.name for file in found]
    chosen = next((file for file in found if file.is_file()), None)
    if chosen is None:
        raise broken(path, "has no points3D.bin or points3D.txt; name the folder of the model")
    return chosen


def _read_binary(data: bytes, path: Path) -> CloudData:
    (count,) = struct.unpack_from("<Q", data) if len(data) >= 8 else (0,)
    if count == 0 or count > (len(data) - 8) // _POINT.size:
        cause = f"announces {count} points, which do not fit in its {len(data)} bytes"
        raise broken(path, f"{cause}; copy or export it again")
    xyz, rgb = np.empty((count, 3)), np.empty((count, 3), np.uint8)
    position = 8
    for i in range(count):
        if position + _POINT.size > len(data):
            raise broken(path, f"is cut short: {i} of {count} points; copy or export it again")
        _, x, y, z, r, g, b, _, track = _POINT.unpack_from(data, position)
        xyz[i] = x, y, z
        rgb[i] = r, g, b
        position += _POINT.size + 8 * track
    if position > len(data):
        raise broken(path, f"is cut short within its {count} points; copy or export it again")
    return build_cloud(_xyz(xyz), (count,), path, rgb)


def _read_text(data: bytes, path: Path) -> CloudData:
    """Read ``POINT3D_ID X Y Z R G B ERROR TRACK[]`` rows, whose tracks differ in length."""
    lines = [line for line in text_lines(data) if not line.lstrip().startswith("#")]
    rows = [" ".join(line.split(maxsplit=8)[:7]) for line in lines]
    if not rows:
        raise broken(path, "has no points")
    table = read_table(iter(rows), len(rows), range(1, 7), 7, path)
    rgb = np.clip(np.nan_to_num(table[:, 3:]), 0, 255).astype(np.uint8)
    return build_cloud(_xyz(table[:, :3]), (len(rows),), path, rgb)


def read_bundler(path: str | Path) -> CloudData:
    """Read the points of a Bundler model (``bundle.out``).

    Parameters
    ----------
    path : path-like
        The file, version 0.3 or older.

    Returns
    -------
    CloudData
        points (N, 3) at the model's arbitrary scale, and their colours.

    Raises
    ------
    GeohueError
        If the file is missing, damaged or cut short, or has no points.
    """
    data = read_bytes(path)
    lines = [line for line in text_lines(data) if not line.lstrip().startswith("#")]
    head = re.fullmatch(r"\s*(\d{1,9})\s+(\d{1,12})\s*", lines[0]) if lines else None
    if head is None:
        raise broken(path, "is not a Bundler model: its first row must be the numbers of cameras")
    cameras, count = int(head.group(1)), int(head.group(2))
    body = lines[1 + 5 * cameras :]
    if count == 0 or len(body) < 3 * count:
        cause = f"has {len(body) // 3} points after {cameras} cameras, {count} are announced"
        raise broken(path, f"{cause}; copy or export it again")
    body = body[: 3 * count]
    xyz = read_table(iter(body[0::3]), count, range(3), 3, path)
    rgb = read_table(iter(body[1::3]), count, range(3), 3, path)
    colors = np.clip(np.nan_to_num(rgb), 0, 255).astype(np.uint8)
    return build_cloud(_xyz(xyz), (count,), path, colors)


def _xyz(points: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
    return {axis: points[:, i] for i, axis in enumerate("xyz")}
