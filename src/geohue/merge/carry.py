"""Regions of a draft for all points of a scene."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

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
_ROWS = 64


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
        values = _values(scene, cues, lab, workers)
        full = draw_borders(regions, segments, rows, columns, values, workers)
        return full if cues == "color" else np.where(scene.valid, full, np.int32(-1))
    full = np.full(scene.size, -1, np.int32)
    index = np.flatnonzero(scene.valid)
    full[index] = _carry_to_points(regions, draft, index, scene, workers, cues)
    return full


def _values(
    scene: Scene, cues: Cues, lab: NDArray[np.float32] | None, workers: Workers
) -> NDArray[np.float32]:
    """L, a, b and the logarithm of depth, NaN where there is none or the cue takes no part."""
    values = np.full((*scene.shape, 4), np.nan, np.float32)
    depth = scene.points[..., 2] if scene.depth is None else scene.depth

    def fill(rows: slice) -> None:
        if cues != "geometry":
            values[rows, :, :3] = lab_of(scene.colors[rows]) if lab is None else lab[rows]
        if cues != "color":
            with np.errstate(invalid="ignore", divide="ignore"):
                np.log(depth[rows], out=values[rows, :, 3])

    for _ in workers.map_blocks(fill, scene.shape[0], _ROWS):
        pass
    return values


@dataclass(frozen=True, slots=True, eq=False)
class Examples:
    """Points of a draft that give their regions to the points of a cloud around them.

    Attributes
    ----------
    places : (m, 3) float64
        Where they lie.
    colors : (m, 3) float32
        sRGB, 0 to 255; zeros where colour takes no part.
    regions : (m,) int32
        Their regions.
    spacing : float
        Median distance of neighbours among them, 0 for a single one.
    """

    places: NDArray[np.float64]
    colors: NDArray[np.float32]
    regions: Labels
    spacing: float

    @classmethod
    def of(
        cls, points: NDArray[np.float32], colors: NDArray[np.uint8], regions: Labels, cues: Cues
    ) -> Examples:
        """Make examples of the points of a draft, (m, 3), and their colours and regions."""
        from scipy.spatial import cKDTree

        places, spacing = points.astype(np.float64), 0.0
        if len(places) > 1:
            found = cKDTree(places).query(places, 2)
            spacing = float(np.median(np.asarray(found[0])[:, 1]))
        return cls(places, _seen(colors, cues), regions, spacing)

    def taker(self, cues: Cues) -> Callable[[NDArray[np.float32], NDArray[np.uint8]], Labels]:
        """Return what gives points, (M, 3) finite, and their colours their regions, (M,)."""
        from scipy.spatial import cKDTree

        tree, k = cKDTree(self.places), min(NEAREST, len(self.places))

        def take(points: NDArray[np.float32], colors: NDArray[np.uint8]) -> Labels:
            found = tree.query(points, k)
            away, near = (np.asarray(part).reshape(len(points), k) for part in found)
            step = ((self.colors[near] - _seen(colors, cues)[:, None]) ** 2).sum(axis=-1)
            cost = (away / (self.spacing or 1.0)) ** 2 + step / COLOR_UNIT**2
            return np.asarray(self.regions[near[np.arange(len(points)), cost.argmin(axis=1)]])

        return take


def _seen(colors: NDArray[np.uint8], cues: Cues) -> NDArray[np.float32]:
    seen = colors.astype(np.float32)
    return np.zeros_like(seen) if cues == "geometry" else seen


def _carry_to_points(
    regions: Labels,
    draft: NDArray[np.int64],
    index: NDArray[np.int64],
    scene: Scene,
    workers: Workers,
    cues: Cues,
) -> Labels:
    take = Examples.of(scene.points[draft], scene.colors[draft], regions, cues).taker(cues)

    def at(block: slice) -> Labels:
        here = index[block]
        return take(scene.points[here], scene.colors[here])

    return np.concatenate(list(workers.map_blocks(at, len(index), _BLOCK)))
