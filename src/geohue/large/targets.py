"""The files that the second pass fills, in their full size before it begins."""

from __future__ import annotations

import io
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.lib import format as npy

from geohue.errors import GeohueError
from geohue.large.passes import BLOCK, Target
from geohue.read.clouds.chunk import Chunks
from geohue.read.files import broken, reason
from geohue.results.folder import IN_PIECES, move_results
from geohue.results.las import Block
from geohue.results.ply import ply_header, ply_row

FORMATS = ("ply", "las", "laz")
"""What can be written beside the labels: ``segmented.ply``, ``.las`` or ``.laz``, all points with
their labels."""

_LABELS, _PLY = "labels.npy", "segmented.ply"
_MARGIN = 64 * 2**20


def part_of(file: Path) -> Path:
    """Return the name that a file has until it is whole."""
    return file.with_name(file.name + ".part")


def plan_targets(
    out: Path, n_points: int, is_double: bool, formats: Sequence[str]
) -> dict[Path, tuple[Target, bytes]]:
    """Return each file to write, with its target and its header.

    Raises
    ------
    GeohueError
        For an unknown format.
    """
    unknown = [name for name in formats if name not in FORMATS]
    if unknown:
        choice = ", ".join(FORMATS)
        raise GeohueError(f"format {unknown[0]!r}: of a cloud read in pieces, choose {choice}")
    files = {out / _LABELS: (np.dtype([("label", "<i4")]), _npy_header(n_points))}
    if "ply" in formats:
        files[out / _PLY] = (ply_row(is_double), ply_header(n_points, is_double))
    return {
        file: (Target(part_of(file).absolute(), len(head), row), head)
        for file, (row, head) in files.items()
    }


def clear_parts(out: Path) -> None:
    """Remove what was begun of any file."""
    for name in (_LABELS, _PLY):
        part_of(out / name).unlink(missing_ok=True)


def prepare(target: Target, head: bytes, n_points: int) -> None:
    """Make a file of full size.

    Raises
    ------
    GeohueError
        If it cannot be made or does not fit on the disk.
    """
    size = len(head) + n_points * target.row.itemsize
    try:
        free = shutil.disk_usage(target.path.parent).free
        if free < size + _MARGIN:
            needed = f"{size / 1e9:.3g} GB are needed, {free / 1e9:.3g} GB free"
            raise broken(target.path, f"does not fit on the disk: {needed}; give another folder")
        with target.path.open("wb") as file:
            file.write(head)
            file.truncate(size)
    except OSError as error:
        cause = f"cannot be written ({reason(error)}); choose a folder with space and permission"
        raise broken(target.path, cause) from error


def write_las_files(
    folder: Path, source: Chunks, labels: Path, formats: Sequence[str]
) -> dict[str, Path]:
    """Write the LAS and LAZ files that are asked for; returns them by their names.

    One process writes: what is compressed has no place of its own for each point.

    Parameters
    ----------
    folder : Path
        Where they go until all is whole.
    source : Chunks
        The cloud. Of a LAS or LAZ file everything is kept.
    labels : Path
        NPY with the label of each point.
    formats : sequence of str

    Raises
    ------
    GeohueError
        If a file cannot be written.
    """
    from geohue.results.las import write_las_blocks
    from geohue.results.las_copy import is_las, write_las_like

    found = np.load(labels, mmap_mode="r")

    def blocks() -> Iterator[Block]:
        for start in range(0, source.n_points, BLOCK):
            stop = min(start + BLOCK, source.n_points)
            yield *source.read(start, stop), found[start:stop]
        source.close()

    files = dict[str, Path]()
    for name in (f"segmented.{ending}" for ending in ("las", "laz") if ending in formats):
        files[name] = folder / name
        if is_las(source.path):
            write_las_like(files[name], source.path, found)
        else:
            write_las_blocks(files[name], blocks)
    return files


def publish(out: Path, parts: Iterable[Path], others: Mapping[str, Path]) -> None:
    """Give the files their names: they are whole, and replace those of an earlier run.

    Parameters
    ----------
    out : Path
        The folder of the results.
    parts : iterable of Path
        Files that the jobs filled in; those that have their names already stay.
    others : dict of str to Path
        The other files by their names.

    Raises
    ------
    GeohueError
        If something that has such a name cannot be replaced.
    """
    new = dict(others)
    for file in parts:
        new[file.name] = part_of(file) if part_of(file).exists() else file
    try:
        move_results(new, out, IN_PIECES)
    except OSError as error:
        cause = f"cannot be replaced ({reason(error)}); close or remove it and resume"
        raise broken(error.filename2 or error.filename or out, cause) from error


def _npy_header(n_points: int) -> bytes:
    header = io.BytesIO()
    npy.write_array_header_1_0(
        header, {"descr": "<i4", "fortran_order": False, "shape": (n_points,)}
    )
    return header.getvalue()
