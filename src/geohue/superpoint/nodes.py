"""The points of a scene as a graph: places, which lie side by side, and what is known of each."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from geohue.compute.parallel import Workers, cores, workers
from geohue.errors import GeohueError
from geohue.features import lab_of
from geohue.regions.adjacency import adjacent_pixels, nearest_known
from geohue.regions.groups import join_pairs
from geohue.scene import Scene
from geohue.superpoint import loops

Floats = NDArray[np.float64]
Positions = NDArray[np.int64]

NEIGHBOURS = 8
"""Nearest points that a point of a cloud lies beside."""

FAR = 4.0
"""Typical distances of neighbours beyond which two points of a cloud do not lie side by side."""

_BLOCK = 65_536

ROUNDS = 2
"""How often what is known of the surface around a point is added up over its neighbours."""


@dataclass(frozen=True, slots=True, eq=False)
class Nodes:
    """M places of a scene and which of them lie side by side.

    Attributes
    ----------
    node : (size,) int64
        The node that each point of the scene counts as, -1 = none.
    points : (M, 3) float64
        Positions around their mean.
    lab : (M, 3) float64
        CIELab; zeros where colour takes no part.
    normals : (M, 3) float64
        Unit normals of either sign; zeros where geometry takes no part.
    one, other : (E,) int64
        Pairs of neighbours, each once.
    spacing : float
        Typical distance of neighbours.
    weight : (M,) float64
        How many points of the scene count as each node.
    first : (M,) int64
        The flat position of one of these points.
    """

    node: Positions
    points: Floats
    lab: Floats
    normals: Floats
    one: Positions
    other: Positions
    spacing: float
    weight: Floats
    first: Positions

    @property
    def size(self) -> int:
        """Number of nodes."""
        return len(self.points)


def nodes_of(scene: Scene, cues: str, threads: int | None = None) -> Nodes:
    """Make the graph of a scene.

    Parameters
    ----------
    scene : Scene
        A frame or a cloud.
    cues : {"fusion", "color", "geometry"}
        What takes part.
    threads : int, optional
        For the search of neighbours; by default one a core.

    Returns
    -------
    Nodes

    Raises
    ------
    GeohueError
        If no point has a position where geometry takes part, or for a cloud.
    """
    with workers(threads) as team:
        if scene.is_grid:
            return _grid(scene, cues, team)
        return _cloud(scene, cues, team, cores() if threads is None else threads)


def _grid(scene: Scene, cues: str, team: Workers) -> Nodes:
    """Pixels, those in gaps as the nearest one with a position."""
    one, other = adjacent_pixels(scene.shape)
    lab = _lab(scene.colors.reshape(-1, 3), cues)
    if cues == "color":
        y, x = np.indices(scene.shape).reshape(2, -1).astype(np.float64)
        points, normals = np.stack([x, y, 0 * x], axis=1), np.zeros((scene.size, 3))
    else:
        if not scene.valid.any():
            raise GeohueError('no point has a position: superpoints by colour alone, cues="color"')
        near = nearest_known(scene.valid)
        points = scene.points.reshape(-1, 3)[near.reshape(-1)].astype(np.float64)
        close = _without_jumps(points, scene.depth is not None, one, other)
        points -= points.mean(axis=0)
        normals = _normals(points, *loops.csr(*close, len(points)), team)
    spacing = _typical(points, one, other)
    every = np.arange(scene.size)
    ones = np.ones(scene.size)
    return Nodes(every, points, lab, normals, one, other, spacing, ones, every)


def _cloud(scene: Scene, cues: str, team: Workers, threads: int) -> Nodes:
    index = np.flatnonzero(scene.valid)
    if len(index) == 0:
        raise GeohueError("no point has a position: check the cloud")
    points = scene.points[index].astype(np.float64)
    points -= points.mean(axis=0)
    found = nodes_of_places(points, scene.colors[index], cues, team, threads)
    node = np.full(scene.size, -1, np.int64)
    node[index] = found.node
    return replace(found, node=node, first=index[found.first])


def nodes_of_places(
    points: Floats,
    colors: NDArray[np.uint8],
    cues: str,
    team: Workers,
    threads: int,
    spacing: float | None = None,
) -> Nodes:
    """Make the graph of points that all have a position, near the origin.

    The nodes are in the order of a space-filling curve: near ones lie near in memory.

    Parameters
    ----------
    points : (n, 3) float64
        Positions.
    colors : (n, 3) uint8
        sRGB.
    cues : {"fusion", "color", "geometry"}
        What takes part.
    team : Workers
        For the normals.
    threads : int
        For the search of neighbours.
    spacing : float, optional
        Typical distance of neighbours; that of these points by default.
    """
    index, new = in_order(points)
    points = points[index]
    place = np.cumsum(new) - 1
    node = np.empty(len(index), np.int64)
    node[index] = place
    count = np.bincount(place).astype(np.float64)
    lab = _lab(colors[index], cues)
    if len(count) < len(index):
        lab = np.stack([np.bincount(place, lab[:, c]) for c in range(3)], axis=1) / count[:, None]
    points = np.ascontiguousarray(points[new])
    one, other, spacing = near_pairs(points, threads, spacing)
    if cues == "color":
        normals = np.zeros_like(points)
    else:
        normals = _normals(points, *loops.csr(one, other, len(points)), team)
    return Nodes(node, points, lab, normals, one, other, spacing, count, index[new])


def in_order(points: Floats) -> tuple[Positions, NDArray[np.bool_]]:
    """Return points in the order of a curve, and at which of them a new place begins."""
    order = np.argsort(loops.curve(points), kind="stable")
    ordered = points[order]
    return order, np.append(True, (ordered[1:] != ordered[:-1]).any(axis=1))


def near_pairs(
    points: Floats, threads: int = 1, spacing: float | None = None
) -> tuple[Positions, Positions, float]:
    """Pair each of some different places with its nearest, and tell their typical distance.

    Returns
    -------
    one, other : (E,) int64
        Each pair once.
    spacing : float
        As given, or the median distance to the third nearest.
    """
    from scipy.spatial import cKDTree

    n = len(points)
    k = min(NEIGHBOURS + 1, n)
    tree = cKDTree(points, balanced_tree=False, compact_nodes=False)
    found = tree.query(points, [*range(1, k + 1)], workers=threads)
    distance, near = np.asarray(found[0]), np.asarray(found[1], np.int64)
    if spacing is None:
        spacing = float(np.median(distance[:, min(3, k - 1)])) or 1.0
    room = np.empty((n * k, 2), np.int64)
    count = loops.pair_up(near, distance, FAR * spacing, room)
    one, other = np.ascontiguousarray(room[:count].T)
    return one, other, spacing


def with_crumbs(nodes: Nodes, least: float) -> Nodes:
    """Pair each piece of less than `least` points with the nearest point of a larger one."""
    from scipy.spatial import cKDTree

    piece = join_pairs(nodes.one, nodes.other, nodes.size)
    small = np.bincount(piece, nodes.weight)[piece] < least
    if not small.any() or small.all():
        return nodes
    lost, ground = np.flatnonzero(small), np.flatnonzero(~small)
    distance, near = cKDTree(nodes.points[ground]).query(nodes.points[lost])
    order = np.lexsort((np.asarray(distance), piece[lost]))
    _, first = np.unique(piece[lost][order], return_index=True)
    ends = lost[order][first], ground[np.asarray(near)[order][first]]
    one, other = (
        np.append(side, end) for side, end in zip((nodes.one, nodes.other), ends, strict=True)
    )
    return replace(nodes, one=one, other=other)


def _lab(colors: NDArray[np.uint8], cues: str) -> Floats:
    if cues == "geometry":
        return np.zeros(colors.shape)
    return lab_of(colors).astype(np.float64)


def _typical(points: Floats, one: Positions, other: Positions) -> float:
    some = slice(None, None, max(1, len(one) // 50_000))
    length = np.sqrt(((points[one[some]] - points[other[some]]) ** 2).sum(axis=1))
    length = length[length > 0]
    return float(np.median(length)) if len(length) else 1.0


def _without_jumps(
    points: Floats, seen: bool, one: Positions, other: Positions
) -> tuple[Positions, Positions]:
    """Leave out the pairs of pixels between which depth jumps: they span no surface.

    Where a camera sees the points, the distance of two pixels grows with their depth.
    """
    away = np.sqrt(((points[one] - points[other]) ** 2).sum(axis=1))
    if seen:
        away = away / np.minimum(points[one, 2], points[other, 2])
    real = away[away > 0]
    close = away <= FAR * (float(np.median(real)) if len(real) else 1.0)
    return one[close], other[close]


def _normals(points: Floats, start: Positions, beside: Positions, team: Workers) -> Floats:
    """Across the direction of least spread of a point's neighbours and of theirs."""
    n, normals = len(points), np.zeros_like(points)
    sums, into = np.empty((n, 10)), np.empty((n, 10))
    loops.moments(points, sums)

    def gather(rows: slice) -> None:
        loops.gather(sums, start, beside, into, rows.start, rows.stop)

    def least_spread(rows: slice) -> None:
        loops.least_spread(sums, normals, np.empty(6), rows.start, rows.stop)

    for _ in range(ROUNDS):
        list(team.map_blocks(gather, n, _BLOCK))
        sums, into = into, sums
    list(team.map_blocks(least_spread, n, _BLOCK))
    return normals
