"""E57 scans, with pye57 (libE57Format).

The file's checksums are verified by the library. Colours are read as numbers of any size, because
pye57's own call fails on 16-bit ones.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.read.clouds.cloud import CloudData, build_cloud
from geohue.read.extras import optional
from geohue.read.files import broken, read_bytes, reason

_CARTESIAN = ("cartesianX", "cartesianY", "cartesianZ")
_SPHERICAL = ("sphericalRange", "sphericalAzimuth", "sphericalElevation")
_COLORS = ("colorRed", "colorGreen", "colorBlue")
_INVALID = ("cartesianInvalidState", "sphericalInvalidState", "isColorInvalid")
_SMALLEST_POINT = 64  # points that a byte of a packed file stands for at most


def read_e57(path: str | Path) -> CloudData:
    """Read all scans of an E57 file as one cloud, each in its place.

    Parameters
    ----------
    path : path-like
        Cartesian or spherical coordinates, colours of 8 or 16 bits or fractions.

    Returns
    -------
    CloudData
        points (N, 3) less `offset`. Colours only if every scan has them.

    Raises
    ------
    GeohueError
        If pye57 is not installed, or the file is missing, damaged or without points.
    """
    data = read_bytes(path)
    if not data.startswith(b"ASTM-E57") or len(data) < 48:
        raise broken(path, "is not an E57 file (it does not start with 'ASTM-E57')")
    (length,) = struct.unpack_from("<Q", data, 16)
    if length > len(data):
        raise broken(path, f"is cut short: {len(data)} of {length} bytes; copy it again")
    library = optional("pye57", "clouds", path)
    try:
        scans = _scans(library, path, len(data))
    except GeohueError:
        raise
    except Exception as error:
        raise broken(path, f"is damaged ({reason(error)}); export it again") from error
    if not scans:
        raise broken(path, "has no scans; it holds pictures only")
    names = set.intersection(*(set(scan) for scan in scans))
    columns = {name: np.concatenate([scan[name] for scan in scans]) for name in names}
    return build_cloud(columns, (len(columns["x"]),), path)


def _scans(library: Any, path: str | Path, size: int) -> list[dict[str, NDArray[Any]]]:
    file = library.E57(str(path))
    try:
        return [_scan(library, file, i, path, size) for i in range(file.scan_count)]
    finally:
        file.close()


def _scan(library: Any, file: Any, index: int, path: str | Path, size: int) -> dict[str, Any]:
    header = file.get_header(index)
    count, fields = int(header.point_count), set(header.point_fields)
    if not 0 <= count <= size * _SMALLEST_POINT:
        raise broken(path, f"announces {count} points, too many for its {size} bytes")
    axes = _CARTESIAN if fields.issuperset(_CARTESIAN) else _SPHERICAL
    if not fields.issuperset(axes):
        raise broken(path, f"scan {index} has no coordinates; export it again")
    colors = _COLORS if fields.issuperset(_COLORS) else ()
    flags = [name for name in _INVALID if name in fields]
    values = {name: np.zeros(count) for name in (*axes, *colors, *flags)}
    buffers = library.libe57.VectorSourceDestBuffer()
    for name, array in values.items():
        buffers.append(
            library.libe57.SourceDestBuffer(file.image_file, name, array, count, True, True)
        )
    if count:
        header.points.reader(buffers).read()
    points = _points([values[name] for name in axes], axes is _SPHERICAL)
    for name in flags[:1]:
        points[values[name] == 1] = np.nan
    if header.has_pose():
        points = _posed(points, header)
    scan: dict[str, Any] = {axis: points[:, i] for i, axis in enumerate("xyz")}
    limit = _color_limit(header) if colors else 1.0
    for short, name in zip(("red", "green", "blue"), colors, strict=False):
        scan[short] = _color(values[name], limit, path)
    return scan


def _points(axes: list[NDArray[np.float64]], spherical: bool) -> NDArray[np.float64]:
    if not spherical:
        return np.stack(axes, axis=1)
    distance, azimuth, elevation = axes
    flat = distance * np.cos(elevation)
    return np.stack(
        [flat * np.cos(azimuth), flat * np.sin(azimuth), distance * np.sin(elevation)], axis=1
    )


def _posed(points: NDArray[np.float64], header: Any) -> NDArray[np.float64]:
    """Move the points of a scan to its place in the file's frame."""
    from geohue.read.cameras.rig import rotation_from_quaternion

    w, x, y, z = (float(v) for v in header.rotation)
    turned = points @ rotation_from_quaternion([x, y, z, w]).T
    return turned + np.asarray(header.translation, np.float64)


def _color_limit(header: Any) -> float | None:
    """Return the largest colour value by the file's own word; None if it does not say."""
    try:
        return float(header["colorLimits"]["colorRedMaximum"].value())
    except Exception:  # pye57 raises its own kinds for what is not there
        return None


def _color(
    values: NDArray[np.float64], limit: float | None, path: str | Path
) -> NDArray[np.generic]:
    """Bring colours to 8 bits by their limit, or by their size where it is not told."""
    largest = float(values.max(initial=0))
    if values.min(initial=0) < 0 or largest > 65535 or (limit and largest > limit):
        cause = f"has colours out of range ({values.min():g} .. {largest:g}, limit {limit})"
        raise broken(path, f"{cause}; export it with 8- or 16-bit colours")
    if limit is None or limit <= 0:
        limit = 1.0 if largest <= 1 else 255.0 if largest <= 255 else 65535.0
    if limit == 65535.0:
        return np.floor(values / 256).astype(np.uint8)
    return np.rint(values * (255 / limit)).astype(np.uint8)
