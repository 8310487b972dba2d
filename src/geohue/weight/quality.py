"""Sec. IV: the quality Q of a segmentation, from colour and geometry, without a reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.scene import Scene

Texture = Literal["auto", "window", "off"]
TEXTURES: tuple[Texture, ...] = get_args(Texture)

Norm = Literal["sum", "euclidean"]
NORMS: tuple[Norm, ...] = get_args(Norm)


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
    texture : {"auto", "window", "off"}
        How sigma_t (eq. 6) finds the local deviation: in 3 x 3 ``window`` of the grid, or not at
        all (``off``: sigma_t = 0). ``auto`` is the window for a grid and off for a cloud, which
        the paper allows as its faster form.
    norm : {"sum", "euclidean"}
        How the deviations and distances of the three channels become one number.

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

    def __init__(self, scene: Scene, texture: Texture = "auto", norm: Norm = "sum") -> None:
        if texture not in TEXTURES:
            raise GeohueError(f"texture {texture!r}: choose one of {', '.join(TEXTURES)}")
        if norm not in NORMS:
            raise GeohueError(f"norm {norm!r}: choose one of {', '.join(NORMS)}")
        if texture == "window" and not scene.is_grid:
            raise GeohueError('texture="window" needs a grid; use "off" for a cloud')
        self._norm = norm
        self._valid = scene.valid
        self._all_valid = bool(self._valid.all())
        self._colors = np.ascontiguousarray(scene.colors.reshape(-1, 3))
        self._geometry = _unit_geometry(scene, self._valid)
        self.geometry_factor = 1 if scene.depth is None else 3  # n_f of eq. 17
        if texture == "auto":
            texture = "window" if scene.is_grid else "off"
        self._local: NDArray[np.float32] | None = None
        if texture == "window":
            self._local = _window_deviation(scene.colors, norm)

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

        Raises
        ------
        GeohueError
            If the labels have another shape than the scene.
        """
        from geohue.weight import passes  # compiled code takes a moment to load

        used = self._used(labels)
        k = max(int(used.max(initial=-1)) + 1, 1)
        sizes, sums = np.zeros(k, np.int64), np.zeros((k, 3), np.int64)
        squares = np.zeros_like(sums)
        passes.add_colors(used.reshape(-1), self._colors, sizes, sums, squares)
        present = sizes > 0
        n = sizes[present]
        if len(n) < 2:
            return None
        texture = self._texture_deviation(used, k)[present]
        means = sums[present] / n[:, None]
        # The sums are whole numbers: a segment of one colour has a deviation of exactly 0.
        deviations = np.sqrt(np.maximum(squares[present] / n[:, None] - means**2, 0))
        color = self._part(means / 255, deviations / 255, n, texture)
        means, deviations = self._geometry_moments(used, sizes)
        geometry = self._part(means[present], deviations[present], n, np.zeros(len(n)))
        q_color = (color[0] - color[1]) / 2  # eq. 11
        q_geometry = (geometry[0] - geometry[1]) / 2  # eq. 16
        total = q_color + self.geometry_factor * q_geometry  # eq. 17
        return Quality(total, q_color, q_geometry, *color, *geometry)

    def _used(self, labels: NDArray[np.int32]) -> NDArray[np.int32]:
        """Return the labels, -1 where there is no geometry."""
        if labels.shape != self._valid.shape:
            raise GeohueError(
                f"labels: shape {labels.shape}; expected {self._valid.shape}, as the scene"
            )
        if not self._all_valid:
            labels = np.where(self._valid, labels, np.int32(-1))
        return np.ascontiguousarray(labels, np.int32)

    def _geometry_moments(
        self, used: NDArray[np.int32], sizes: NDArray[np.int64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Mean and deviation of the geometry of each segment, one column a channel."""
        from geohue.weight.passes import add_distances

        n = np.maximum(sizes, 1)[:, None]
        zeros = np.zeros((len(sizes), self._geometry.shape[1]))
        means, squares = zeros.copy(), zeros.copy()
        add_distances(used.reshape(-1), self._geometry, zeros, False, means)
        means /= n
        add_distances(used.reshape(-1), self._geometry, means, True, squares)
        return means, np.sqrt(squares / n)

    def _part(
        self,
        means: NDArray[np.float64],
        deviations: NDArray[np.float64],
        sizes: NDArray[np.int64],
        texture: NDArray[np.float64],
    ) -> tuple[float, float]:
        """Return the inter and intra disparity of one cue (eq. 7-10, 12-15)."""
        k = len(sizes)
        sigma = _combine(deviations, self._norm)
        intra = float((np.maximum(sigma - texture, 0) * sizes / sizes.sum()).sum())
        distance = _combine(np.abs(means[:, None] - means[None]), self._norm)
        return float(distance.sum() / (k * (k - 1))), intra

    def _texture_deviation(self, used: NDArray[np.int32], k: int) -> NDArray[np.float64]:
        """sigma_t of each segment: the mean local deviation over its interior (eq. 6)."""
        from geohue.weight.passes import add_texture

        total, count = np.zeros(k), np.zeros(k, np.int64)
        if self._local is None:
            return total
        interior = _window_interior(used)
        flat = used.reshape(-1), interior.reshape(-1), self._local.reshape(-1)
        add_texture(*flat, count, total)
        # A segment too thin to have an interior has no measurable texture.
        return np.asarray(total / np.maximum(count, 1))


def _combine(channels: NDArray[np.float64], norm: Norm) -> NDArray[np.float64]:
    if norm == "sum":
        return np.asarray(channels.sum(axis=-1))
    return np.asarray(np.sqrt((channels**2).sum(axis=-1)))


def _unit_geometry(scene: Scene, valid: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Depth map, or coordinates, shifted and scaled into 0..1: (n, 1) or (n, 3)."""
    values = (scene.points if scene.depth is None else scene.depth).reshape(scene.size, -1)
    known = values if valid.all() else values[valid.reshape(-1)]
    if len(known) == 0:
        return np.ascontiguousarray(values)
    low = known.min(axis=0)
    side = float((known.max(axis=0) - low).max())
    return np.ascontiguousarray((values - low) / (side or 1.0), np.float32)


def _window_deviation(colors: NDArray[np.uint8], norm: Norm) -> NDArray[np.float32]:
    """Standard deviation in the 3 x 3 window around each pixel, 0 on the frame."""
    from geohue.weight.passes import window_deviation

    height, width = colors.shape[:2]
    local = np.zeros((height, width), np.float32)
    if min(height, width) < 3:
        return local
    rows = np.ascontiguousarray(colors).reshape(height, -1)
    sums, squares = np.empty(3 * width, np.int32), np.empty(3 * width, np.int32)
    channels = np.empty(3 * width - 6, np.float32)
    window_deviation(rows, norm == "euclidean", sums, squares, channels, local)
    return local


def _window_interior(labels: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Whether the 3 x 3 window of a pixel lies in the image and in one segment."""
    from geohue.weight.passes import window_interior

    interior = np.zeros(labels.shape, bool)
    window_interior(np.ascontiguousarray(labels), interior)
    return interior
