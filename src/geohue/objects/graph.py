"""Which segments lie side by side, along what border, and how they differ."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.features.color import lab_of
from geohue.merge.normals import oriented_along
from geohue.regions.adjacency import adjacent_pixels, adjacent_points
from geohue.scene import Scene

Floats = NDArray[np.float64]
Positions = NDArray[np.int64]

JUMP = 0.02
"""Relative step of depth beyond which two pixels side by side do not touch in space."""

FAR = 4.0
"""Median distances of neighbours beyond which two points of a cloud do not touch."""


@dataclass(frozen=True, slots=True, eq=False)
class Neighbours:
    """The graph of B borders between K segments, as plain arrays.

    Attributes
    ----------
    n_segments : int
        K.
    pairs : (B, 2) int64
        The two segments of each border, the lower one first; sorted.
    length : (B,) int64
        Pairs of pixels that share a side, or of near points of a cloud, across the border.
    contact : (B,) int64
        Those among them whose points touch in space: depth does not jump between them.
    color_step : (B,) float64
        Distance of the mean colours, CIELab.
    normal_angle : (B,) float64
        Angle between the planes, 0 to 90 degrees; NaN where a segment has no plane.
    convexity : (B,) float64
        ``(n2 - n1) . d / |d|`` for normals that point out of the things and the way d between the
        centroids: positive along the edge of a box, negative where one thing stands on another, 0
        for one plane; NaN where a segment has no plane. Its sign is a guess for a cloud that came
        without normals.
    """

    n_segments: int
    pairs: Positions
    length: Positions
    contact: Positions
    color_step: Floats
    normal_angle: Floats
    convexity: Floats

    def of(self, segment: int) -> dict[int, int]:
        """Return the neighbours of a segment and the length of the border with each."""
        ends, length = self.pairs, self.length
        beside = (ends == segment).any(axis=1)
        others = ends[beside].sum(axis=1) - segment
        return dict(zip(others.tolist(), length[beside].tolist(), strict=True))

    def degree(self) -> Positions:
        """Return how many neighbours each segment has, (K,)."""
        return np.bincount(self.pairs.reshape(-1), minlength=self.n_segments)

    def edge_index(self) -> Positions:
        """Return both directions of each border, (2, 2 B), as PyTorch Geometric takes them."""
        return np.ascontiguousarray(np.concatenate([self.pairs, self.pairs[:, ::-1]]).T)

    def to_networkx(self) -> Any:
        """Return a `networkx.Graph` with the measures as attributes of its edges.

        Raises
        ------
        GeohueError
            If networkx is not installed.
        """
        try:
            import networkx
        except ImportError as error:
            raise GeohueError("a networkx graph needs networkx: pip install networkx") from error
        graph = networkx.Graph()
        graph.add_nodes_from(range(self.n_segments))
        names = ("length", "contact", "color_step", "normal_angle", "convexity")
        rows = zip(*(getattr(self, name).tolist() for name in names), strict=True)
        for pair, row in zip(self.pairs.tolist(), rows, strict=True):
            graph.add_edge(*pair, **dict(zip(names, row, strict=True)))
        return graph


def neighbours_of(
    scene: Scene,
    labels: NDArray[np.int32],
    k: int,
    color: Floats,
    centroid: Floats,
    normal: Floats,
    signed: bool = False,
    pairs: tuple[Positions, Positions] | None = None,
) -> Neighbours:
    """Find the borders between segments.

    Parameters
    ----------
    scene : Scene
        What was segmented.
    labels : shape of the scene, int32
        Segments 0..k-1, -1 = none.
    k : int
        How many.
    color, centroid, normal : (k, 3) float64
        Mean sRGB, mean position and unit normal of each; NaN where unknown.
    signed : bool
        Whether the normals point out of the things. If not, neighbours that turn little agree, and
        most point away from the middle: a guess.
    pairs : ((E,), (E,)) int64, optional
        Pairs of neighbouring points, where they are known already.

    Returns
    -------
    Neighbours

    Examples
    --------
    >>> scene = Scene.from_rgbd(np.zeros((2, 4, 3), np.uint8), np.ones((2, 4)))
    >>> nothing = np.full((2, 3), np.nan)
    >>> graph = neighbours_of(scene, np.int32([[0, 0, 1, 1]] * 2), 2, nothing, nothing, nothing)
    >>> graph.pairs.tolist(), graph.length.tolist(), graph.contact.tolist()
    ([[0, 1]], [2], [2])
    """
    one, other, touching = _border_pairs(scene, labels.reshape(-1), pairs)
    flat = labels.reshape(-1)
    a, b = flat[one].astype(np.int64), flat[other].astype(np.int64)
    keys, place = np.unique(np.minimum(a, b) * k + np.maximum(a, b), return_inverse=True)
    ends = np.stack([keys // max(k, 1), keys % max(k, 1)], axis=1)
    length = np.bincount(place, minlength=len(keys))
    contact = np.bincount(place, touching, len(keys)).astype(np.int64)
    return Neighbours(
        k, ends, length, contact, *_differences(ends, color, centroid, normal, signed)
    )


def _border_pairs(
    scene: Scene, flat: NDArray[np.int32], pairs: tuple[Positions, Positions] | None
) -> tuple[Positions, Positions, NDArray[np.bool_]]:
    """Pairs of neighbours with two labels, and which of them touch in space."""
    if pairs is None:
        pairs = adjacent_pixels(scene.shape) if scene.is_grid else adjacent_points(scene)
    one, other = pairs
    points = scene.points.reshape(-1, 3)
    apart = np.flatnonzero((flat[one] != flat[other]) & (flat[one] >= 0) & (flat[other] >= 0))
    first, second = one[apart], other[apart]
    if scene.depth is not None:
        near, far = points[first, 2], points[second, 2]
        with np.errstate(invalid="ignore"):
            return first, second, np.abs(near - far) < JUMP * np.minimum(near, far)
    some = slice(None, None, max(1, len(one) // 10_000))
    with np.errstate(invalid="ignore"):
        usual = _distance(points, one[some], other[some])
        usual = usual[usual > 0]
        limit = FAR * float(np.median(usual)) if len(usual) else np.inf
        return first, second, _distance(points, first, second) <= limit


def _distance(points: NDArray[np.float32], one: Positions, other: Positions) -> Floats:
    """Distances between pairs of points; their squares may be more than float32 holds."""
    return np.asarray(np.linalg.norm(points[one].astype(np.float64) - points[other], axis=1))


def _differences(
    ends: Positions, color: Floats, centroid: Floats, normal: Floats, signed: bool
) -> tuple[Floats, Floats, Floats]:
    """Steps of colour, angles and convexities across borders."""
    one, other = ends.T
    unit = lab_of(np.nan_to_num(color).round().astype(np.uint8)).astype(np.float64)
    step = np.sqrt(((unit[one] - unit[other]) ** 2).sum(axis=1))
    cosine = np.abs((normal[one] * normal[other]).sum(axis=1))
    angle = np.degrees(np.arccos(np.minimum(cosine, 1.0)))
    if not signed and len(ends):
        normal = -oriented_along(np.nan_to_num(centroid), np.nan_to_num(normal), one, other)
        normal[np.isnan(centroid[:, 0]) | ~normal.any(axis=1)] = np.nan
    away = centroid[other] - centroid[one]
    with np.errstate(invalid="ignore", divide="ignore"):
        turn = ((normal[other] - normal[one]) * away).sum(axis=1)
        convexity = turn / np.sqrt((away**2).sum(axis=1))
    return step, angle, convexity
