"""Raw disparities of the first Kinect (11 bit) as metres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError

NO_DISPARITY = 2047
"""The sensor's mark for "no measurement"."""


@dataclass(frozen=True, slots=True, eq=False)
class DisparityModel:
    """How a raw disparity d becomes a depth: ``Z = 1 / (c0 + c1 d)``, in metres.

    Parameters
    ----------
    c0, c1 : float
        By default the widely used values of a typical Kinect (good to a few per cent).
    alpha : tuple of float, optional
        Herrera's disparity distortion ``d + beta exp(alpha0 - alpha1 d)``, together with `beta`.
    beta : (H, W) float, optional
        The distortion of each pixel.

    Raises
    ------
    GeohueError
        If the values would give no depth at all.

    References
    ----------
    D. Herrera C., J. Kannala and J. Heikkila, "Joint depth and color camera calibration with
    distortion correction", IEEE TPAMI 34 (2012).

    Examples
    --------
    >>> DisparityModel().depth(np.array([[400, 1000, 2047]], np.uint16)).round(3)
    array([[0.476, 3.848,   nan]], dtype=float32)
    """

    c0: float = 3.3309495161
    c1: float = -0.0030711016
    alpha: tuple[float, float] | None = None
    beta: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        values = (self.c0, self.c1, *(self.alpha or ()))
        if not np.isfinite(values).all() or self.c1 >= 0 or self.c0 <= 0:
            raise GeohueError(
                f"disparity model c0={self.c0}, c1={self.c1}: expected finite values with "
                "c0 > 0 > c1 (a larger raw disparity is farther away)"
            )

    def depth(self, disparity: NDArray[np.generic]) -> NDArray[np.float32]:
        """Turn raw disparities into depth.

        Parameters
        ----------
        disparity : (H, W) integer or float
            As the sensor gives them; 2047 and whatever lies beyond the range is missing.

        Returns
        -------
        (H, W) float32
            Metres; NaN where missing.

        Raises
        ------
        GeohueError
            If the values are no raw disparities, or the distortion is for another size.
        """
        raw = np.asarray(disparity).astype(np.float64)
        if raw.ndim != 2 or (raw.size and np.nanmax(raw) > NO_DISPARITY):
            raise GeohueError(
                f"disparities of shape {raw.shape} up to {np.nanmax(raw, initial=0):g}: "
                f"raw Kinect disparities are one channel of 0..{NO_DISPARITY}"
            )
        missing = ~(raw < NO_DISPARITY)
        if self.alpha is not None and self.beta is not None:
            if self.beta.shape != raw.shape:
                raise GeohueError(
                    f"the disparity distortion has shape {self.beta.shape}, the picture {raw.shape}"
                )
            with np.errstate(over="ignore"):
                raw = raw + self.beta * np.exp(self.alpha[0] - self.alpha[1] * raw)
        nearness = self.c0 + self.c1 * raw
        missing |= ~(nearness > 1 / 100)  # a Kinect sees 10 m, this is 100
        depth = np.full(raw.shape, np.nan, np.float32)
        depth[~missing] = 1 / nearness[~missing]
        return depth
