"""Limbs: the thin parts of a cloud that branches, such as the leaves of a plant.

Thin parts of one colour differ in nothing but their place in the whole, so that neither colour nor
surfaces tell where a leaf ends. Their topology does: walking inwards from the tips, at one
distance from the centre after the other, parts of the cloud meet where limbs join.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.merge.limb_spans import Spans
from geohue.merge.limb_surface import Surface
from geohue.merge.limb_sweep import CLOSED, sweep_inwards
from geohue.merge.limb_trunk import find_trunk

FAR = 5.0
"""Pairs of neighbours farther apart than so many spacings are no connection."""

SMALL = 0.02
"""Share of the points below which a piece belongs to what lies nearest to it."""

SHORTEST = 0.06
"""Shortest limb, as a share of the distance from the centre of its piece to the farthest tip."""

SLIM = 1.0
"""Least squared length of a limb over its area: 1 for a strip as long as it is wide."""

FEWEST = 3
"""Limbs of a thing that branches; with two it is bent at most."""

ENDS = 11
"""Points far from each other from which the centre is found. Odd: no two points are as good."""


@dataclass(frozen=True, slots=True, eq=False)
class Limbs:
    """The limbs of a cloud.

    Attributes
    ----------
    labels : (n,) int32
        A segment for each point, from 0, the largest first.
    trunk : (K,) bool
        Which segments are what limbs grow from, at most one for each connected piece.
    sizes : (K,) int64
        Points of each segment.
    slimness : (K,) float64
        Length of each limb along the surface, in widths (`Spans`); 0 for trunks.
    reach : (n,) float64
        Length of each point's shortest path to the centre of its piece, 0 in pieces too small to
        have one; in the unit of the points.
    """

    labels: NDArray[np.int32]
    trunk: NDArray[np.bool_]
    sizes: NDArray[np.int64]
    slimness: NDArray[np.float64]
    reach: NDArray[np.float64]

    @property
    def shares(self) -> NDArray[np.float64]:
        """Share of all points in each segment, (K,)."""
        return self.sizes / max(len(self.labels), 1)


def find_limbs(
    points: NDArray[np.floating],
    one: NDArray[np.int64],
    other: NDArray[np.int64],
    spacing: float,
) -> Limbs:
    """Part a cloud into its limbs and the trunk they grow from.

    The length of each point's shortest path to the centre, along pairs of neighbours, orders the
    points; a sweep from the farthest inwards grows sets, and closes those that are long and slim
    where they meet (`sweep_inwards`; the join tree of Carr, Snoeyink and Axen 2003, with long
    branches kept apart). What is left in the middle still holds the inner ends of limbs that touch
    on the way: it goes to the limb whose path to the centre is nearest, except where several run
    together (`find_trunk`).

    Parameters
    ----------
    points : (n, 3) float
        Positions, all finite, in any unit.
    one, other : (E,) int64
        Pairs of neighbours, in any order and direction.
    spacing : float
        Typical distance of neighbours, in the unit of the points.

    Returns
    -------
    Limbs
        A piece with fewer than `FEWEST` limbs is a single segment: a line, a strip, a ring.

    Raises
    ------
    GeohueError
        If the points are not (n, 3) finite numbers.

    References
    ----------
    H. Carr, J. Snoeyink, U. Axen, "Computing contour trees in all dimensions", Computational
    Geometry 24(2), 2003.

    Examples
    --------
    >>> arm = np.arange(1.0, 30)[:, None] * [[1, 0, 0]]
    >>> star = np.concatenate([[[0, 0, 0]], arm, np.roll(arm, 1, axis=1), np.roll(arm, 2, axis=1)])
    >>> at = np.arange(1, 88)
    >>> limbs = find_limbs(star, at, np.where((at - 1) % 29 == 0, 0, at - 1), spacing=1.0)
    >>> limbs.labels[[0, 10, 40, 70]].tolist(), limbs.trunk.tolist()
    ([3, 0, 1, 2], [False, False, False, True])
    """
    if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
        raise GeohueError(f"points have shape {points.shape}: expected (n, 3) finite numbers")
    places = points.astype(np.float64)
    surface = Surface.of(places, one, other, FAR * spacing)
    piece = surface.pieces()
    sizes = np.bincount(piece, minlength=1)
    part = np.full(len(points), -1, np.int64)
    reach = np.zeros(len(points))
    trunks = []
    large = (sizes >= SMALL * len(points)) | (sizes == sizes.max())
    for number in np.flatnonzero(large & (sizes > 0)):
        index = np.flatnonzero(piece == number)
        owner, reach[index] = _piece_limbs(surface.part(index), spacing)
        trunks.append(part.max(initial=-1) + 1)
        part[index] = owner + trunks[-1] + 1
    return _numbered(places, part, np.array(trunks, np.int64), reach)


def _piece_limbs(surface: Surface, spacing: float) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the limb of each point of a connected piece, -1 for the trunk, and its reach."""
    reach, before = surface.paths(_center(surface))
    owner = _sweep(surface, reach, spacing)
    if owner.max() + 1 < FEWEST:
        return np.full_like(owner, -1), reach
    return find_trunk(surface, owner, reach, before), reach


def _center(surface: Surface) -> int:
    """Find the point with the least mean distance from points far from each other."""
    points = surface.points
    away = ((points - points.mean(axis=0)) ** 2).sum(axis=1)
    total = np.zeros(len(points))
    nearest = np.full(len(points), np.inf)
    for _ in range(ENDS):
        distance = surface.distances(int(away.argmax()))
        total += distance
        nearest = np.minimum(nearest, distance)
        away = nearest
    return int(total.argmin())


def _sweep(surface: Surface, reach: NDArray[np.float64], spacing: float) -> NDArray[np.int64]:
    """Return the limb that a sweep leaves each point in, -1 for the core."""
    n = len(reach)
    parent = np.full(n, -1, np.int32)
    size, state = np.zeros(n, np.int64), np.zeros(n, np.int8)
    met = np.empty(int(np.diff(surface.graph.indptr).max(initial=0)), np.int32)
    sweep_inwards(
        np.argsort(-reach, kind="stable"),
        reach,
        surface.graph.indptr.astype(np.int32),
        surface.graph.indices.astype(np.int32),
        SHORTEST * reach.max(),
        SLIM * spacing**2,
        met,
        parent,
        size,
        state,
    )
    root = parent
    while not np.array_equal(root, root[root]):
        root = root[root]
    owner = np.full(n, -1, np.int64)
    limb = state[root] == CLOSED
    owner[limb] = np.unique(root[limb], return_inverse=True)[1]
    return owner


def _filled(points: NDArray[np.float64], part: NDArray[np.int64]) -> NDArray[np.int64]:
    """Give points without a part that of the nearest point with one."""
    from scipy.spatial import cKDTree

    missing = np.flatnonzero(part < 0)
    if len(missing) == 0:
        return part
    known = np.flatnonzero(part >= 0)
    _, nearest = cKDTree(points[known]).query(points[missing])
    filled = part.copy()
    filled[missing] = part[known[np.asarray(nearest)]]
    return filled


def _numbered(
    points: NDArray[np.float64],
    part: NDArray[np.int64],
    trunks: NDArray[np.int64],
    reach: NDArray[np.float64],
) -> Limbs:
    """Number the parts by their size and measure them."""
    filled = _filled(points, part)
    found, place, sizes = np.unique(filled, return_inverse=True, return_counts=True)
    order = np.argsort(-sizes, kind="stable")
    rank = np.empty(len(order), np.int32)
    rank[order] = np.arange(len(order), dtype=np.int32)
    found = found[order]
    spans = Spans.of(points, part, reach)
    trunk = np.isin(found, trunks)
    width = np.maximum(spans.widths, np.finfo(float).tiny)
    with np.errstate(over="ignore"):  # a line has no width
        slimness = np.where(trunk, 0.0, (spans.lengths / width)[found])
    return Limbs(rank[place.reshape(-1)], trunk, sizes[order].astype(np.int64), slimness, reach)
