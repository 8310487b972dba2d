"""Labels of any file that geohue writes, in one numbering: segments from 0, -1 for none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geohue.read.arrays import read_npy
from geohue.read.files import broken
from geohue.read.images.pictures import read_labels

_CLOUDS = (".ply", ".pcd", ".las", ".laz")


def read_segments(path: str | Path) -> NDArray[np.int32]:
    """Read labels as the library has them, whatever the numbering of the file.

    Parameters
    ----------
    path : path-like
        A label image (PNG, TIFF; 0 = none, segments from 1), an array (NPY; -1 = none, segments
        from 0) or a labelled cloud (PLY, PCD, LAS, LAZ; the same).

    Returns
    -------
    (H, W) or (N,) int32
        Segments from 0; -1 for none.

    Raises
    ------
    GeohueError
        If the file is missing or damaged, or holds no labels.

    Examples
    --------
    >>> from geohue.results import write_png
    >>> folder = getfixture("tmp_path")
    >>> write_png(folder / "labels.png", np.array([[0, 1, 2]], np.uint16))
    >>> np.save(folder / "labels.npy", np.array([-1, 0, 1]))
    >>> [read_segments(folder / f"labels.{ending}").tolist() for ending in ("png", "npy")]
    [[[-1, 0, 1]], [-1, 0, 1]]
    """
    ending = Path(path).suffix.lower()
    if ending in _CLOUDS:
        from geohue.read.clouds.cloud import read_cloud

        labels = read_cloud(path).labels
        if labels is None:
            raise broken(path, "has no labels (a property label or segment_id)")
        return labels
    if ending != ".npy":
        return read_labels(path) - 1
    array = read_npy(path)
    if array.dtype.kind not in "iu" or array.ndim not in (1, 2) or array.size == 0:
        cause = f"holds {array.dtype} {array.shape}, no labels"
        raise broken(path, f"{cause}; labels are whole numbers, one a pixel or point")
    if int(array.min()) < -1 or int(array.max()) > np.iinfo(np.int32).max:
        raise broken(path, f"has labels from {array.min()} to {array.max()}; expected -1 or more")
    return array.astype(np.int32)
