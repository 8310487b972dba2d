"""The points of a scene as the 3-D view takes them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.merge.normals import cloud_normals, grid_normals
from geohue.scene import Scene

Labels = NDArray[np.int32]
Floats = NDArray[np.float32]

_MOST_NORMALS = 40_000  # points whose normals are worked out; others take the nearest one's
_BODY = 0.98  # share of the points that the first view shows


def pack_points(scene: Scene, regions: Labels, most: int) -> tuple[bytes, int]:
    """Put points, colours, normals and regions into one piece of memory.

    The points come in random order, so that the first of them, however many, stand for all: the
    page draws fewer while the view turns. They are moved and scaled so that the body of the scene
    lies within 1 of the origin, with y up: a camera's y points down, a cloud's z is taken as up.

    Parameters
    ----------
    scene : Scene
        With geometry.
    regions : int32, shape of the scene
        -1 = none.
    most : int
        Points to pack at most.

    Returns
    -------
    bytes
        All float32 x, y, z; all uint8 red, green, blue, 255; all int8 normals in 127ths and a 0;
        all uint16 regions, 65535 = none. Little-endian.
    n : int
        How many points.
    """
    index = np.flatnonzero(np.isfinite(scene.points[..., 2]))
    index = np.random.default_rng(0).permutation(index)[:most]
    points = upright(scene, scene.points.reshape(-1, 3)[index])
    normals = _normals(scene, index)
    points = (points - np.median(points, axis=0)).astype(np.float32)
    reach = float(np.quantile(np.linalg.norm(points, axis=1), _BODY)) or 1.0
    n = len(index)
    colors = np.full((n, 4), 255, np.uint8)
    colors[:, :3] = scene.colors.reshape(-1, 3)[index]
    bent = np.zeros((n, 4), np.int8)
    bent[:, :3] = np.rint(127 * np.nan_to_num(upright(scene, normals)))
    names = regions.reshape(-1)[index]
    parts = (
        (points / np.float32(reach)).astype("<f4"),
        colors,
        bent,
        np.where(names < 0, 65535, names).astype("<u2"),
    )
    return b"".join(np.ascontiguousarray(part).tobytes() for part in parts), n


def upright(scene: Scene, vectors: Floats) -> Floats:
    """Return vectors of a scene in a frame whose y points up and whose z points at the viewer.

    Examples
    --------
    >>> scene = Scene.from_cloud(np.zeros((1, 3)), np.zeros((1, 3), np.uint8))
    >>> upright(scene, np.float32([[1, 2, 3]])).tolist()
    [[1.0, 3.0, -2.0]]
    """
    x, y, z = vectors[:, 0], vectors[:, 1], vectors[:, 2]
    return np.stack([x, -y, -z] if scene.is_grid else [x, z, -y], axis=1)


def _normals(scene: Scene, index: NDArray[np.int64]) -> Floats:
    """Normals of some points: as recorded, or from the points around them."""
    if scene.normals is not None:
        return scene.normals.reshape(-1, 3)[index]
    if scene.is_grid:
        across = grid_normals(_without_gaps(scene))
        return across.reshape(-1, 3)[index].astype(np.float32)
    from scipy.spatial import cKDTree

    points = scene.points.reshape(-1, 3)[index].astype(np.float64)
    some = points[:_MOST_NORMALS]
    if len(some) < 3:
        return np.zeros((len(points), 3), np.float32)
    found: Floats = cloud_normals(some).astype(np.float32)
    if len(some) == len(points):
        return found
    nearest = np.asarray(cKDTree(some).query(points)[1], np.int64)
    return np.asarray(found[nearest], np.float32)


def _without_gaps(scene: Scene) -> NDArray[np.float64]:
    from geohue.regions.adjacency import nearest_known

    near = nearest_known(np.isfinite(scene.points[..., 2]))
    return scene.points.reshape(-1, 3)[near].astype(np.float64)
