"""Nested segmentations as a file: ``levels.npz``."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from geohue.merge.levels import Levels
from geohue.results.atomic import atomic_write


def write_levels(path: str | Path, levels: Levels) -> None:
    """Write the regions and the tree of their merges, whole or not at all.

    `geohue.read.read_levels` reads them back.

    Parameters
    ----------
    path : path-like
        The file to write, ending in ``.npz``; folders are made.
    levels : Levels
        Of a segmentation.

    Raises
    ------
    GeohueError
        If the file cannot be written.

    Notes
    -----
    The arrays are ``regions`` (int32, shape of the scene, -1 = none), ``merges`` (M, 2) int64,
    ``scores`` and ``heights`` (M,) float64 and ``n_regions`` (a scalar), as in `MergeTree`.
    ``heights`` follow from ``scores`` and save a reader elsewhere the work.

    Examples
    --------
    >>> from geohue.merge.tree import MergeTree
    >>> from geohue.read import read_levels
    >>> file = getfixture("tmp_path") / "levels.npz"
    >>> tree = MergeTree(2, np.array([[0, 1]]), np.array([0.5]))
    >>> write_levels(file, Levels(np.array([[0, 1]], np.int32), tree))
    >>> read_levels(file).at("coarse").tolist()
    [[0, 0]]
    """
    tree = levels.tree
    with atomic_write(path) as temporary:
        np.savez_compressed(
            temporary,
            regions=levels.regions.astype(np.int32),
            n_regions=np.int64(tree.n_regions),
            merges=tree.merges.astype(np.int64).reshape(-1, 2),
            scores=tree.scores.astype(np.float64),
            heights=tree.heights.astype(np.float64),
        )
