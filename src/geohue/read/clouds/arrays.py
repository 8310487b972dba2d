"""Clouds as bare arrays: NPY and NPZ, and KITTI's BIN."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.read.arrays import _MOST, _parse_npy, read_npy
from geohue.read.clouds.cloud import CloudData, build_cloud
from geohue.read.files import broken, read_bytes, reason

_NAMES = {
    "points": ("points", "xyz", "pos", "coord", "coords", "positions", "pts", "point_cloud"),
    "colors": ("colors", "color", "rgb", "colours", "colour"),
    "normals": ("normals", "normal"),
    "labels": ("labels", "label", "segment", "semantic_gt", "sem"),
}


def read_npy_cloud(path: str | Path) -> CloudData:
    """Read an NPY file with (N, 3) points, or (N, 6) points and colours (also (H, W, 3) or 6).

    Raises
    ------
    GeohueError
        If it is no such array.
    """
    return _from_table(read_npy(path), path)


def read_npz_cloud(path: str | Path) -> CloudData:
    """Read an NPZ file with arrays ``points`` (or xyz, pos, coord), ``colors`` (or rgb), ...

    Raises
    ------
    GeohueError
        If there are no points in it, or the arrays differ in shape.
    """
    arrays = _members(path)
    if "points" not in arrays:
        raise broken(path, "has no array 'points' (also read: xyz, pos, coord); rename one")
    points = arrays["points"]
    if points.ndim not in (2, 3) or points.shape[-1] not in (3, 6):
        raise broken(path, f"points have the shape {points.shape}; (N, 3) is needed")
    if points.shape[-1] == 6 and "colors" not in arrays:
        return _from_table(points, path)
    shape = points.shape[:-1]
    columns = _split(points[..., :3], "xyz")
    for kind, names in (("colors", ("red", "green", "blue")), ("normals", ("nx", "ny", "nz"))):
        if kind in arrays:
            if arrays[kind].shape != (*shape, 3):
                raise broken(path, f"{kind} have the shape {arrays[kind].shape}, not {(*shape, 3)}")
            columns |= _split(arrays[kind], names)
    if "labels" in arrays and arrays["labels"].shape == shape:
        columns["label"] = arrays["labels"].reshape(-1)
    return build_cloud(columns, shape, path)


def read_velodyne(path: str | Path) -> CloudData:
    """Read a BIN file of KITTI: float32 x, y, z, reflectance; no colours.

    Raises
    ------
    GeohueError
        If the size or the values are not those of such a file.
    """
    data = read_bytes(path)
    if len(data) % 16:
        raise broken(path, f"has {len(data)} bytes, no multiple of 16: no KITTI scan, or cut short")
    rows = np.frombuffer(data, "<f4").reshape(-1, 4)
    far = np.abs(rows[:, :3]).max(initial=0)
    if not np.isfinite(rows).all() or far > 1e5:
        raise broken(path, "has values that are no coordinates in metres: no KITTI scan")
    return build_cloud(_split(rows[:, :3], "xyz"), (len(rows),), path)


def _from_table(array: NDArray[Any], path: str | Path) -> CloudData:
    if array.ndim not in (2, 3) or array.shape[-1] not in (3, 4, 6, 7) or array.size == 0:
        cause = f"has the shape {array.shape}; a cloud is (N, 3), or (N, 6) with colours"
        raise broken(path, f"{cause}")
    columns = _split(array[..., :3], "xyz")
    if array.shape[-1] in (6, 7):
        columns |= _split(_whole_colors(array[..., 3:6]), ("red", "green", "blue"))
    if array.shape[-1] == 7:
        columns["label"] = array[..., 6].reshape(-1)
    return build_cloud(columns, array.shape[:-1], path)


def _whole_colors(colors: NDArray[Any]) -> NDArray[Any]:
    """Take whole numbers beyond 1 in a float table for the bytes that they were."""
    with np.errstate(invalid="ignore"):
        if colors.dtype.kind == "f" and 1 < colors.max(initial=0) <= 255 and colors.min() >= 0:
            return np.asarray(np.rint(colors), np.uint8)
    return colors


def _split(array: NDArray[Any], names: Any) -> dict[str, NDArray[Any]]:
    flat = array.reshape(-1, 3)
    return {name: np.ascontiguousarray(flat[:, i]) for i, name in enumerate(names)}


def _members(path: str | Path) -> dict[str, NDArray[Any]]:
    """Return the arrays with a known name, each bounded in size."""
    data = read_bytes(path)
    arrays: dict[str, NDArray[Any]] = {}
    room = _MOST
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            present = {Path(n).stem.lower(): n for n in archive.namelist() if n.endswith(".npy")}
            for kind, names in _NAMES.items():
                name = next((present[n] for n in names if n in present), None)
                if name is None:
                    continue
                if archive.getinfo(name).file_size > room:
                    raise broken(path, f"unpacks to more than {_MOST} bytes; make it smaller first")
                with archive.open(name) as member:
                    content = member.read(room)
                room -= len(content)
                arrays[kind] = _parse_npy(content, path)
    except GeohueError:
        raise
    except Exception as error:  # zipfile lets zlib, struct, encoding and other errors through
        raise broken(path, f"is not a whole NPZ file ({reason(error)}); save it again") from error
    return arrays
