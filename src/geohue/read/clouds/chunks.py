"""Clouds larger than memory: any stretch of points read by itself."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from geohue.read.clouds.chunk import Chunks
from geohue.read.files import broken, check_file


def open_chunks(path: str | Path) -> Chunks:
    """Open a cloud for reading piece by piece.

    Parameters
    ----------
    path : path-like
        ``.las`` or ``.laz``; binary ``.ply`` without lists among its vertices; ``.npy`` with rows
        x, y, z, red, green, blue (or x, y, z alone).

    Returns
    -------
    Chunks

    Raises
    ------
    GeohueError
        If the file is missing, cut short, damaged, or cannot be read in pieces.

    Examples
    --------
    >>> import numpy as np
    >>> file = getfixture("tmp_path") / "cloud.npy"
    >>> np.save(file, np.array([[0, 0, 1, 255, 0, 0], [0, 1, 1, 0, 255, 0]], np.float32))
    >>> xyz, rgb = open_chunks(file).read(1, 2)
    >>> xyz.tolist(), rgb.tolist()
    ([[0.0, 1.0, 1.0]], [[0, 255, 0]])
    """
    file = Path(path)
    opener = _openers().get(file.suffix.lower())
    if opener is None:
        endings = " ".join(CHUNKED_SUFFIXES)
        raise broken(path, f"cannot be read in pieces ({endings} can); convert it to .laz")
    check_file(path)
    if file.stat().st_size == 0:
        raise broken(path, "is empty (0 bytes); copy or export it again")
    return opener(file)


CHUNKED_SUFFIXES = (".las", ".laz", ".ply", ".npy")
"""Endings of the files that can be read in pieces."""


def _openers() -> dict[str, Callable[[Path], Chunks]]:
    from geohue.read.clouds.chunks_las import open_las
    from geohue.read.clouds.chunks_rows import open_npy, open_ply

    return {".las": open_las, ".laz": open_las, ".ply": open_ply, ".npy": open_npy}
