"""A range sensor and the colour cameras beside it, as a calibration describes them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.sensors.kinect import DisparityModel
from geohue.sensors.lens import Lens

Vector = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class PosedCamera:
    """A colour camera and where it stands: ``X_camera = R X_range + T``.

    Parameters
    ----------
    lens : Lens
        The camera.
    rotation : (3, 3) float64
        R, orthonormal with determinant 1.
    translation : (3,) float64
        T, in the unit of the range points.
    name : str
        What the calibration calls it.

    Raises
    ------
    GeohueError
        If R is no rotation, or a shape or value is wrong.
    """

    lens: Lens
    rotation: Vector = field(default_factory=lambda: np.eye(3))
    translation: Vector = field(default_factory=lambda: np.zeros(3))
    name: str = "color"

    def __post_init__(self) -> None:
        for label, shape in (("rotation", (3, 3)), ("translation", (3,))):
            value = np.asarray(getattr(self, label), np.float64)
            if value.shape != shape or not np.isfinite(value).all():
                raise GeohueError(
                    f"{label} of camera {self.name!r} has shape {value.shape}: "
                    f"expected {shape}, all finite"
                )
            object.__setattr__(self, label, value)
        R = self.rotation
        if not np.allclose(R @ R.T, np.eye(3), atol=1e-3) or np.linalg.det(R) < 0:
            raise GeohueError(
                f"rotation of camera {self.name!r} is no rotation matrix (orthonormal, det 1): "
                f"its rows have lengths {np.linalg.norm(R, axis=1).round(4).tolist()} "
                f"and its determinant is {np.linalg.det(R):.4g}"
            )

    def transform(self, points: NDArray[np.floating[Any]]) -> NDArray[np.float32]:
        """Bring (N, 3) points of the range sensor into the camera's frame."""
        # Column by column: a matrix product this narrow is much slower.
        turned = np.empty(points.shape, np.float32)
        x, y, z = (points[:, i] for i in range(3))
        for i, (row, shift) in enumerate(zip(self.rotation, self.translation, strict=True)):
            a, b, c, t = (points.dtype.type(v) for v in (*row, shift))
            turned[:, i] = a * x + b * y + c * z + t
        return turned

    def scaled_to(self, width: int, height: int) -> PosedCamera:
        """Return the same camera for another size of the picture."""
        return replace(self, lens=self.lens.scaled_to(width, height))


@dataclass(frozen=True, slots=True, eq=False)
class Rig:
    """A calibrated set-up: one range sensor, one or more colour cameras.

    Parameters
    ----------
    cameras : tuple of PosedCamera
        The colour cameras, the main one first.
    depth : Lens, optional
        The depth or time-of-flight camera; None for a scanner, whose points need no lens.
    disparity : DisparityModel, optional
        How raw Kinect disparities become metres.
    depth_unit : float, optional
        Metres per unit of the depth picture, where the calibration says so.
    warnings : tuple of str
        Guesses that the user should know of.

    Raises
    ------
    GeohueError
        If there is no colour camera.
    """

    cameras: tuple[PosedCamera, ...]
    depth: Lens | None = None
    disparity: DisparityModel | None = None
    depth_unit: float | None = None
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.cameras:
            raise GeohueError("the rig has no colour camera")

    @property
    def depth_lens(self) -> Lens:
        """The depth camera; GeohueError if the range sensor is a scanner."""
        if self.depth is None:
            raise GeohueError(
                "the calibration has no depth camera (K of the depth or infrared camera)"
            )
        return self.depth

    def points(self, depth: NDArray[np.float32]) -> NDArray[np.float32]:
        """Turn a depth map of the range camera into (H, W, 3) points, its distortion undone."""
        height, width = depth.shape
        rays = self.depth_lens.scaled_to(width, height).rays(height, width)
        return rays * depth[..., None]
