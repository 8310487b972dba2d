"""The pinhole camera: intrinsics, and depth maps as points (the ``Z = bf/D`` side of Sec. V)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

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
    def from_numbers(
        cls, numbers: ArrayLike, width: int | None = None, height: int | None = None
    ) -> Intrinsics:
        """Intrinsics of a camera matrix, or of four numbers.

        Parameters
        ----------
        numbers : array-like
            A 3 x 3 matrix K (also 3 x 4 or 4 x 4, whose other numbers are not used, or the nine
            numbers of K in one row), row by row or, as Open3D and ARKit write it, column by
            column; or fx, fy, cx, cy.
        width, height : int, optional
            Size in pixels of the image that they hold for.

        Raises
        ------
        GeohueError
            For anything else.

        Examples
        --------
        >>> Intrinsics.from_numbers([[500, 0, 320], [0, 510, 240], [0, 0, 1]]).fy
        510.0
        >>> Intrinsics.from_numbers((500, 500, 320, 240)).cx
        320.0
        """
        try:
            values = np.asarray(numbers, np.float64)
        except (TypeError, ValueError, OverflowError) as error:
            raise GeohueError("the camera's values are not all numbers") from error
        if values.shape == (4,):
            fx, fy, cx, cy = (float(value) for value in values)
            return cls(fx, fy, cx, cy, width, height)
        if values.size == 9:
            values = values.reshape(3, 3)
        if values.shape in ((3, 3), (3, 4), (4, 4)):
            matrix = values[:3, :3]
            for K in (matrix, matrix.T):
                zeros = abs(K[1, 0]) + abs(K[2, 0]) + abs(K[2, 1])
                if zeros == 0 and K[2, 2] == 1 and abs(K[0, 1]) <= 1e-2 * abs(K[0, 0]):
                    fx, fy, cx, cy = (float(K[i]) for i in ((0, 0), (1, 1), (0, 2), (1, 2)))
                    return cls(fx, fy, cx, cy, width, height)
            raise GeohueError("its matrix is not a camera matrix [fx 0 cx; 0 fy cy; 0 0 1]")
        raise GeohueError(f"a camera of shape {values.shape}: expected K (3, 3) or fx, fy, cx, cy")

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
