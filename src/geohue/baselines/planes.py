"""The planes of an image that the image-domain systems work on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.scene import Scene


def luv_of(colors: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Convert sRGB to CIELuv, D65: (H, W, 3) float32, L in 0..100."""
    import cv2

    unit = colors.astype(np.float32) / np.float32(255)
    return np.asarray(cv2.cvtColor(unit, cv2.COLOR_RGB2Luv), np.float32)


def depth_of(scene: Scene) -> NDArray[np.float32]:
    """Return the depth map of a grid, or the third coordinate; NaN where missing."""
    return scene.points[..., 2] if scene.depth is None else scene.depth


def filled(values: NDArray[np.float32], mask: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Give the pixels outside the mask the values of the nearest ones inside, or 0."""
    from scipy.ndimage import distance_transform_edt

    if not mask.any():
        return np.zeros_like(values)
    if mask.all():
        return values
    nearest = distance_transform_edt(~mask, return_distances=False, return_indices=True)
    return np.asarray(values[tuple(nearest)], values.dtype)
