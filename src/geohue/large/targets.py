"""The files that the second pass fills, in their full size before it begins."""

from __future__ import annotations

import io
import shutil
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from numpy.lib import format as npy

from geohue.errors import GeohueError
from geohue.large.passes import Target
from geohue.read.files import broken, reason

FORMATS = ("ply",)
"""What can be written beside the labels: ``segmented.ply``, all points with their labels."""

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
        row = np.dtype(
            [
                ("xyz", "<f8" if is_double else "<f4", 3),
                ("rgb", "u1", 3),
                ("label", "<i4"),
                ("scalar_label", "<f4"),
            ]
        )
        files[out / _PLY] = (row, _ply_header(n_points, is_double))
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


def publish(targets: Iterable[Path]) -> None:
    """Give the files their names: they are whole.

    Raises
    ------
    GeohueError
        If something that has such a name cannot be replaced.
    """
    for file in targets:
        part = part_of(file)
        if not part.exists():
            continue
        try:
            part.replace(file)
        except OSError as error:
            cause = f"cannot be replaced ({reason(error)}); close or remove it and resume"
            raise broken(file, cause) from error


def _npy_header(n_points: int) -> bytes:
    header = io.BytesIO()
    npy.write_array_header_1_0(
        header, {"descr": "<i4", "fortran_order": False, "shape": (n_points,)}
    )
    return header.getvalue()


def _ply_header(n_points: int, is_double: bool) -> bytes:
    kind = "double" if is_double else "float"
    names = [f"{kind} x", f"{kind} y", f"{kind} z"]
    names += ["uchar red", "uchar green", "uchar blue", "int label", "float scalar_label"]
    properties = "".join(f"property {name}\n" for name in names)
    start = "ply\nformat binary_little_endian 1.0\n"
    return f"{start}element vertex {n_points}\n{properties}end_header\n".encode()
