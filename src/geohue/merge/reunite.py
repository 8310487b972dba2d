"""One name for the parts of a surface that something in front of it has cut apart."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from geohue.compute.labels import relabel
from geohue.errors import GeohueError
from geohue.features import lab_of
from geohue.regions.adjacency import adjacent_pixels
from geohue.scene import Scene

LEAST = 50
"""Pixels with depth that a part needs for a surface of its own."""

COLOR_STEP = 10.0
"""Distance of mean L, a, b up to which two parts look alike, shading included."""

NOISE = 0.004
"""Relative error of depth that is never a difference of form."""

SLACK = 1.5
"""How much worse a part may lie on the common surface than on its own."""

NEARER = 3.0
"""Errors by which something must lie before the surface to be in front of it."""

SHARE = 0.9
"""Share of the pixels between two parts that must lie in front."""

_SAMPLE = 600  # pixels of each part in a fit
_LINES = 64  # ways across from one part to the other

Labels = NDArray[np.int32]
Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """A segment: some of its pixels as rows y, x, their inverse depths, and its mean colour."""

    pixels: NDArray[np.int64]
    inverse: Floats
    color: Floats


def check_reunite(scene: Scene) -> None:
    """Raise `GeohueError` for a scene in which nothing is in front of anything."""
    if not scene.is_grid or not (scene.points[..., 2][scene.valid] > 0).any():
        raise GeohueError(
            "reunite needs a frame with depth: without a camera nothing is in front of anything"
        )


def reunite(labels: Labels, scene: Scene) -> Labels:
    """Give the parts of one surface that do not touch one label, where something hides the rest.

    Two segments become one if they do not touch; their mean colours are alike; one plane, or else
    one quadric ``1 / z = a + b u + c v + d u^2 + e u v + f v^2`` of the pixels (u, v), carries both
    about as well as each has its own; and nearly all pixels between them lie nearer to the camera
    than this surface does.

    Parameters
    ----------
    labels : (H, W) int32
        Segments, -1 = none.
    scene : Scene
        The frame, with depth in some pixels.

    Returns
    -------
    (H, W) int32
        Segments 0..K-1, the largest first; -1 stays.

    Raises
    ------
    GeohueError
        For a cloud without a grid, or a frame without depth.

    Examples
    --------
    >>> rgb = np.full((40, 60, 3), 180, np.uint8)
    >>> depth = np.full((40, 60), 3.0)
    >>> rgb[:, 25:32], depth[:, 25:32] = (150, 30, 30), 2.0  # a post in front of a wall
    >>> labels = np.repeat([0, 1, 2], [25, 7, 28])[None].repeat(40, 0).astype(np.int32)
    >>> reunite(labels, Scene.from_rgbd(rgb, depth))[0, ::20].tolist()
    [0, 0, 0]
    """
    check_reunite(scene)
    depth = scene.points[..., 2].astype(np.float64)
    depth[~scene.valid | ~(depth > 0)] = np.nan
    parts = _parts(labels, depth, lab_of(scene.colors))
    touching = _touching(labels)
    name = np.arange(int(labels.max(initial=-1)) + 2, dtype=np.int32)
    name[-1] = -1
    for i, j in combinations(parts, 2):
        if name[i] == name[j] or (i, j) in touching:
            continue
        if np.linalg.norm(parts[i].color - parts[j].color) > COLOR_STEP:
            continue
        if _is_one_surface(parts[i], parts[j], labels, (i, j), depth):
            name[name == name[j]] = name[i]
    return relabel(name[labels])[0]


def _parts(labels: Labels, depth: Floats, lab: NDArray[np.float32]) -> dict[int, _Part]:
    parts = {}
    known = np.isfinite(depth)
    for label in range(int(labels.max(initial=-1)) + 1):
        mine = labels == label
        pixels = np.argwhere(mine & known)
        if len(pixels) >= LEAST:
            some = pixels[np.linspace(0, len(pixels) - 1, min(_SAMPLE, len(pixels))).astype(int)]
            color = lab[mine].mean(axis=0, dtype=np.float64)
            parts[label] = _Part(some, 1 / depth[some[:, 0], some[:, 1]], color)
    return parts


def _touching(labels: Labels) -> set[tuple[int, int]]:
    one, other = adjacent_pixels(labels.shape)
    sides = np.sort(np.stack([labels.reshape(-1)[one], labels.reshape(-1)[other]], axis=1), axis=1)
    return {(int(i), int(j)) for i, j in np.unique(sides[sides[:, 0] != sides[:, 1]], axis=0)}


def _is_one_surface(
    one: _Part, other: _Part, labels: Labels, pair: tuple[int, int], depth: Floats
) -> bool:
    between = _between(one.pixels, other.pixels, labels, pair)
    seen = depth[between[:, 0], between[:, 1]]
    between, seen = between[np.isfinite(seen)], seen[np.isfinite(seen)]
    if len(between) == 0:
        return False
    pixels = np.concatenate([one.pixels, other.pixels])
    inverse = np.concatenate([one.inverse, other.inverse])
    for terms in (3, 6):  # a plane, a quadric
        common = _fit(pixels, inverse, terms, depth.shape)
        errors = []
        for part in (one, other):
            own = _fit(part.pixels, part.inverse, terms, depth.shape)
            least, error = (_error(part, c, depth.shape) for c in (own, common))
            errors.append((error, max(SLACK * least, NOISE)))
        if all(error <= most for error, most in errors):
            surface = _basis(between, terms, depth.shape) @ common
            margin = NEARER * max(NOISE, *(error for error, _ in errors))
            return bool((seen * surface < 1 - margin).mean() >= SHARE)
    return False


def _between(
    one: NDArray[np.int64], other: NDArray[np.int64], labels: Labels, pair: tuple[int, int]
) -> NDArray[np.int64]:
    """Pixels of neither part on straight ways from pixels of each to the nearest of the other."""
    from scipy.spatial import cKDTree

    ways = []
    for start, goals in ((one, other), (other, one)):
        some = start[np.linspace(0, len(start) - 1, _LINES).astype(int)]
        _, nearest = cKDTree(goals).query(some)
        ends = goals[nearest]
        steps = int(np.abs(ends - some).max()) + 1
        along = np.linspace(0, 1, steps)[:, None, None]
        ways.append(np.rint(some + along * (ends - some)).astype(np.int64).reshape(-1, 2))
    pixels = np.unique(np.concatenate(ways), axis=0)
    return pixels[~np.isin(labels[pixels[:, 0], pixels[:, 1]], pair)]


def _basis(pixels: NDArray[np.int64], terms: int, shape: tuple[int, ...]) -> Floats:
    v, u = (2 * pixels[:, i] / max(shape) - 1 for i in (0, 1))
    return np.stack([np.ones(len(u)), u, v, u * u, u * v, v * v][:terms], axis=1)


def _fit(pixels: NDArray[np.int64], inverse: Floats, terms: int, shape: tuple[int, ...]) -> Floats:
    """Coefficients with the least squares of relative depth, without the tenth that fits worst."""
    basis = _basis(pixels, terms, shape) / inverse[:, None]
    kept = np.full(len(basis), True)
    for _ in range(2):
        found = np.linalg.lstsq(basis[kept], np.ones(int(kept.sum())), rcond=None)[0]
        away = np.abs(basis @ found - 1)
        kept = away <= np.quantile(away, 0.9)
    return np.asarray(found)


def _error(part: _Part, coefficients: Floats, shape: tuple[int, ...]) -> float:
    """Typical relative error of depth: 1.48 medians, the deviation of normal noise."""
    surface = _basis(part.pixels, len(coefficients), shape) @ coefficients
    return float(1.4826 * np.median(np.abs(surface / part.inverse - 1)))
