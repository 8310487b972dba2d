"""Regions of a draft for all points of a scene."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from geohue.compute.parallel import Workers
from geohue.features import lab_of
from geohue.merge.borders import draw_borders
from geohue.merge.score import Cues
from geohue.scene import Scene

NEAREST = 4
"""Points of the draft that a point of a cloud may take its region from."""

COLOR_UNIT = 30.0
"""Step of sRGB values that counts like one median distance of neighbours in the draft."""

Labels = NDArray[np.int32]

_BLOCK = 65_536


def carry(
    regions: Labels,
    segments: Labels,
    draft: NDArray[np.int64],
    scene: Scene,
    workers: Workers,
    cues: Cues = "fusion",
    lab: NDArray[np.float32] | None = None,
) -> Labels:
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
    draft : int64, shape of `regions`
        Positions in the scene (`Scene.thinning`).
    scene : Scene
        The scene.
    workers : Workers
        Threads to use.
    cues : {"fusion", "color", "geometry"}
        What borders follow.
    lab : (H, W, 3) float32, optional
        CIELab of the scene's colours, if it is there already.

    Returns
    -------
    (H, W) or (N,) int32
        A region for each point with a position, on grids that go by colour alone for each pixel; -1
        elsewhere.
    """
    if scene.is_grid:
        width = scene.shape[1]
        rows, columns = draft[:, 0] // width, draft[0] % width
        values = _values(scene, cues, lab)
        full = draw_borders(regions, segments, rows, columns, values, workers)
        return full if cues == "color" else np.where(scene.valid, full, np.int32(-1))
    full = np.full(scene.size, -1, np.int32)
    index = np.flatnonzero(scene.valid)
    if cues == "geometry":
        scene = replace(scene, colors=np.zeros_like(scene.colors))
    full[index] = _carry_to_points(regions, draft, index, scene, workers)
    return full


def _values(scene: Scene, cues: Cues, lab: NDArray[np.float32] | None) -> NDArray[np.float32]:
    """L, a, b and the logarithm of depth, NaN where there is none or the cue takes no part."""
    values = np.full((*scene.shape, 4), np.nan, np.float32)
    if cues != "geometry":
        values[..., :3] = lab_of(scene.colors) if lab is None else lab
    if cues != "color":
        with np.errstate(invalid="ignore", divide="ignore"):
            values[..., 3] = np.log(scene.points[..., 2] if scene.depth is None else scene.depth)
    return values


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
