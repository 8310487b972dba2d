"""The surface that a range sensor sees: samples of it, and its depth seen from a camera.

A range sensor sees every point that it measures. Its points are therefore a map from directions to
distances, and the surface between neighbouring directions is what can hide a point from a camera.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.sensors.lens import Lens
from geohue.sensors.rig import PosedCamera

JUMP = 0.03
"""Relative difference of depth beyond which neighbouring pixels lie on two surfaces."""

_DENSEST = 15  # samples a side that stand for one pixel of the sensor
_KEPT = 10_000_000  # samples that are kept from the first pass for the second
_MAX_CELLS = 1 << 22
_MAX_PIXELS = 1 << 27
_FINEST, _COARSEST = np.radians(0.02), np.radians(2.0)

Floats = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Directions of a range sensor, on a grid, and the distance along each.

    Attributes
    ----------
    rays : (H, W, 3) float32
        Direction of each pixel or cell, at z = 1 or of length 1.
    scale : (H, W) float32
        The point is ``scale * ray``; NaN where there is none.
    """

    rays: Floats
    scale: Floats

    @classmethod
    def from_depth(cls, depth: Floats, lens: Lens) -> Surface:
        """Make the surface of a depth map (NaN where missing)."""
        height, width = depth.shape
        rays = lens.scaled_to(width, height).rays(height, width)
        scale = np.where(np.isfinite(rays[..., 0]), depth, np.nan)
        return cls(np.nan_to_num(rays), np.asarray(scale, np.float32))

    @classmethod
    def from_grid(cls, points: Floats) -> Surface:
        """Make the surface of an organised cloud (H, W, 3) in its camera's frame, z forward.

        The directions of missing points are taken from their neighbours: no sample comes of them.
        """
        depth: Floats = np.where(points[..., 2] > 0, points[..., 2], np.float32(np.nan))
        with np.errstate(all="ignore"):
            rays = np.asarray(points / depth[..., None], np.float32)
        known: NDArray[np.bool_] = np.asarray(np.isfinite(rays).all(axis=-1))
        rays = _nearest(rays, known)
        rays[..., 2] = 1
        return cls(rays, np.where(known, depth, np.nan).astype(np.float32))

    @classmethod
    def from_scan(cls, points: Floats) -> Surface:
        """Make the surface of scattered points of a scanner at the origin (x right, z forward).

        The points fall into cells as wide as most of them are apart; the nearest of a cell
        counts. Empty cells up to three away take the distance of the nearest full one.
        """
        distance = np.linalg.norm(points, axis=1).astype(np.float32)
        use = np.isfinite(distance) & (distance > 0)
        points, distance = points[use], distance[use]
        if len(points) == 0:
            return cls(np.ones((1, 1, 3), np.float32), np.full((1, 1), np.nan, np.float32))
        azimuth = np.arctan2(points[:, 0], points[:, 2])
        elevation = np.arcsin(np.clip(points[:, 1] / distance, -1, 1))
        angles = np.stack([elevation, azimuth], axis=1).astype(np.float64)
        step = _spacing(angles)
        low, high = angles.min(axis=0), angles.max(axis=0)
        rows, columns = (int(n) for n in np.ceil((high - low) / step).astype(int) + 1)
        place = np.rint((angles - low) / step).astype(np.int64)
        cells = np.full(rows * columns, np.inf, np.float32)
        np.minimum.at(cells, place[:, 0] * columns + place[:, 1], distance)
        scale = _grown(cells.reshape(rows, columns), 3)
        el = low[0] + step * np.arange(rows)[:, None]
        az = low[1] + step * np.arange(columns)[None]
        rays = np.stack(
            [np.cos(el) * np.sin(az), np.sin(el) + 0 * az, np.cos(el) * np.cos(az)], axis=-1
        )
        return cls(rays.astype(np.float32), scale)

    def samples(self, density: int) -> Iterator[Floats]:
        """Yield `density` x `density` samples of each pixel, an (N, 3) array for each.

        Between pixels of one surface the inverse distance is interpolated, so that planes stay
        planes; at its border each pixel is a flat piece at its own distance. An odd density has
        the pixels' own points among its samples.
        """
        inverse = np.pad(np.asarray(1 / self.scale, np.float32), 1, mode="edge")
        rays = np.pad(self.rays, ((1, 1), (1, 1), (0, 0)), mode="edge")
        steps = (np.arange(density) + 0.5) / density - 0.5
        for dy in steps:
            for dx in steps:
                mixed, level = _mixed(inverse, dx, dy)
                own = inverse[1:-1, 1:-1]
                with np.errstate(all="ignore"):
                    scale = 1 / np.where(level, mixed, own)
                direction = np.zeros_like(self.rays)
                for weight, part in _corners(rays, dx, dy):
                    direction += weight * part
                use = np.isfinite(scale)
                yield np.asarray(direction[use] * scale[use][:, None], np.float32)

    def seen_from(self, camera: PosedCamera, height: int, width: int) -> Floats:
        """Return the depth of the surface in a camera's picture.

        Parameters
        ----------
        camera : PosedCamera
            Where it is seen from; its intrinsics are those of a picture of this size.
        height, width : int
            Size of the picture.

        Returns
        -------
        (height, width) float32
            Distance along the camera's optical axis of the foremost surface; NaN where the
            sensor saw none.
        """
        if not 0 < height * width <= _MAX_PIXELS:
            raise GeohueError(f"a picture of {width} x {height} pixels: at most {_MAX_PIXELS}")
        density = self._density(camera, height, width)
        front = np.full(height * width, np.inf, np.float32)
        keep = self.scale.size * density**2 <= _KEPT
        landed = []
        for points in self.samples(density):
            landing = _landed(camera, points, height, width)
            np.minimum.at(front, landing[0], landing[2])
            if keep:
                landed.append(landing)
        again = landed or (_landed(camera, p, height, width) for p in self.samples(density))
        # Of the samples on the foremost surface, the one nearest to the pixel's centre: key in
        # the high half, the depth's own bits in the low half.
        best = np.full(height * width, np.iinfo(np.uint64).max, np.uint64)
        for pixel, off, z in again:
            use = z <= front[pixel] * (1 + JUMP)
            key = off[use].view(np.uint32).astype(np.uint64) << np.uint64(32)
            np.minimum.at(best, pixel[use], key | z[use].view(np.uint32).astype(np.uint64))
        depth = (best & np.uint64(0xFFFFFFFF)).astype(np.uint32).view(np.float32)
        depth[~np.isfinite(front)] = np.nan
        return depth.reshape(height, width)

    def gap(self, camera: PosedCamera, height: int, width: int, quantile: float = 0.5) -> float:
        """Return how many pixels of a camera's picture lie between neighbouring points."""
        shape = (*self.scale.shape, 2)
        points = (self.rays * self.scale[..., None]).reshape(-1, 3)
        pixels = camera.lens.project(camera.transform(points)).reshape(shape)
        with np.errstate(invalid="ignore"):
            pixels[((pixels < 0) | (pixels > (width, height))).any(axis=-1)] = np.nan
        inverse = 1 / self.scale
        gaps = []
        for axis in (0, 1):
            near, far = _beside(inverse, axis)
            level = np.abs(near - far) <= JUMP * np.minimum(near, far)
            before, after = _beside(pixels, axis)
            gaps.append(np.linalg.norm(before - after, axis=-1)[level])
        gap = np.concatenate(gaps)
        gap = gap[np.isfinite(gap)]
        return float(np.quantile(gap, quantile)) if gap.size else 1.0

    def _density(self, camera: PosedCamera, height: int, width: int) -> int:
        """Return how many samples a side leave no gap between them in the camera's picture."""
        wanted = int(np.ceil(1.5 * self.gap(camera, height, width, 0.98)))
        return min(wanted + 1 - wanted % 2, _DENSEST)


def _beside(grid: NDArray[np.floating[Any]], axis: int) -> tuple[Floats, Floats]:
    """Return each cell and its neighbour along an axis, as two arrays."""
    near, far = (grid[:-1], grid[1:]) if axis == 0 else (grid[:, :-1], grid[:, 1:])
    return np.asarray(near, np.float32), np.asarray(far, np.float32)


def _landed(
    camera: PosedCamera, points: Floats, height: int, width: int
) -> tuple[NDArray[np.int64], Floats, Floats]:
    """Return the pixel, the distance from its centre and the depth of the points in view."""
    there = camera.transform(points)
    place = camera.lens.project(there)
    x, y = place[:, 0], place[:, 1]
    with np.errstate(invalid="ignore"):
        inside = (x > -0.5) & (x < width - 0.5) & (y > -0.5) & (y < height - 0.5)
    x, y, z = x[inside], y[inside], there[inside, 2]
    column, row = np.rint(x), np.rint(y)
    off = (x - column) ** 2 + (y - row) ** 2
    return row.astype(np.int64) * width + column.astype(np.int64), off, z


def _corners(padded: Floats, dx: float, dy: float) -> list[tuple[np.float32, Floats]]:
    """Return the four pixels around each pixel moved by (dx, dy), with bilinear weights."""
    height, width = padded.shape[0] - 2, padded.shape[1] - 2
    sx, sy = (1 if dx >= 0 else -1), (1 if dy >= 0 else -1)
    ax, ay = abs(dx), abs(dy)
    corners = []
    for oy, wy in ((0, 1 - ay), (sy, ay)):
        for ox, wx in ((0, 1 - ax), (sx, ax)):
            if wx * wy > 0:
                part = padded[1 + oy : 1 + oy + height, 1 + ox : 1 + ox + width]
                corners.append((np.float32(wx * wy), part))
    return corners


def _mixed(inverse: Floats, dx: float, dy: float) -> tuple[Floats, NDArray[np.bool_]]:
    """Interpolate, and tell where all that was mixed lies on one surface."""
    corners = _corners(inverse, dx, dy)
    mixed = np.zeros_like(corners[0][1])
    low, high = corners[0][1].copy(), corners[0][1].copy()
    for weight, part in corners:
        mixed += weight * part
        np.minimum(low, part, out=low)  # NaN spreads: a missing corner is no surface
        np.maximum(high, part, out=high)
    with np.errstate(invalid="ignore"):
        return mixed, high <= low * (1 + JUMP)


def _nearest(values: Floats, known: NDArray[np.bool_]) -> Floats:
    """Fill unknown cells with the nearest known one."""
    from scipy.ndimage import distance_transform_edt

    if not known.any():
        return np.nan_to_num(values).astype(np.float32)
    index = distance_transform_edt(~known, return_distances=False, return_indices=True)
    return np.asarray(values[tuple(np.asarray(index))], np.float32)


def _grown(cells: Floats, reach: float) -> Floats:
    """Give empty (infinite) cells the value of the nearest full one within reach, else NaN."""
    from scipy.ndimage import distance_transform_edt

    far, index = distance_transform_edt(~np.isfinite(cells), return_indices=True)
    grown = cells[tuple(np.asarray(index))]
    return np.where(np.asarray(far) <= reach, grown, np.nan).astype(np.float32)


def _spacing(angles: NDArray[np.float64]) -> float:
    """Return how far apart most directions are, within limits that keep the grid small."""
    from scipy.spatial import cKDTree

    if len(angles) < 2:
        return float(_COARSEST)
    some = angles[:: max(1, len(angles) // 5000)]
    near, _ = cKDTree(angles).query(some, k=2)
    step = float(np.clip(np.median(np.asarray(near)[:, 1]), _FINEST, _COARSEST))
    extent = np.ptp(angles, axis=0)
    while np.prod(extent / step + 2) > _MAX_CELLS:
        step *= 1.5
    return step
