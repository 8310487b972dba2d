"""A camera with its lens: rays of its pixels, and pixels of points (Sec. VI-A, VI-C)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics
from geohue.errors import GeohueError

LensModel = Literal["brown", "fisheye", "inverse"]
_MODELS: tuple[LensModel, ...] = get_args(LensModel)
_LENGTHS = {"brown": (0, 4, 5, 8, 12, 14), "inverse": (0, 4, 5, 8, 12, 14), "fisheye": (0, 4)}
_ROUNDS = 25
_WIDEST = 8.0  # tangent of the widest half angle that a lens model is looked at: 83 degrees

Pairs = NDArray[np.floating[Any]]


@dataclass(frozen=True, slots=True)
class Lens:
    """Pinhole intrinsics and lens distortion of one camera.

    Parameters
    ----------
    camera : Intrinsics
        Of the picture as the camera gives it.
    distortion : tuple of float
        OpenCV's coefficients: k1, k2, p1, p2, k3, k4, k5, k6, s1 .. s4 ("brown": 4, 5, 8 or 12 of
        them), or k1 .. k4 ("fisheye"); empty for none.
    model : {"brown", "fisheye", "inverse"}
        "inverse" is Herrera's depth camera: the polynomial of "brown" leads from the pixel to the
        ray and not from the ray to the pixel.

    Raises
    ------
    GeohueError
        For another number of coefficients, a tilted sensor, or a value that is not finite.

    Examples
    --------
    >>> lens = Lens(Intrinsics(500.0, 500.0, 320.0, 240.0, 640, 480), (0.1, 0.0, 0.0, 0.0))
    >>> lens.project(np.array([[0.0, 0.0, 2.0], [1.0, 0.0, 2.0], [0.0, 0.0, -1.0]]))
    array([[320. , 240. ],
           [576.25, 240. ],
           [  nan,    nan]], dtype=float32)
    """

    camera: Intrinsics
    distortion: tuple[float, ...] = ()
    model: LensModel = "brown"

    def __post_init__(self) -> None:
        if self.model not in _MODELS:
            raise GeohueError(f"lens model {self.model!r}: choose one of {', '.join(_MODELS)}")
        count = len(self.distortion)
        if count not in _LENGTHS[self.model]:
            wanted = " or ".join(str(n) for n in _LENGTHS[self.model])
            raise GeohueError(f"{count} distortion coefficients ({self.model}): expected {wanted}")
        if not np.isfinite(self.distortion).all():
            raise GeohueError("a distortion coefficient is not finite")
        if any(self.distortion[12:]):
            raise GeohueError("the calibration has a tilted sensor (tau), which is not supported")

    @property
    def is_straight(self) -> bool:
        """Whether straight lines stay straight: no distortion."""
        return self.model != "fisheye" and not any(self.distortion)

    def scaled_to(self, width: int, height: int) -> Lens:
        """Return the same lens for another size of the picture."""
        return replace(self, camera=self.camera.scaled_to(width, height))

    def rays(self, height: int, width: int) -> NDArray[np.float32]:
        """Return the ray of each pixel.

        Parameters
        ----------
        height, width : int
            Size of the picture, that of the camera.

        Returns
        -------
        (H, W, 3) float32
            x and y at z = 1.
        """
        rows, columns = np.mgrid[0:height, 0:width].astype(np.float64)
        pixels = np.stack([columns, rows], axis=-1).reshape(-1, 2)
        rays = np.ones((height, width, 3), np.float32)
        rays[..., :2] = self.unproject(pixels).reshape(height, width, 2)
        return rays

    def unproject(self, pixels: Pairs) -> Pairs:
        """Return x and y at z = 1 of the rays through (N, 2) pixels."""
        camera = self.camera
        bent = (pixels - (camera.cx, camera.cy)) / (camera.fx, camera.fy)
        if self.is_straight:
            return bent
        return self._bend(bent) if self.model == "inverse" else self._straighten(bent)

    def project(self, points: NDArray[np.floating[Any]]) -> NDArray[np.float32]:
        """Return the pixels of points.

        Parameters
        ----------
        points : (N, 3) float
            In the camera's frame: x right, y down, z forward.

        Returns
        -------
        (N, 2) float32
            Column and row, also beyond the picture's border. NaN for points behind the camera,
            and where the lens model folds back: it holds for no such wide angle.
        """
        z = points[:, 2]
        with np.errstate(all="ignore"):
            flat: Pairs = points[:, :2] / np.where(z > 0, z, np.nan)[:, None]
            if not self.is_straight:
                wide = flat[:, 0] ** 2 + flat[:, 1] ** 2 > self._reach() ** 2
                flat[wide] = np.nan
                flat = self._straighten(flat) if self.model == "inverse" else self._bend(flat)
            camera = self.camera
            pixels = np.empty(flat.shape, np.float32)
            pixels[:, 0] = flat[:, 0] * camera.fx + camera.cx
            pixels[:, 1] = flat[:, 1] * camera.fy + camera.cy
        return pixels

    def _bend(self, flat: Pairs) -> Pairs:
        bend = _bend_fisheye if self.model == "fisheye" else _bend_brown
        with np.errstate(all="ignore"):
            return bend(flat, self.distortion)

    def _straighten(self, bent: Pairs) -> Pairs:
        """Solve ``bend(flat) = bent`` by Newton's method, the slope taken by differences."""
        bent = bent.astype(np.float64)
        flat, step = bent.copy(), 1e-6
        reach = self._reach()
        with np.errstate(all="ignore"):
            for _ in range(_ROUNDS):
                here = self._bend(flat)
                dx = (self._bend(flat + np.array([step, 0])) - here) / step
                dy = (self._bend(flat + np.array([0, step])) - here) / step
                error = bent - here
                if not np.nanmax(np.abs(error), initial=0.0) > 1e-12:
                    break
                det = dx[:, 0] * dy[:, 1] - dx[:, 1] * dy[:, 0]
                flat[:, 0] += (error[:, 0] * dy[:, 1] - error[:, 1] * dy[:, 0]) / det
                flat[:, 1] += (error[:, 1] * dx[:, 0] - error[:, 0] * dx[:, 1]) / det
                flat = np.clip(flat, -reach, reach)
            lost = ~(np.abs(self._bend(flat) - bent).max(axis=1) < 1e-6)
        flat[lost] = np.nan
        return flat

    def _reach(self) -> float:
        """Return the tangent of the half angle up to which the radius grows with the angle."""
        return _reach(self.distortion, self.model)


@lru_cache(maxsize=64)
def _reach(distortion: tuple[float, ...], model: LensModel) -> float:
    bend: Callable[[Pairs, tuple[float, ...]], Pairs]
    bend = _bend_fisheye if model == "fisheye" else _bend_brown
    line = np.zeros((4001, 2))
    line[:, 0] = np.linspace(0, _WIDEST, len(line))
    with np.errstate(all="ignore"):
        radius = bend(line, distortion)[:, 0]
    falling = np.flatnonzero(~(np.diff(radius) > 0))
    return float(line[falling[0], 0]) if len(falling) else _WIDEST


def _bend_brown(flat: Pairs, distortion: tuple[float, ...]) -> Pairs:
    """Distort by Brown's model, with OpenCV's rational and thin-prism extensions."""
    k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4 = (*distortion, *(0.0,) * 12)[:12]
    x, y = flat[:, 0], flat[:, 1]
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    if k4 or k5 or k6:
        radial = radial / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
    bent = np.empty_like(flat)
    bent[:, 0] = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x) + r2 * (s1 + r2 * s2)
    bent[:, 1] = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y + r2 * (s3 + r2 * s4)
    return bent


def _bend_fisheye(flat: Pairs, distortion: tuple[float, ...]) -> Pairs:
    """Distort by the equidistant model: the radius grows with the angle."""
    k1, k2, k3, k4 = (*distortion, *(0.0,) * 4)[:4]
    radius = np.linalg.norm(flat, axis=1)
    angle = np.arctan(radius)
    t2 = angle * angle
    bent = angle * (1 + t2 * (k1 + t2 * (k2 + t2 * (k3 + t2 * k4))))
    factor = np.divide(bent, radius, out=np.ones_like(radius), where=radius > 0)
    return np.asarray(flat * factor[:, None])
