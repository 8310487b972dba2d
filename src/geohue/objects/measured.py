"""The measures of all segments of a scene as arrays, each made when it is first asked for."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.objects import loops
from geohue.objects.boxes import Boxes, oriented_boxes
from geohue.objects.graph import Neighbours, neighbours_of
from geohue.objects.surfaces import Planes, Quadrics, fit_planes, fit_quadrics
from geohue.scene import Scene

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Sums:
    """What one pass over the points tells of K segments.

    Attributes
    ----------
    area : (K,) int64
        Pixels or points.
    placed : (K,) int64
        Those among them that have a position.
    color : (K, 3) float64
        Mean sRGB, 0 to 255; NaN for a segment without points.
    centroid, low, high : (K, 3) float64
        Mean position and the axis-aligned box; NaN where no point has a position.
    """

    area: NDArray[np.int64]
    placed: NDArray[np.int64]
    color: Floats
    centroid: Floats
    low: Floats
    high: Floats


class Measured:
    """K segments of a scene, measured. Nothing is computed before it is asked for.

    Positions are those of the scene, less the offset of map coordinates, which `offset` has.

    Parameters
    ----------
    scene : Scene
        What was segmented.
    labels : (H, W) or (N,) int32
        Segment of each pixel or point, -1 = none.
    k : int, optional
        Number of segments; by default the highest label and one.
    pairs : ((E,), (E,)) int64, optional
        Flat positions of neighbouring points, where they are known already.

    Raises
    ------
    GeohueError
        If labels and scene differ in shape.

    Examples
    --------
    >>> scene = Scene.from_cloud([[0, 0, 0], [2, 0, 0], [9, 9, 9]], np.full((3, 3), 7, np.uint8))
    >>> found = Measured(scene, np.int32([0, 0, 1]))
    >>> found.sums.area.tolist(), found.sums.centroid[0].tolist()
    ([2, 1], [1.0, 0.0, 0.0])
    """

    def __init__(
        self,
        scene: Scene,
        labels: NDArray[np.int32],
        k: int | None = None,
        pairs: tuple[NDArray[np.int64], NDArray[np.int64]] | None = None,
    ) -> None:
        if labels.shape != scene.shape:
            raise GeohueError(f"labels have shape {labels.shape}, the scene {scene.shape}")
        self.scene = scene
        self.labels = np.ascontiguousarray(labels, np.int32)
        self.k = int(labels.max(initial=-1)) + 1 if k is None else k
        self.offset = np.asarray(scene.offset, np.float64)
        self._pairs = pairs
        self._flat = self.labels.reshape(-1)
        self._points = np.ascontiguousarray(scene.points.reshape(-1, 3), np.float32)

    @cached_property
    def sums(self) -> Sums:
        """Areas, mean colours, centroids and axis-aligned boxes."""
        k = self.k
        counts, color, place = np.zeros((k, 2), np.int64), np.zeros((k, 3)), np.zeros((k, 3))
        low, high = np.full((k, 3), np.inf), np.full((k, 3), -np.inf)
        colors = np.ascontiguousarray(self.scene.colors.reshape(-1, 3))
        loops.add_up(self._flat, self._points, colors, counts, color, place, low, high)
        area, placed = counts.T.copy()
        nowhere = placed == 0
        with np.errstate(invalid="ignore"):
            color, place = color / area[:, None], place / placed[:, None]
        low[nowhere], high[nowhere] = np.nan, np.nan
        return Sums(area, placed, color, place, low, high)

    @cached_property
    def planes(self) -> Planes:
        """The plane of each segment and how far its points are off it."""
        eye = None if self.scene.depth is None else np.zeros(3)
        return fit_planes(self._flat, self._points, self.sums.centroid, self.sums.placed, eye)

    @cached_property
    def quadrics(self) -> Quadrics:
        """The quadric over the plane of each segment."""
        return fit_quadrics(self._flat, self._points, self.planes, self.sums.placed)

    @cached_property
    def boxes(self) -> Boxes:
        """The oriented box of each segment."""
        return oriented_boxes(self._flat, self._points, self.planes)

    @cached_property
    def neighbours(self) -> Neighbours:
        """Which segments touch, along what length, and how they differ there."""
        normal, given = self.planes.normal, self.scene.normals
        if given is not None:  # these know on which side of a surface the outside is
            flat = np.nan_to_num(given.reshape(-1, 3).astype(np.float64))
            there = self._flat >= 0
            mean = [np.bincount(self._flat[there], flat[there, c], self.k) for c in range(3)]
            turned = (np.stack(mean, axis=1) * normal).sum(axis=1) < 0
            normal = np.where(turned[:, None], -normal, normal)
        signed = given is not None or self.scene.depth is not None
        here = self.scene, self.labels, self.k
        return neighbours_of(
            *here, self.sums.color, self.sums.centroid, normal, signed, self._pairs
        )

    @cached_property
    def frame_boxes(self) -> NDArray[np.int64]:
        """First row and column, last row and column of each segment of a grid, (K, 4)."""
        low = np.full((self.k, 2), np.iinfo(np.int64).max)
        high = np.full((self.k, 2), -1)
        loops.frame_box(self.labels, low, high)
        return np.concatenate([low, high], axis=1)

    @cached_property
    def at_edge(self) -> NDArray[np.bool_]:
        """Whether each segment touches the edge of the frame, (K,); never for a cloud."""
        edge = np.zeros(self.k + 1, bool)
        if self.scene.is_grid:
            for side in (self.labels[0], self.labels[-1], self.labels[:, 0], self.labels[:, -1]):
                edge[side] = True  # -1 is the last place, which is left out
        return edge[:-1]

    @cached_property
    def stands_free(self) -> NDArray[np.bool_]:
        """Whether nothing holds each segment, (K,).

        It does not touch the edge of the frame, and is in contact with no other segment: where it
        borders on others, depth jumps.
        """
        graph = self.neighbours
        held = np.bincount(graph.pairs.reshape(-1), np.repeat(graph.contact, 2), self.k)
        return np.asarray(~self.at_edge & (held == 0))

    @cached_property
    def order(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Positions of all points by segment, and where each segment begins among them, (K + 1,).

        Those without a segment are left out.
        """
        order = np.argsort(self._flat, kind="stable")
        starts = np.searchsorted(self._flat[order], np.arange(self.k + 1))
        return order, starts
