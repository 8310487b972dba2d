"""Labelled clouds as LAS and LAZ, with laspy."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geohue.read.extras import optional
from geohue.read.files import broken, reason
from geohue.results.atomic import atomic_write

Block = tuple[NDArray[np.floating[Any]], NDArray[np.uint8], NDArray[np.integer[Any]]]
"""Points (m, 3), sRGB (m, 3) and labels (m,)."""


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
    xyz, rgb = np.asarray(points, np.float64), np.asarray(colors, np.uint8)
    label = np.asarray(labels, np.int32)
    if xyz.shape != (label.size, 3) or rgb.shape != xyz.shape or label.size == 0:
        shapes = f"points {xyz.shape}, colours {rgb.shape}, labels {label.shape}"
        raise broken(path, f"not written: {shapes} do not fit together")
    if not np.isfinite(xyz).all():
        raise broken(path, "not written: LAS has no place for points without coordinates")
    write_las_blocks(path, lambda: iter([(xyz + np.asarray(offset, np.float64), rgb, label)]))


def write_las_blocks(path: str | Path, blocks: Callable[[], Iterator[Block]]) -> None:
    """Write a labelled cloud that is read block by block, as `write_las` does.

    Parameters
    ----------
    path : path-like
        ``.las`` or ``.laz``.
    blocks : callable
        Gives the cloud from its beginning; called twice, first for its extent. Points without
        coordinates are left out: LAS has no place for them.

    Raises
    ------
    GeohueError
        If laspy is not installed, no point has coordinates, or the file cannot be written.
    """
    laspy = optional("laspy", "clouds", path)
    low, high = _extent(blocks())
    if not (low <= high).all():
        raise broken(path, "not written: no point has coordinates")
    header = laspy.LasHeader(point_format=7, version="1.4")
    header.add_extra_dim(laspy.ExtraBytesParams(name="segment_id", type=np.int32))
    extent = float((high - low).max()) or float(np.abs(high).max()) or 1.0
    header.scales = np.full(3, 10.0 ** np.floor(np.log10(extent / 1e8)))
    header.offsets = (low + high) / 2
    with atomic_write(path) as temporary:
        try:
            with laspy.open(str(temporary), mode="w", header=header) as writer:
                for xyz, rgb, label in blocks():
                    writer.write_points(_record(laspy, header, xyz, rgb, label))
        except OSError:
            raise
        except Exception as error:
            raise broken(path, f"not written ({reason(error)})") from error


def _extent(blocks: Iterator[Block]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for xyz, _, _ in blocks:
        known = xyz[np.isfinite(xyz).all(axis=1)]
        low = np.minimum(low, known.min(axis=0, initial=np.inf))
        high = np.maximum(high, known.max(axis=0, initial=-np.inf))
    return low, high


def _record(
    laspy: Any,
    header: Any,
    xyz: NDArray[np.floating[Any]],
    rgb: NDArray[np.uint8],
    label: NDArray[np.integer[Any]],
) -> Any:
    known = np.isfinite(xyz).all(axis=1)
    rows = laspy.ScaleAwarePointRecord.zeros(int(known.sum()), header=header)
    for i, name in enumerate("xyz"):
        rows[name] = xyz[known, i].astype(np.float64)
    for i, name in enumerate(("red", "green", "blue")):
        rows[name] = rgb[known, i].astype(np.uint16) * 257
    rows["segment_id"] = label[known]
    return rows
