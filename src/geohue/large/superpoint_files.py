"""The files of superpoints of a cloud in tiles, written block by block."""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import IO

import numpy as np
from numpy.lib import format as npy

from geohue.large.tile_graph import Whole
from geohue.large.tiles import Buckets, Positions, in_file_order


def write_tiled(
    folder: Path, buckets: Buckets, n_points: int, whole: Whole, coarser: Sequence[int]
) -> tuple[int, ...]:
    """Write ``superpoints.npy``, ``levels.npz`` and ``graph.npz``.

    Parameters
    ----------
    folder : Path
        Where they go.
    buckets : Buckets
        The regions of all points.
    n_points : int
        Points of the cloud.
    whole : Whole
        The superpoint of each region.
    coarser : sequence of int
        How many superpoints the other levels have.

    Returns
    -------
    tuple of int
        How many each level has.
    """
    levels = [whole.name]
    for count in coarser:
        level = whole.tree.with_segments(count).astype(np.int64)
        levels.append(np.append(level, -1)[whole.name])
    with (folder / "superpoints.npy").open("wb") as file:
        npy.write_array_header_1_0(file, _head((n_points,)))
        _write(file, buckets, n_points, whole, levels[0])
    counts = np.array([int(level.max()) + 1 for level in levels])
    packed = zipfile.ZipFile(folder / "levels.npz", "w", zipfile.ZIP_DEFLATED, compresslevel=1)
    with packed as archive:
        with archive.open("labels.npy", "w", force_zip64=True) as member:
            npy.write_array_header_1_0(member, _head((len(levels), n_points)))
            for level in levels:
                _write(member, buckets, n_points, whole, level)
        with archive.open("counts.npy", "w") as member:
            npy.write_array(member, counts)
    np.savez_compressed(folder / "graph.npz", **whole.graph)  # type: ignore[arg-type]
    return tuple(counts.tolist())


def _head(shape: tuple[int, ...]) -> dict[str, object]:
    return {"descr": "<i8", "fortran_order": False, "shape": shape}


def _write(
    file: IO[bytes], buckets: Buckets, n_points: int, whole: Whole, level: Positions
) -> None:
    for regions in in_file_order(buckets, n_points, whole.starts):
        file.write(level[regions].astype("<i8").tobytes())
