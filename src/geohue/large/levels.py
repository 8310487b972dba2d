"""Nested segmentations of a cloud in pieces: ``levels.npz``, written block by block."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from geohue.large.passes import BLOCK, Target
from geohue.large.targets import part_of
from geohue.merge.levels import threshold_of
from geohue.merge.tree import MergeTree
from geohue.results.atomic import atomic_write
from geohue.segmentation.result import SUMMARY_DETAILS

REGIONS = np.dtype([("region", "<i4")])
"""What the second pass notes of each point, beside its label."""


def plan_regions(folder: Path) -> dict[Path, tuple[Target, bytes]]:
    """Return the file of the regions, which stays in the folder of the state."""
    file = folder / "regions.bin"
    return {file: (Target(part_of(file).absolute(), 0, REGIONS), b"")}


def write_levels(
    path: Path, regions: Target, n_points: int, sizes: NDArray[np.int64], tree: MergeTree
) -> MergeTree:
    """Write what `geohue.results.levels.write_levels` writes, of regions on disk.

    Parameters
    ----------
    path : Path
        The file, ``levels.npz``.
    regions : Target
        The region of each point, rows of `REGIONS`.
    n_points : int
        How many points there are.
    sizes : (R,) int64
        Points of each region; regions without a point are left out, and the others renumbered.
    tree : MergeTree
        How the regions merge.

    Returns
    -------
    MergeTree
        That of the regions written.
    """
    kept = sizes > 0
    name = np.append(np.cumsum(kept, dtype=np.int32) - np.int32(1), np.int32(-1))
    tree = tree if kept.all() else tree.among(kept)
    small = {
        "n_regions": np.int64(tree.n_regions),
        "merges": tree.merges.astype(np.int64).reshape(-1, 2),
        "scores": tree.scores.astype(np.float64),
        "heights": tree.heights.astype(np.float64),
    }
    with (
        atomic_write(path) as temporary,
        zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
    ):
        with (
            archive.open("regions.npy", "w", force_zip64=True) as member,
            regions.path.open("rb") as rows,
        ):
            head = {"descr": "<i4", "fortran_order": False, "shape": (n_points,)}
            npy.write_array_header_1_0(member, head)
            rows.seek(regions.start)
            for start in range(0, n_points, BLOCK):
                block = np.fromfile(rows, "<i4", min(BLOCK, n_points - start))
                member.write(name[block].astype("<i4").tobytes())
        for key, array in small.items():
            with archive.open(f"{key}.npy", "w") as member:
                npy.write_array(member, np.asarray(array))
    return tree


def counted(tree: MergeTree) -> dict[str, object]:
    """Return the number of levels, and of segments at some degrees of detail, for the summary.

    Examples
    --------
    >>> tree = MergeTree(3, np.array([[0, 2], [1, 0]]), np.array([-1.0, 2.0]))
    >>> found = counted(tree)
    >>> found["n"], found["segments"][0], found["segments"][-1]
    (3, [-2.0, 2], [2.0, 3])
    """
    at = ((detail, tree.at(threshold_of(detail))) for detail in SUMMARY_DETAILS)
    segments = [[detail, int(level.max(initial=-1)) + 1] for detail, level in at]
    return {"n": len(tree.merges) + 1, "segments": segments}
