"""A label for every point, whatever is known of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geohue.compute.checks import is_real
from geohue.compute.parallel import cores
from geohue.errors import GeohueError
from geohue.merge.carry import COLOR_UNIT, NEAREST
from geohue.scene import Scene

Labels = NDArray[np.int32]
Floats = NDArray[np.float64]


def assign_labels(
    scene: Scene,
    labels: Labels,
    points: ArrayLike,
    colors: ArrayLike | None = None,
    threads: int | None = None,
) -> Labels:
    """Give each point a label of a segmented scene.

    A point takes that of one of the four nearest labelled points: the one with the least
    ``(d / s)^2 + (dRGB / 30)^2``, s the median distance of neighbours; the nearest one if it has no
    colour. There is no limit of distance. A point without a position takes the segment of the
    nearest mean colour, one without either the largest segment.

    Parameters
    ----------
    scene : Scene
        What was segmented.
    labels : shape of the scene, int32
        Its segments; -1 = none.
    points : (..., 3) float
        Positions in the frame that the scene was made from; not finite ones are missing.
    colors : (..., 3) uint8, or float in 0..1, optional
        sRGB; NaN where a point has none.
    threads : int, optional
        By default one a core.

    Returns
    -------
    (...) int32
        No -1 among them.

    Raises
    ------
    GeohueError
        If the arrays do not fit together, or no point of the scene has a label.

    Examples
    --------
    >>> scene = Scene.from_cloud(np.array([[0, 0, 0], [1, 0, 0]]), np.zeros((2, 3), np.uint8))
    >>> assign_labels(scene, np.array([0, 1], np.int32), [[0.1, 0, 0], [9, 0, 0]]).tolist()
    [0, 1]
    """
    xyz = np.asarray(points)
    if xyz.shape[-1:] != (3,) or not is_real(xyz):
        raise GeohueError(f"points have shape {xyz.shape}: expected (..., 3) numbers")
    rgb = _colors(colors, xyz.shape)
    if not (labels >= 0).any():
        raise GeohueError("no point of the scene has a label to give")
    flat = xyz.reshape(-1, 3) - np.asarray(scene.offset, np.float64)
    found = _by_color(scene, labels, rgb)
    placed = np.isfinite(flat).all(axis=1)
    known = np.flatnonzero((labels.reshape(-1) >= 0) & np.isfinite(scene.points[..., 2]).ravel())
    if placed.any() and len(known):
        found[placed] = _by_place(scene, labels, known, flat[placed], rgb[placed], threads)
    return found.reshape(xyz.shape[:-1])


def _colors(colors: ArrayLike | None, shape: tuple[int, ...]) -> Floats:
    """Colours as 0 to 255, NaN where there is none; (n, 3)."""
    if colors is None:
        return np.full((int(np.prod(shape[:-1])), 3), np.nan)
    rgb = np.asarray(colors)
    if rgb.shape != shape or not (rgb.dtype == np.uint8 or rgb.dtype.kind == "f"):
        raise GeohueError(
            f"colors have shape {rgb.shape} and type {rgb.dtype}: expected {shape}, as uint8 or as "
            "floats in 0..1"
        )
    flat = rgb.reshape(-1, 3).astype(np.float64)
    if rgb.dtype == np.uint8:
        return flat
    flat[~np.isfinite(flat).all(axis=1)] = np.nan
    if np.nanmin(flat, initial=0.0) < 0 or np.nanmax(flat, initial=0.0) > 1:
        raise GeohueError("colors as floats go from 0 to 1: divide by the largest value")
    return flat * 255


def _by_color(scene: Scene, labels: Labels, rgb: Floats) -> Labels:
    """The segment of the nearest mean colour, for points without a colour the largest one."""
    flat = labels.reshape(-1)
    there = flat >= 0
    names, place, size = np.unique(flat[there], return_inverse=True, return_counts=True)
    found = np.full(len(rgb), names[size.argmax()], np.int32)
    asking = np.flatnonzero(~np.isnan(rgb[:, 0]))
    if len(asking) == 0:
        return found
    from scipy.spatial import cKDTree

    own = scene.colors.reshape(-1, 3)[there]
    mean = np.stack([np.bincount(place, own[:, c]) for c in range(3)], axis=1) / size[:, None]
    found[asking] = names[np.asarray(cKDTree(mean).query(rgb[asking])[1])]
    return found


def _by_place(
    scene: Scene,
    labels: Labels,
    known: NDArray[np.int64],
    points: Floats,
    rgb: Floats,
    threads: int | None,
) -> Labels:
    """The label of the best of the four nearest labelled points."""
    from scipy.spatial import cKDTree

    places = scene.points.reshape(-1, 3)[known].astype(np.float64)
    tree = cKDTree(places, balanced_tree=False, compact_nodes=False)
    k, team = min(NEAREST, len(known)), cores() if threads is None else threads
    found = tree.query(points, [*range(1, k + 1)], workers=team)
    away, near = np.asarray(found[0]), np.asarray(found[1])
    some = places[:: max(1, len(places) // 10_000)]
    spacing = 0.0
    if len(known) > 1:
        spacing = float(np.median(np.asarray(tree.query(some, 2)[0])[:, 1]))
    own = scene.colors.reshape(-1, 3)[known].astype(np.float32)
    step = ((own[near] - rgb.astype(np.float32)[:, None]) ** 2).sum(axis=2)
    cost = (away / (spacing or 1.0)) ** 2 + np.nan_to_num(step) / COLOR_UNIT**2
    best = near[np.arange(len(near)), cost.argmin(axis=1)]
    return np.asarray(labels.reshape(-1)[known[best]])
