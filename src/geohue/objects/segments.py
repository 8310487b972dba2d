"""The segments of a scene one by one, and as a table."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geohue.errors import GeohueError
from geohue.objects.measured import Measured

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """One segment. All lengths and positions are in the unit and the frame of the scene.

    Attributes
    ----------
    id : int
        Its label.
    """

    id: int
    _all: Measured

    @property
    def area(self) -> int:
        """Number of its pixels or points."""
        return int(self._all.sums.area[self.id])

    @property
    def mask(self) -> NDArray[np.bool_]:
        """Which pixels or points are its own; bool, shape of the scene."""
        return np.asarray(self._all.labels == self.id)

    @property
    def indices(self) -> NDArray[np.int64]:
        """Flat positions of its pixels or points in the scene, in increasing order."""
        order, starts = self._all.order
        return np.asarray(order[starts[self.id] : starts[self.id + 1]])

    @property
    def points(self) -> NDArray[np.floating[Any]]:
        """The positions of its points, (n, 3); those without one are left out."""
        points = self._all.scene.points.reshape(-1, 3)[self.indices]
        points = points[np.isfinite(points[:, 2])]
        return points + self._all.offset if self._all.offset.any() else points

    @property
    def color(self) -> Floats:
        """Mean sRGB, (3,), 0 to 255."""
        return np.asarray(self._all.sums.color[self.id])

    @property
    def centroid(self) -> Floats:
        """Mean position, (3,); NaN where no point has one."""
        return np.asarray(self._all.sums.centroid[self.id] + self._all.offset)

    @property
    def box(self) -> Floats:
        """Axis-aligned box, (2, 3): lowest and highest coordinates."""
        return (
            np.stack([self._all.sums.low[self.id], self._all.sums.high[self.id]]) + self._all.offset
        )

    @property
    def oriented_box(self) -> tuple[Floats, Floats, Floats]:
        """Oriented box: centre (3,), lengths of its edges (3,), and their directions (3, 3), rows.

        One side lies along the plane of the segment; the last direction is the plane's normal.
        """
        boxes = self._all.boxes
        return boxes.center[self.id] + self._all.offset, boxes.size[self.id], boxes.axes[self.id]

    @property
    def corners(self) -> Floats:
        """The eight corners of the oriented box, (8, 3)."""
        return np.asarray(self._all.boxes.corners[self.id] + self._all.offset)

    @property
    def frame_box(self) -> tuple[int, int, int, int]:
        """First row and column, and last row and column, in the image.

        Raises
        ------
        GeohueError
            For a cloud without a grid.
        """
        _need_grid(self._all, "a box in the image")
        top, left, bottom, right = self._all.frame_boxes[self.id].tolist()
        return top, left, bottom, right

    @property
    def plane(self) -> tuple[Floats, float]:
        """The plane of least squares: unit normal n (3,) and offset d, for n . x = d."""
        normal = self._all.planes.normal[self.id]
        return normal, float(normal @ self.centroid)

    @property
    def plane_residual(self) -> float:
        """Root mean square distance from the plane."""
        return float(self._all.planes.residual[self.id])

    @property
    def quadric(self) -> Floats:
        """Coefficients of ``w = c0 + c1 u + c2 v + c3 u^2 + c4 u v + c5 v^2``, (6,).

        u, v and w run from the centroid along the rows of `plane_axes`.
        """
        return np.asarray(self._all.quadrics.coefficients[self.id])

    @property
    def quadric_residual(self) -> float:
        """Root mean square distance from the quadric, along the normal of the plane."""
        return float(self._all.quadrics.residual[self.id])

    @property
    def curvatures(self) -> Floats:
        """Principal curvatures of the quadric at its centre, (2,), the larger amount first."""
        return np.asarray(self._all.quadrics.curvatures[self.id])

    @property
    def plane_axes(self) -> Floats:
        """Rows: directions of most spread, of the next, and the normal; (3, 3)."""
        return np.asarray(self._all.planes.axes[self.id])

    @property
    def neighbours(self) -> dict[int, int]:
        """The segments that it touches, and the length of the border with each."""
        return self._all.neighbours.of(self.id)

    @property
    def touches_edge(self) -> bool:
        """Whether the edge of the frame may cut it off; False for a cloud."""
        return bool(self._all.at_edge[self.id])

    @property
    def stands_free(self) -> bool:
        """Whether it is away from the edge of the frame and in contact with no other segment."""
        return bool(self._all.stands_free[self.id])

    def __repr__(self) -> str:
        """Say what it is in a line."""
        place = ", ".join(f"{x:.3g}" for x in self.centroid)
        color = "#" + "".join(f"{round(c):02x}" for c in np.nan_to_num(self.color))
        return f"<Segment {self.id}: area {self.area}, centroid ({place}), colour {color}>"


class Segments(Sequence[Segment]):
    """The segments of a scene: a sequence of `Segment`, and their measures as arrays.

    Attributes
    ----------
    measured : Measured
        The measures of all segments: `Measured.sums`, `planes`, `quadrics`, `boxes`, `neighbours`.

    Examples
    --------
    >>> from geohue import Scene
    >>> depth = np.repeat([[1.0, 1.0, 3.0, 3.0]], 4, axis=0)
    >>> scene = Scene.from_rgbd(np.zeros((4, 4, 3), np.uint8), depth)
    >>> segments = Segments(Measured(scene, np.int32([[0, 0, 1, 1]] * 4)))
    >>> len(segments), segments[1].area, segments[1].neighbours, segments[1].centroid[2].item()
    (2, 8, {0: 4}, 3.0)
    """

    def __init__(self, measured: Measured) -> None:
        self.measured = measured

    def __len__(self) -> int:
        return self.measured.k

    @overload
    def __getitem__(self, at: int) -> Segment: ...
    @overload
    def __getitem__(self, at: slice) -> list[Segment]: ...
    def __getitem__(self, at: int | slice) -> Segment | list[Segment]:
        if isinstance(at, slice):
            return [Segment(i, self.measured) for i in range(*at.indices(len(self)))]
        return Segment(range(len(self))[at], self.measured)

    def __iter__(self) -> Iterator[Segment]:
        return (Segment(i, self.measured) for i in range(len(self)))

    def __repr__(self) -> str:
        """Say how many there are."""
        return f"<{len(self)} segments>"

    def at(self, u: float, v: float) -> Segment | None:
        """Return the segment at column `u` and row `v` of the image, None where there is none.

        Raises
        ------
        GeohueError
            Outside of the image, or for a cloud.
        """
        _need_grid(self.measured, "at(u, v)", "; near(xyz) finds one in space")
        height, width = self.measured.labels.shape
        column, row = round(u), round(v)
        if not (0 <= column < width and 0 <= row < height):
            raise GeohueError(f"({u}, {v}) lies outside of the image, {width} x {height}")
        label = int(self.measured.labels[row, column])
        return None if label < 0 else self[label]

    def near(self, xyz: ArrayLike) -> Segment:
        """Return the segment of the labelled point nearest to a position, (3,), in the scene.

        Raises
        ------
        GeohueError
            If the position is not three finite numbers, or no labelled point has one.
        """
        return self[int(self.measured.labels.reshape(-1)[nearest_point(self.measured, xyz)])]


def nearest_point(measured: Measured, xyz: ArrayLike) -> int:
    """Return the flat position of the labelled point nearest to a position in the scene."""
    here = np.asarray(xyz, np.float64)
    if here.shape != (3,) or not np.isfinite(here).all():
        raise GeohueError(f"{xyz!r} is no position: expected three finite numbers")
    away = measured.scene.points.reshape(-1, 3) - (here - measured.offset).astype(np.float32)
    distance = np.einsum("ni,ni->n", away, away)
    distance[(measured.labels.reshape(-1) < 0) | np.isnan(distance)] = np.inf
    nearest = int(distance.argmin()) if len(distance) else 0
    if len(distance) == 0 or not np.isfinite(distance[nearest]):
        raise GeohueError("no labelled point has a position: pick by pixel, with at(u, v)")
    return nearest


def _need_grid(measured: Measured, what: str, instead: str = "") -> None:
    if not measured.scene.is_grid:
        raise GeohueError(f"{what} needs an image: this scene is a cloud{instead}")


def table(segments: Segments) -> dict[str, NDArray[Any]]:
    """Return the measures of all segments, a column each, (K,).

    Lengths are in the unit of the scene, angles follow from the normals nx, ny, nz; columns that a
    cloud has not (top, left, bottom, right) are left out for it.
    """
    m = segments.measured
    sums, planes, boxes = m.sums, m.planes, m.boxes
    columns: dict[str, NDArray[Any]] = {"id": np.arange(m.k), "area": sums.area}
    columns["points"] = sums.placed
    if m.scene.is_grid:
        columns |= dict(zip(("top", "left", "bottom", "right"), m.frame_boxes.T, strict=True))
    vectors: dict[str, Floats] = {
        "": sums.centroid + m.offset,
        "low_": sums.low + m.offset,
        "high_": sums.high + m.offset,
        "box_": boxes.center + m.offset,
        "n": planes.normal,
    }
    for prefix, values in vectors.items():
        columns |= {prefix + axis: values[:, i] for i, axis in enumerate("xyz")}
    columns |= {f"box_{n}": boxes.size[:, i] for i, n in enumerate(("long", "wide", "thick"))}
    for a, name in enumerate("uvw"):
        columns |= {f"box_{name}{c}": boxes.axes[:, a, i] for i, c in enumerate("xyz")}
    columns["plane_residual"] = planes.residual
    columns["quadric_residual"] = m.quadrics.residual
    columns["curvature_1"], columns["curvature_2"] = m.quadrics.curvatures.T
    columns |= {name: sums.color[:, i] for i, name in enumerate(("red", "green", "blue"))}
    columns["neighbours"] = m.neighbours.degree()
    ends, length = m.neighbours.pairs.reshape(-1), np.repeat(m.neighbours.length, 2)
    columns["border"] = np.bincount(ends, length, m.k).astype(np.int64)
    columns["touches_edge"], columns["stands_free"] = m.at_edge, m.stands_free
    return columns


def frame(columns: dict[str, NDArray[Any]]) -> Any:
    """Return columns as a `pandas.DataFrame`, with the ids as its index."""
    try:
        import pandas
    except ImportError as error:
        raise GeohueError("a data frame needs pandas: pip install pandas") from error
    return pandas.DataFrame(columns).set_index("id")
