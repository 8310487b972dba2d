"""Where the points of a scene are in the coordinates of their file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.read.clouds.chunks import CHUNKED_SUFFIXES, open_chunks
from geohue.scene import Scene


def places_of(scene: Scene) -> NDArray[np.float32] | NDArray[np.float64]:
    """Return the coordinates of a scene's points as they are in the file that it was read from.

    A scene holds float32, less the offset of map coordinates. A file with double coordinates is
    read again, so that none of their digits is lost.

    Returns
    -------
    (..., 3) float64 or float32
        float64 where the file has more digits than float32, or an offset was taken off.
    """
    exact = None if scene.source is None else _from_file(scene.source, scene.size)
    if exact is not None:
        return exact.reshape(scene.points.shape)
    if not any(scene.offset):
        return scene.points
    return np.asarray(scene.points + np.asarray(scene.offset, np.float64))


def _from_file(path: Path, n_points: int) -> NDArray[np.float64] | None:
    """Return the double coordinates of a cloud, None if it has others or cannot be read so."""
    if path.suffix.lower() not in CHUNKED_SUFFIXES:
        return None
    try:
        chunks = open_chunks(path)
        if not chunks.is_double or chunks.n_points != n_points:
            return None
        try:
            return chunks.read(0, n_points)[0]
        finally:
            chunks.close()
    except GeohueError:  # gone, or of a kind that only its usual reader knows
        return None
