"""Labels as the smallest file that tells all of them apart."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geohue.results.atomic import atomic_write
from geohue.results.png import write_png


def write_labels(name: str | Path, labels: NDArray[np.integer]) -> Path:
    """Write labels in the smallest form that tells all of them apart.

    Parameters
    ----------
    name : path-like
        The file without its ending. A file of an earlier run with the other ending is removed.
    labels : (H, W) or (N,) integers
        From 0; -1 for none.

    Returns
    -------
    Path
        ``NAME.png`` (16 bits, 0 for none, labels from 1) for a grid with at most 65,535 labels,
        else ``NAME.npy`` (int32, -1 for none).

    Raises
    ------
    GeohueError
        If the file cannot be written.

    Examples
    --------
    >>> from geohue.read.images.pictures import read_written_labels
    >>> name = getfixture("tmp_path") / "a.b"
    >>> write_labels(name, np.array([[0, -1]])).name
    'a.b.png'
    >>> write_labels(name, np.array([[65535, -1]])).name
    'a.b.npy'
    >>> read_written_labels(name)
    array([[65535,    -1]], dtype=int32)
    """
    png, npy = (Path(f"{name}.{ending}") for ending in ("png", "npy"))
    if labels.ndim == 2 and int(labels.max(initial=-1)) < np.iinfo(np.uint16).max:
        write_png(png, (labels + 1).astype(np.uint16))
        npy.unlink(missing_ok=True)
        return png
    with atomic_write(npy) as temporary:
        np.save(temporary, labels.astype(np.int32))
    png.unlink(missing_ok=True)
    return npy
