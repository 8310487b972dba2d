"""The plane and the quadric that fit each segment best."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.objects import loops

Floats = NDArray[np.float64]

LEAST = 1e-9
"""Share of the largest eigenvalue of the normal equations below which a term is not determined."""


@dataclass(frozen=True, slots=True, eq=False)
class Planes:
    """The plane of least squares of each segment.

    Attributes
    ----------
    center : (K, 3) float64
        A point of the plane: the centroid.
    normal : (K, 3) float64
        Of unit length, to the side of the camera of a frame, away from the middle of a cloud. NaN
        where fewer than 3 points have a position.
    axes : (K, 3, 3) float64
        Rows: the direction of most spread, the next, and the normal; a right-handed frame, the unit
        matrix where there are too few points.
    spread : (K, 3) float64
        Standard deviation along each axis.
    """

    center: Floats
    normal: Floats
    axes: Floats
    spread: Floats

    @property
    def residual(self) -> Floats:
        """Root mean square distance of the points from the plane, (K,)."""
        return np.where(np.isnan(self.normal[:, 0]), np.nan, self.spread[:, 2])


def fit_planes(
    labels: NDArray[np.int32],
    points: NDArray[np.float32],
    center: Floats,
    placed: NDArray[np.int64],
    eye: Floats | None = None,
) -> Planes:
    """Fit a plane to each segment: through its centroid, across the direction of least spread.

    Normals point towards `eye` (3,), without it away from the middle of all segments.

    Examples
    --------
    >>> points = np.float32([[0, 0, 2], [1, 0, 2], [0, 1, 2], [1, 1, 2]])
    >>> planes = fit_planes(np.zeros(4, np.int32), points, np.array([[0.5, 0.5, 2]]), np.array([4]),
    ...                     np.zeros(3))
    >>> (planes.normal + 0.0).tolist(), planes.residual.tolist()
    ([[0.0, 0.0, -1.0]], [0.0])
    """
    sums = np.zeros((len(center), 6))
    loops.add_spread(labels, points, center, sums)
    sums /= np.maximum(placed, 1)[:, None]
    matrix = sums[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(-1, 3, 3)
    values, vectors = np.linalg.eigh(matrix)
    axes = vectors.transpose(0, 2, 1)[:, ::-1]
    known = placed >= 3
    middle = center[known].mean(axis=0) if known.any() else np.zeros(3)
    back = middle - center if eye is None else center - eye
    turned = (axes[:, 2] * np.nan_to_num(back)).sum(axis=1) > 0
    axes[turned, 2] *= -1
    axes[:, 1] = np.cross(axes[:, 2], axes[:, 0])
    axes[~known] = np.eye(3)
    normal = np.where(known[:, None], axes[:, 2], np.nan)
    return Planes(center, normal, axes, np.sqrt(np.maximum(values[:, ::-1], 0.0)))


@dataclass(frozen=True, slots=True, eq=False)
class Quadrics:
    """A quadric over the plane of each segment.

    ``w = c0 + c1 u + c2 v + c3 u^2 + c4 u v + c5 v^2``, where u, v and w are coordinates from the
    centre of the plane along its axes.

    Attributes
    ----------
    coefficients : (K, 6) float64
        NaN where fewer than 6 points have a position.
    residual : (K,) float64
        Root mean square distance of the points from it, along the normal of the plane.
    """

    coefficients: Floats
    residual: Floats

    @property
    def curvatures(self) -> Floats:
        """The two principal curvatures at the centre, by amount, the larger first; (K, 2).

        Negative where the segment bulges along the normal, one over the radius of a ball.
        """
        _, p, q, a, b, c = self.coefficients.T
        slope = 1 + p**2 + q**2
        e, f, g = 1 + p**2, p * q, 1 + q**2
        mean = (2 * a * g - 2 * b * f + 2 * c * e) / (2 * slope**1.5)
        gauss = (4 * a * c - b**2) / slope**2
        root = np.sqrt(np.maximum(mean**2 - gauss, 0.0))
        sign = np.where(mean < 0, -1.0, 1.0)
        return np.stack([mean + sign * root, mean - sign * root], axis=1)


def fit_quadrics(
    labels: NDArray[np.int32],
    points: NDArray[np.float32],
    planes: Planes,
    placed: NDArray[np.int64],
) -> Quadrics:
    """Fit a quadric over each segment's plane by least squares.

    Terms that the points do not determine, as across a line of points, are 0.
    """
    k = len(placed)
    unit = np.where(planes.spread[:, 0] > 0, planes.spread[:, 0], 1.0)
    normal, right = np.zeros((k, loops.TERMS, loops.TERMS)), np.zeros((k, loops.TERMS))
    square, room = np.zeros(k), np.zeros(loops.TERMS)
    frame = planes.center, planes.axes, unit
    loops.add_quadric(labels, points, *frame, normal, right, square, room)
    normal += np.tril(normal, -1).transpose(0, 2, 1)
    found = (np.linalg.pinv(normal, rcond=LEAST, hermitian=True) @ right[..., None])[..., 0]
    # ||w - A c||^2 = w.w - 2 c.A'w + c'A'A c
    error = square - 2 * (found * right).sum(axis=1)
    error += np.einsum("ki,kij,kj->k", found, normal, found)
    error = np.sqrt(np.maximum(error, 0.0) / np.maximum(placed, 1)) * unit
    scale = unit[:, None] ** np.array([1, 0, 0, -1, -1, -1])
    few = placed < loops.TERMS
    return Quadrics(np.where(few[:, None], np.nan, found * scale), np.where(few, np.nan, error))
