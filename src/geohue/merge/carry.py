"""Regions of a draft for all points of a scene."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.compute.parallel import Workers
from geohue.merge.borders import draw_borders
from geohue.prepared import PreparedScene
from geohue.scene import Scene

NEAREST = 4
"""Points of the draft that a point of a cloud may take its region from."""

COLOR_UNIT = 30.0
"""Step of sRGB values that counts like one median distance of neighbours in the draft."""

Labels = NDArray[np.int32]

_BLOCK = 65_536


def carry(regions: Labels, segments: Labels, prepared: PreparedScene) -> Labels:
    """Give each point of a scene a region of the draft.

    On a grid borders are drawn between segments (`draw_borders`). A point of a cloud takes the
    region of that of the four nearest points of the draft that is nearest in space and colour:
    with the least ``(d / s)^2 + (dRGB / 30)^2``, s the median distance of neighbours in the draft.

    Parameters
    ----------
    regions : (h, w) or (m,) int32
        Fine regions of the draft, none missing.
    segments : (R,) int32
        The segment of each region.
    prepared : PreparedScene
        The scene and its draft.

    Returns
    -------
    (H, W) or (N,) int32
        A region for each point with a position, or for each point where none has one; -1 elsewhere.
    """
    scene, draft, workers = prepared.scene, prepared.positions, prepared.workers
    known = scene.valid
    if not known.any():  # an image alone
        known = np.ones(scene.shape, bool)
    if scene.is_grid:
        width = scene.shape[1]
        rows, columns = draft[:, 0] // width, draft[0] % width
        with np.errstate(invalid="ignore", divide="ignore"):
            depth = np.log(scene.points[..., 2:] if scene.depth is None else scene.depth[..., None])
        values = np.concatenate([prepared.raw.lab, depth.astype(np.float32)], axis=-1)
        full = draw_borders(regions, segments, rows, columns, values, workers)
        return np.where(known, full, np.int32(-1))
    full = np.full(scene.size, -1, np.int32)
    index = np.flatnonzero(known)
    full[index] = _carry_to_points(regions, draft, index, scene, workers)
    return full


def _carry_to_points(
    regions: Labels,
    draft: NDArray[np.int64],
    index: NDArray[np.int64],
    scene: Scene,
    workers: Workers,
) -> Labels:
    from scipy.spatial import cKDTree

    places = scene.points[draft].astype(np.float64)
    colors = scene.colors[draft].astype(np.float32)
    tree = cKDTree(places)
    k = min(NEAREST, len(draft))
    spacing = 0.0
    if len(draft) > 1:
        spacing = float(np.median(np.asarray(tree.query(places, 2)[0])[:, 1]))

    def take(block: slice) -> Labels:
        here = index[block]
        found = tree.query(scene.points[here], k)
        away, near = (np.asarray(part).reshape(len(here), k) for part in found)
        step = ((colors[near] - scene.colors[here].astype(np.float32)[:, None]) ** 2).sum(axis=-1)
        cost = (away / (spacing or 1.0)) ** 2 + step / COLOR_UNIT**2
        return np.asarray(regions[near[np.arange(len(here)), cost.argmin(axis=1)]])

    return np.concatenate(list(workers.map_blocks(take, len(index), _BLOCK)))
