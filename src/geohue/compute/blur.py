"""A Gaussian blur, without the fifth of a second that scipy.ndimage takes to be imported."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def gaussian_blur(
    values: NDArray[np.float64], sigma: float, axis: int, truncate: float = 4.0
) -> NDArray[np.float64]:
    """Blur along one axis: bit by bit what `scipy.ndimage.gaussian_filter1d` gives.

    For kernels of a few values, each of which is a pass over the array.

    Parameters
    ----------
    values : float64 array
        Mirrored beyond its ends, which are repeated.
    sigma : float
        Standard deviation in steps of the array.
    axis : int
        Along which to blur.
    truncate : float
        Where the kernel ends, in standard deviations.

    Returns
    -------
    float64 array
        A new array.

    Examples
    --------
    >>> gaussian_blur(np.array([0.0, 0, 1, 0, 0]), 0.5, axis=0).round(3).tolist()
    [0.0, 0.106, 0.787, 0.106, 0.0]
    """
    reach = int(truncate * sigma + 0.5)
    kernel = np.exp(-0.5 / (sigma * sigma) * np.arange(-reach, reach + 1) ** 2)
    kernel /= kernel.sum()
    margins = [(0, 0)] * values.ndim
    margins[axis] = (reach, reach)
    padded = np.moveaxis(np.pad(values, margins, mode="symmetric"), axis, 0)
    n = values.shape[axis]
    total = padded[reach : reach + n] * kernel[reach]
    for step in range(reach, 0, -1):
        pair = padded[reach - step : reach - step + n] + padded[reach + step : reach + step + n]
        total += pair * kernel[reach - step]
    return np.ascontiguousarray(np.moveaxis(total, 0, axis))
