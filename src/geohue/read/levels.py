"""Nested segmentations from a file: ``levels.npz``."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.merge.levels import Levels
from geohue.merge.tree import MergeTree
from geohue.read.arrays import npz_member
from geohue.read.files import broken, read_bytes, reason


def read_levels(path: str | Path) -> Levels:
    """Read the nested segmentations of a result.

    Parameters
    ----------
    path : path-like
        ``levels.npz``, as ``geohue segment -o`` writes it.

    Returns
    -------
    Levels

    Raises
    ------
    GeohueError
        If the file is missing, damaged or of another kind, or its arrays contradict each other.

    Examples
    --------
    >>> read_levels("nowhere/levels.npz")
    Traceback (most recent call last):
    geohue.errors.GeohueError: nowhere/levels.npz: no such file; check the name and the folder
    """
    data = read_bytes(path)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            regions, n_regions, merges, scores = (
                npz_member(archive, name, path)
                for name in ("regions", "n_regions", "merges", "scores")
            )
    except GeohueError:
        raise
    except Exception as error:  # zipfile lets zlib, struct, encoding and other errors through
        raise broken(path, f"is not a whole NPZ file ({reason(error)}); write it again") from error
    _check(path, regions, n_regions, merges, scores)
    tree = MergeTree(int(n_regions), merges.astype(np.int64), scores.astype(np.float64))
    return Levels(regions.astype(np.int32), tree)


def _check(
    path: str | Path,
    regions: NDArray[Any],
    n_regions: NDArray[Any],
    merges: NDArray[Any],
    scores: NDArray[Any],
) -> None:
    """Raise an error unless the arrays are regions and a tree over them."""
    whole = all(array.dtype.kind in "iu" for array in (regions, n_regions, merges))
    shaped = n_regions.ndim == 0 and merges.ndim == 2 and merges.shape[1] == 2
    if not whole or not shaped or scores.shape != merges.shape[:1] or regions.ndim not in (1, 2):
        raise broken(path, "holds no levels of a segmentation; give the levels.npz of a result")
    n = int(n_regions)
    if _outside(regions, -1, n) or _outside(merges, 0, n) or np.isnan(scores).any():
        raise broken(path, f"names regions beyond its {n}, or has no scores; write it again")
    # Every merge ends the name of a region that is still there, so each name ends once at most,
    # and none is merged with itself.
    kept, gone = merges[:, 0], merges[:, 1]
    ended = np.full(n, len(merges), np.int64)
    ended[gone] = np.arange(len(merges))
    order = np.arange(len(merges))
    if len(np.unique(gone)) < len(gone) or (ended[kept] <= order).any():
        raise broken(path, "merges a region twice; write it again")


def _outside(values: NDArray[Any], low: int, stop: int) -> bool:
    return bool(values.size) and (int(values.min()) < low or int(values.max()) >= stop)
