"""What every cloud file becomes: points, colours, normals and labels of one leading shape."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.plugins import Registry
from geohue.read.files import broken, read_bytes

TOO_FAR = 1e30
"""No coordinate: a mark for "missing", or garbage."""
_FLOAT32_STEP = 2.0**-23


@dataclass(frozen=True, slots=True, eq=False)
class CloudData:
    """A cloud as it lies in a file.

    Parameters
    ----------
    points : (N, 3) or (H, W, 3) float32
        Coordinates less `offset`, in the file's unit; NaN where missing.
    colors : uint8, same shape as `points`, optional
        sRGB. None means that the file has no colours.
    normals : float32, same shape as `points`, optional
        Surface normals as the file gives them.
    labels : int32, `points.shape[:-1]`, optional
        Labels as the file gives them.
    offset : (3,) float64
        What was taken from the coordinates before they became float32: zero, except where the
        cloud lies so far from the origin (map coordinates) that float32 would blur it.
    source : Path, optional
        The file.
    """

    points: NDArray[np.float32]
    colors: NDArray[np.uint8] | None
    normals: NDArray[np.float32] | None
    labels: NDArray[np.int32] | None
    offset: NDArray[np.float64]
    source: Path | None = None


Reader = Callable[[Path], CloudData]

_OWN: dict[str, Reader | str] = {
    ".ply": "ply.read_ply",
    ".pcd": "pcd.read_pcd",
    ".las": "las.read_las",
    ".laz": "las.read_las",
    ".e57": "e57.read_e57",
    ".xyz": "xyz.read_xyz",
    ".xyzrgb": "xyz.read_xyz",
    ".txt": "xyz.read_xyz",
    ".asc": "xyz.read_xyz",
    ".csv": "xyz.read_xyz",
    ".pts": "xyz.read_xyz",
    ".npy": "arrays.read_npy_cloud",
    ".npz": "arrays.read_npz_cloud",
    ".bin": "arrays.read_velodyne",
    ".out": "colmap.read_bundler",
}
CLOUD_READERS: Registry[Reader | str] = Registry(
    "clouds",
    _OWN,
    callable,
    "a function from a path to a CloudData",
)
"""What reads clouds by the ending of the file, plugins included; ours are imported when used."""


def register_cloud_format(ending: str, reader: Reader) -> Reader:
    """Let clouds with another ending be read.

    Parameters
    ----------
    ending : str
        With its dot, in lower case: ``".swc"``.
    reader : callable
        From the path to a `CloudData` (`build_cloud` makes one of named columns).

    Returns
    -------
    callable
        The reader itself.

    Raises
    ------
    GeohueError
        For an ending that is read already, or none.

    Examples
    --------
    >>> def read_one(path):
    ...     return build_cloud({"x": np.ones(1), "y": np.ones(1), "z": np.ones(1)}, (1,), path)
    >>> reader = register_cloud_format(".one", read_one)
    >>> read_cloud("made.one").points.tolist()
    [[1.0, 1.0, 1.0]]
    >>> CLOUD_READERS.remove(".one")
    """
    if not ending.startswith(".") or ending != ending.lower():
        raise GeohueError(f"ending {ending!r}: expected a dot and small letters, such as '.swc'")
    CLOUD_READERS.add(ending, reader)
    return reader


_STARTS = (
    (rb"\s*ply\s", "ply.read_ply"),
    (rb"\s*(# \.PCD|VERSION|FIELDS)", "pcd.read_pcd"),
    (rb"LASF", "las.read_las"),
    (rb"ASTM-E57", "e57.read_e57"),
    (rb"\s*# Bundle file", "colmap.read_bundler"),
)


def read_cloud(path: str | Path) -> CloudData:
    """Read a point cloud, its format told by the name or else by the first bytes.

    Parameters
    ----------
    path : path-like
        PLY, PCD, LAS, LAZ, COPC, E57; XYZ, TXT, CSV, ASC, PTS; NPY, NPZ; KITTI's BIN; COLMAP's
        ``points3D.bin`` or ``.txt`` or the folder of the model; Bundler's ``.out``.

    Returns
    -------
    CloudData
        Points and whatever else the file has of colours, normals and labels.

    Raises
    ------
    GeohueError
        If the file is missing, damaged or none of these, or needs a library that is missing.
    """
    found = _reader(Path(path))
    if callable(found):
        return found(Path(path))
    module, name = found.split(".")
    reader: Reader = getattr(import_module(f"geohue.read.clouds.{module}"), name)
    return reader(Path(path))


def format_of(path: str | Path) -> str:
    """Return the name of the format that a cloud is read as.

    Examples
    --------
    >>> format_of("scan.LAZ")
    'las'
    """
    found = _reader(Path(path))
    return Path(path).suffix.lower()[1:] if callable(found) else found.split(".")[0]


def _reader(path: Path) -> Reader | str:
    """Return what reads a file, or module and function of ours."""
    if path.stem.lower() == "points3d" or is_colmap(path):
        return "colmap.read_colmap"
    known = CLOUD_READERS.get(path.suffix.lower())
    if known is not None:
        return known
    start = read_bytes(path)[:4096]
    for pattern, reader in _STARTS:
        if re.match(pattern, start):
            return reader
    endings = " ".join(CLOUD_READERS)
    raise broken(path, f"is not a cloud that geohue reads ({endings}); convert it to .ply")


def is_colmap(path: Path) -> bool:
    """Whether a folder holds the points of a COLMAP model."""
    places = (path, path / "sparse" / "0")
    names = ("points3D.bin", "points3D.txt")
    return path.is_dir() and any((place / n).is_file() for place in places for n in names)


_COLOR_NAMES = (
    ("red", "green", "blue"),
    ("r", "g", "b"),
    ("diffuse_red", "diffuse_green", "diffuse_blue"),
)
_NORMAL_NAMES = (("nx", "ny", "nz"), ("normal_x", "normal_y", "normal_z"))
_LABEL_NAMES = ("label", "scalar_label")


def find_columns(names: Mapping[str, object]) -> dict[str, tuple[str, ...]]:
    """Find out which of a file's column names (in lower case) hold what.

    Examples
    --------
    >>> find_columns(dict.fromkeys(["x", "y", "z", "blue", "green", "red", "age"]))
    {'points': ('x', 'y', 'z'), 'colors': ('red', 'green', 'blue')}
    """
    kinds: dict[str, tuple[tuple[str, ...], ...]] = {
        "points": (("x", "y", "z"),),
        "colors": _COLOR_NAMES,
        "normals": _NORMAL_NAMES,
        "labels": tuple((name,) for name in _LABEL_NAMES),
    }
    found: dict[str, tuple[str, ...]] = {}
    for kind, choices in kinds.items():
        for choice in choices:
            if kind not in found and all(name in names for name in choice):
                found[kind] = choice
    return found


def build_cloud(
    columns: Mapping[str, NDArray[Any]],
    shape: tuple[int, ...],
    source: str | Path,
    colors: NDArray[np.uint8] | None = None,
) -> CloudData:
    """Turn named columns, (N,) each and of any numeric type, into a CloudData of `shape`."""
    found = find_columns(columns)
    if "points" not in found:
        names = ", ".join(sorted(columns)[:12]) or "none"
        raise broken(source, f"has no columns x, y, z (found: {names}); it is not a point cloud")
    points, offset = _points(*(columns[name] for name in found["points"]))
    if not np.isfinite(points).all(axis=1).any():
        raise broken(source, "has no point with finite coordinates; export it again")
    if colors is None and "colors" in found:
        colors = to_color([columns[name] for name in found["colors"]])
    normals = labels = None
    if "normals" in found:
        normals = _as_float32([columns[name] for name in found["normals"]]).reshape(*shape, 3)
    if "labels" in found:
        labels = _as_int32(columns[found["labels"][0]]).reshape(shape)
    return CloudData(
        points.reshape(*shape, 3),
        None if colors is None else colors.reshape(*shape, 3),
        normals,
        labels,
        offset,
        Path(source),
    )


def _points(*axes: NDArray[Any]) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """Return (N, 3) float32 and the float64 offset that was taken from the coordinates."""
    offset = np.zeros(3)
    if any(axis.dtype.itemsize > 4 for axis in axes):
        offset = _offset(axes)
    points = np.empty((len(axes[0]), 3), np.float32)
    with np.errstate(all="ignore"):
        for i, axis in enumerate(axes):
            points[:, i] = axis - offset[i] if offset[i] else axis
            points[~(np.abs(points[:, i]) < TOO_FAR), i] = np.nan
    return points, offset


def _offset(axes: tuple[NDArray[Any], ...]) -> NDArray[np.float64]:
    """Return the mean if float32 would resolve the cloud to less than 1 in 50,000, else zero."""
    low, high, mean = np.zeros(3), np.zeros(3), np.zeros(3)
    for i, axis in enumerate(axes):
        with np.errstate(all="ignore"):
            values = axis[np.abs(axis) < TOO_FAR].astype(np.float64)
        if values.size:
            low[i], high[i], mean[i] = values.min(), values.max(), values.mean()
    farthest = max(np.abs(low).max(), np.abs(high).max())
    extent = (high - low).max()
    blurred = farthest * _FLOAT32_STEP > 2e-5 * extent > 0
    return mean if blurred else np.zeros(3)


def _as_float32(columns: list[NDArray[Any]]) -> NDArray[np.float32]:
    with np.errstate(all="ignore"):
        return np.stack([column.astype(np.float32) for column in columns], axis=-1)


def _as_int32(column: NDArray[Any]) -> NDArray[np.int32]:
    """Round to int32; -1 (no label) for what is no number or does not fit."""
    if column.dtype.kind == "f":
        with np.errstate(all="ignore"):
            column = np.where(np.abs(column) < 2**31, np.rint(column), -1)
    elif column.dtype.itemsize > 4 or column.dtype == np.uint32:
        column = np.where(column > 2**31 - 1, -1, np.maximum(column.astype(np.int64), -(2**31)))
    return column.astype(np.int32)


def to_color(channels: list[NDArray[Any]]) -> NDArray[np.uint8]:
    """Bring red, green and blue of any numeric type to (N, 3) uint8.

    Bytes stay as they are. Fractions up to 1 become 0..255, whole numbers beyond 255 count as
    16-bit; what is no number becomes 0.

    Examples
    --------
    >>> to_color([np.array([1.0]), np.array([0.5]), np.array([np.nan])])
    array([[255, 128,   0]], dtype=uint8)
    >>> to_color([np.array([65535], np.uint16), np.array([257], np.uint16), np.array([0])])
    array([[255,   1,   0]], dtype=uint8)
    """
    if all(channel.dtype == np.uint8 for channel in channels):
        return np.stack(channels, axis=-1)
    values = np.nan_to_num(_as_float32(channels), nan=0.0, posinf=0.0, neginf=0.0)
    largest = values.max(initial=0.0)
    fractions = all(channel.dtype.kind == "f" for channel in channels) and largest <= 1.0
    if fractions:
        values *= 255.0
    elif largest > 255.0:
        values = np.floor(values / 256.0)
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)
