"""Labelled clouds as LAS and LAZ, with laspy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from geohue.read.extras import optional
from geohue.read.files import broken, reason
from geohue.results.atomic import atomic_write


def write_las(
    path: str | Path,
    points: ArrayLike,
    colors: ArrayLike,
    labels: ArrayLike,
    offset: ArrayLike = (0.0, 0.0, 0.0),
) -> None:
    """Write a labelled cloud as LAS 1.4, or LAZ where the name ends so; whole or not at all.

    Coordinates are kept to a millionth of the cloud's extent or finer (whole numbers of a power
    of ten), colours as 16 bits (257 times the 8-bit value), labels in the extra dimension
    ``segment_id`` (int32).

    Parameters
    ----------
    path : path-like
        ``.las`` or ``.laz``.
    points : (N, 3)
        Finite coordinates.
    colors : (N, 3) uint8
        sRGB.
    labels : (N,) integers
        -1 for none.
    offset : (3,)
        Added to the coordinates in float64: `CloudData.offset`.

    Raises
    ------
    GeohueError
        If laspy is not installed, the shapes do not fit, or the file cannot be written.
    """
    laspy = optional("laspy", "clouds", path)
    xyz, rgb = np.asarray(points, np.float64), np.asarray(colors, np.uint8)
    label, place = np.asarray(labels, np.int32), np.asarray(offset, np.float64)
    if xyz.shape != (label.size, 3) or rgb.shape != xyz.shape or label.size == 0:
        shapes = f"points {xyz.shape}, colours {rgb.shape}, labels {label.shape}"
        raise broken(path, f"not written: {shapes} do not fit together")
    if not np.isfinite(xyz).all():
        raise broken(path, "not written: LAS has no place for points without coordinates")
    header = laspy.LasHeader(point_format=7, version="1.4")
    header.add_extra_dim(laspy.ExtraBytesParams(name="segment_id", type=np.int32))
    low, high = xyz.min(axis=0), xyz.max(axis=0)
    extent = float((high - low).max()) or float(np.abs(high).max()) or 1.0
    header.scales = np.full(3, 10.0 ** np.floor(np.log10(extent / 1e8)))
    header.offsets = place + (low + high) / 2
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = (xyz[:, i] + place[i] for i in range(3))
    cloud.red, cloud.green, cloud.blue = (rgb[:, i].astype(np.uint16) * 257 for i in range(3))
    cloud.segment_id = label
    with atomic_write(path) as temporary:
        try:
            cloud.write(temporary)
        except OSError:
            raise
        except Exception as error:
            raise broken(path, f"not written ({reason(error)})") from error
