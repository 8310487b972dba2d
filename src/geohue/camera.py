"""The pinhole camera: intrinsics, and depth maps as points (the ``Z = bf/D`` side of Sec. V)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError


def first_value(content: Mapping[Any, Any], names: Iterable[str]) -> Any:
    """Return the value of the first name that a calibration has, None if it has none of them.

    Parameters
    ----------
    content : mapping
        Keys in upper or lower case.
    names : iterable of str
        What the value may be called, in lower case.

    Examples
    --------
    >>> first_value({"K": 1, "M1": 2}, ("m1", "k")), first_value({}, ("m1",))
    (2, None)
    """
    lower = {str(key).lower(): value for key, value in content.items()}
    return next((lower[name] for name in names if name in lower), None)


@dataclass(frozen=True, slots=True)
class Intrinsics:
    """Pinhole intrinsics of one camera.

    Parameters
    ----------
    fx, fy : float
        Focal lengths in pixels, positive.
    cx, cy : float
        Principal point in pixels; pixel centres lie at whole numbers.
    width, height : int, optional
        Size in pixels of the image that the values hold for. None means "any": the values are
        used as they are.
    depth_scale : float, optional
        Units of the depth image per metre (1000 for millimetres), where the camera file says so.

    Raises
    ------
    GeohueError
        If a focal length is not positive or a value is not finite.

    Examples
    --------
    >>> Intrinsics(525.0, 525.0, 319.5, 239.5, 640, 480).scaled_to(320, 240).fx
    262.5
    """

    fx: float
    fy: float
    cx: float
    cy: float
    width: int | None = None
    height: int | None = None
    depth_scale: float | None = None

    def __post_init__(self) -> None:
        values = (self.fx, self.fy, self.cx, self.cy)
        if not np.all(np.isfinite(values)) or self.fx <= 0 or self.fy <= 0:
            raise GeohueError(
                f"intrinsics fx={self.fx}, fy={self.fy}, cx={self.cx}, cy={self.cy}: "
                "all must be finite and the focal lengths positive"
            )
        if (self.width is not None and self.width < 1) or (
            self.height is not None and self.height < 1
        ):
            raise GeohueError(
                f"intrinsics: image size {self.width} x {self.height} is not positive"
            )
        if self.depth_scale is not None and not 0 < self.depth_scale < np.inf:
            raise GeohueError(f"intrinsics: depth_scale {self.depth_scale} is not positive")

    @classmethod
    def guess(cls, width: int, height: int) -> Intrinsics:
        """Intrinsics of a typical depth camera: 57 degrees wide, centred (Kinect at any size)."""
        f = 525.0 / 640.0 * width
        return cls(f, f, (width - 1) / 2, (height - 1) / 2, width, height)

    def scaled_to(self, width: int, height: int) -> Intrinsics:
        """Return the same camera at another image size."""
        if (
            self.width is None
            or self.height is None
            or (self.width, self.height) == (width, height)
        ):
            return self
        sx, sy = width / self.width, height / self.height
        return Intrinsics(
            self.fx * sx,
            self.fy * sy,
            (self.cx + 0.5) * sx - 0.5,
            (self.cy + 0.5) * sy - 0.5,
            width,
            height,
            self.depth_scale,
        )

    def unproject(self, depth: NDArray[np.float32]) -> NDArray[np.float32]:
        """Turn a depth map into points in the camera frame (x right, y down, z forward).

        Parameters
        ----------
        depth : (H, W) float32
            Distance along the optical axis; NaN where missing.

        Returns
        -------
        (H, W, 3) float32
            Points in the unit of `depth`; NaN where the depth is missing.
        """
        height, width = depth.shape
        x = ((np.arange(width, dtype=np.float32) - self.cx) / self.fx).astype(np.float32)
        y = ((np.arange(height, dtype=np.float32) - self.cy) / self.fy).astype(np.float32)
        points = np.empty((height, width, 3), np.float32)
        points[..., 0] = depth * x
        points[..., 1] = depth * y[:, None]
        points[..., 2] = depth
        return points
