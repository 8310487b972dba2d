"""Pairs made from a known disparity."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage


class Pair(NamedTuple):
    """A left and a right image, and the disparity of the left one."""

    left: NDArray[np.uint8]
    right: NDArray[np.uint8]
    disparity: NDArray[np.float64]


def texture(height: int, width: int, seed: int) -> NDArray[np.uint8]:
    """Return an image with features of several sizes."""
    rng = np.random.default_rng(seed)
    image = np.zeros((height, width, 3))
    for sigma in (1.0, 3.0):
        layer = ndimage.gaussian_filter(rng.normal(size=image.shape), (sigma, sigma, 0))
        image += layer / layer.std()
    return np.asarray(np.clip(128 + 40 * image, 0, 255), np.uint8)


@pytest.fixture(scope="session")
def box_pair() -> Pair:
    """A square 12 px nearer in front of a background at 6 px."""
    background, front = texture(160, 280, 1), texture(70, 80, 2)
    left, right = background[:, 6:246].copy(), background[:, 12:252].copy()
    left[50:120, 110:190] = front
    right[50:120, 92:172] = front
    truth = np.full(left.shape[:2], 6.0)
    truth[50:120, 110:190] = 18
    return Pair(left, right, truth)
