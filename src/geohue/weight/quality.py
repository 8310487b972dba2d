"""Sec. IV: the quality Q of a segmentation, from colour and geometry, without a reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.scene import Scene

Texture = Literal["auto", "window", "radius", "off"]
TEXTURES: tuple[Texture, ...] = get_args(Texture)

Norm = Literal["sum", "euclidean"]
NORMS: tuple[Norm, ...] = get_args(Norm)

RADIUS_NEIGHBOURS = 12
"""The default radius of the texture term of a cloud reaches about this many neighbours."""


@dataclass(frozen=True, slots=True)
class Quality:
    """The parts of Q (eq. 17).

    Attributes
    ----------
    total : float
        Q of eq. 17: ``color + n_f * geometry``.
    color, geometry : float
        Eq. 11 and eq. 16.
    color_inter, color_intra, geometry_inter, geometry_intra : float
        Eq. 10, 8, 15, 13.
    """

    total: float
    color: float
    geometry: float
    color_inter: float
    color_intra: float
    geometry_inter: float
    geometry_intra: float


class QualityMetric:
    """The metric Q of eq. 6-17 for one scene, ready to score many segmentations of it.

    Only the un-weighted data enter: sRGB in 0..1, and the depth map in 0..1 (or the coordinates
    over the largest side of the bounding box, for a cloud). What does not depend on the labels
    is computed once.

    Parameters
    ----------
    scene : Scene
        Points without geometry are left out.
    texture : {"auto", "window", "radius", "off"}
        How sigma_t (eq. 6) finds the local deviation: in 3 x 3 ``window`` of the grid, among the
        neighbours within a ``radius`` in a cloud, or not at all (``off``: sigma_t = 0). ``auto``
        is the window for a grid and off for a cloud, which the paper allows as its faster form.
    norm : {"sum", "euclidean"}
        How the deviations and distances of the three channels become one number.
    radius : float, optional
        Of the neighbours, in the unit of the points. By default such that a cloud's typical
        point has about a dozen.

    Raises
    ------
    GeohueError
        For an unknown option, or a window on a cloud without a grid.

    Examples
    --------
    Two flat squares, black at 1 m and white at 2 m, split where they meet:

    >>> rgb = np.zeros((4, 8, 3), np.uint8)
    >>> rgb[:, 4:] = 255
    >>> depth = np.repeat([1.0, 2.0], 4)[None].repeat(4, 0)
    >>> metric = QualityMetric(Scene.from_rgbd(rgb, depth))
    >>> metric((depth > 1).astype(np.int32)).total      # (3 + 3 * 1) / 2
    3.0
    """

    def __init__(
        self,
        scene: Scene,
        texture: Texture = "auto",
        norm: Norm = "sum",
        radius: float | None = None,
    ) -> None:
        if texture not in TEXTURES:
            raise GeohueError(f"texture {texture!r}: choose one of {', '.join(TEXTURES)}")
        if norm not in NORMS:
            raise GeohueError(f"norm {norm!r}: choose one of {', '.join(NORMS)}")
        if texture == "window" and not scene.is_grid:
            raise GeohueError('texture="window" needs a grid; use "radius" or "off" for a cloud')
        self._shape = scene.shape
        self._norm = norm
        self._valid = scene.valid
        self._color = scene.colors[self._valid].astype(np.float32) / np.float32(255)
        self._geometry = _unit_geometry(scene, self._valid)
        self.geometry_factor = 1 if scene.depth is None else 3  # n_f of eq. 17
        if texture == "auto":
            texture = "window" if scene.is_grid else "off"
        self._texture = texture
        self._local: NDArray[np.float32] | None = None
        if texture == "window":
            self._local = _window_deviation(scene.colors, norm)[self._valid]
        elif texture == "radius":
            self._neighbours = _RadiusNeighbours(scene.points[self._valid], radius)
            self._local = self._neighbours.deviation(self._color, norm)

    def __call__(self, labels: NDArray[np.int32]) -> Quality | None:
        """Score a segmentation.

        Parameters
        ----------
        labels : (H, W) or (N,) int32
            Segment of each point of the scene, -1 for none.

        Returns
        -------
        Quality or None
            None if there are fewer than two segments: Q compares segments with each other.
        """
        used = labels[self._valid]
        seen = used >= 0
        counts = np.bincount(used[seen])
        present = np.flatnonzero(counts)
        if len(present) < 2:
            return None
        rank = np.zeros(len(counts), np.int64)
        rank[present] = np.arange(len(present))
        segment, sizes = rank[used[seen]], counts[present]
        texture = self._texture_deviation(labels, segment, seen, len(present))
        color = self._part(self._color[seen], segment, sizes, texture)
        geometry = self._part(self._geometry[seen], segment, sizes, np.zeros(len(present)))
        q_color = (color[0] - color[1]) / 2  # eq. 11
        q_geometry = (geometry[0] - geometry[1]) / 2  # eq. 16
        total = q_color + self.geometry_factor * q_geometry  # eq. 17
        return Quality(total, q_color, q_geometry, *color, *geometry)

    def _part(
        self,
        values: NDArray[np.float32],
        segment: NDArray[np.int64],
        sizes: NDArray[np.int64],
        texture: NDArray[np.float64],
    ) -> tuple[float, float]:
        """Return the inter and intra disparity of one cue (eq. 7-10, 12-15)."""
        k = len(sizes)
        means = np.empty((k, values.shape[1]))
        deviations = np.empty_like(means)
        for channel in range(values.shape[1]):
            v = values[:, channel].astype(np.float64)
            means[:, channel] = np.bincount(segment, v, k) / sizes
            v -= means[segment, channel]
            deviations[:, channel] = np.sqrt(np.bincount(segment, v * v, k) / sizes)
        sigma = _combine(deviations, self._norm)
        intra = float((np.maximum(sigma - texture, 0) * sizes / sizes.sum()).sum())
        distance = _combine(np.abs(means[:, None] - means[None]), self._norm)
        return float(distance.sum() / (k * (k - 1))), intra

    def _texture_deviation(
        self,
        labels: NDArray[np.int32],
        segment: NDArray[np.int64],
        seen: NDArray[np.bool_],
        k: int,
    ) -> NDArray[np.float64]:
        """sigma_t of each segment: the mean local deviation over its interior (eq. 6)."""
        if self._local is None:
            return np.zeros(k)
        if self._texture == "window":
            interior = _window_interior(np.where(self._valid, labels, -1))[self._valid]
        else:
            interior = self._neighbours.interior(labels[self._valid])
        inside = interior[seen]
        count = np.bincount(segment[inside], minlength=k)
        total = np.bincount(segment[inside], self._local[seen][inside].astype(np.float64), k)
        # A segment too thin to have an interior has no measurable texture.
        return np.asarray(total / np.maximum(count, 1))


def _combine(channels: NDArray[np.float64], norm: Norm) -> NDArray[np.float64]:
    if norm == "sum":
        return np.asarray(channels.sum(axis=-1))
    return np.asarray(np.sqrt((channels**2).sum(axis=-1)))


def _unit_geometry(scene: Scene, valid: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Depth map, or coordinates, shifted and scaled into 0..1."""
    values = scene.depth[valid][:, None] if scene.depth is not None else scene.points[valid]
    if len(values) == 0:
        return values
    low = values.min(axis=0)
    side = float((values.max(axis=0) - low).max())
    return np.asarray((values - low) / (side or 1.0), np.float32)


def _window_deviation(colors: NDArray[np.uint8], norm: Norm) -> NDArray[np.float32]:
    """Standard deviation in the 3 x 3 window around each pixel."""
    import cv2

    # Integers up to 2^24 are exact in float32, so that the difference below loses nothing.
    values = colors.astype(np.float32)
    total = cv2.boxFilter(values, cv2.CV_32F, (3, 3), normalize=False)
    squares = cv2.boxFilter(values * values, cv2.CV_32F, (3, 3), normalize=False)
    variance = np.maximum(9 * squares - total * total, 0) / np.float32(81 * 255**2)
    return np.asarray(_combine(np.sqrt(variance), norm), np.float32)


def _window_interior(labels: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Whether the 3 x 3 window of a pixel lies in the image and in one segment."""
    interior = np.zeros(labels.shape, bool)
    if min(labels.shape) < 3:
        return interior
    across = (labels[:, :-2] == labels[:, 1:-1]) & (labels[:, 1:-1] == labels[:, 2:])
    middle = labels[:, 1:-1]
    same = across[:-2] & across[1:-1] & across[2:]
    same &= (middle[:-2] == middle[1:-1]) & (middle[1:-1] == middle[2:])
    interior[1:-1, 1:-1] = same & (labels[1:-1, 1:-1] >= 0)
    return interior


class _RadiusNeighbours:
    """The points within a radius of each point of a cloud, as index pairs."""

    def __init__(self, points: NDArray[np.float32], radius: float | None) -> None:
        from scipy.spatial import cKDTree

        tree = cKDTree(points)
        if radius is None:
            reach, _ = tree.query(points, min(RADIUS_NEIGHBOURS + 1, len(points)))
            radius = float(np.median(np.atleast_2d(reach)[:, -1])) if len(points) > 1 else 0.0
        pairs = tree.query_pairs(radius, output_type="ndarray")
        self._a = np.concatenate([pairs[:, 0], pairs[:, 1]])
        self._b = np.concatenate([pairs[:, 1], pairs[:, 0]])
        self._n = len(points)

    def deviation(self, colors: NDArray[np.float32], norm: Norm) -> NDArray[np.float32]:
        count = 1 + np.bincount(self._a, minlength=self._n)
        channels = np.empty((self._n, 3))
        for c in range(3):
            v = colors[:, c].astype(np.float64)
            mean = (v + np.bincount(self._a, v[self._b], self._n)) / count
            square = (v * v + np.bincount(self._a, (v * v)[self._b], self._n)) / count
            channels[:, c] = np.sqrt(np.maximum(square - mean * mean, 0))
        return np.asarray(_combine(channels, norm), np.float32)

    def interior(self, labels: NDArray[np.int32]) -> NDArray[np.bool_]:
        other = np.bincount(self._a, labels[self._a] != labels[self._b], self._n)
        return np.asarray((other == 0) & (labels >= 0))
