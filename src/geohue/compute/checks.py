"""What may come in: arrays are checked and cast once, at the door of a scene."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geohue.errors import GeohueError


def is_real(array: NDArray[np.generic]) -> bool:
    """Whether an array holds real numbers."""
    return array.dtype.kind in "fiu"


def check_image(rgb: ArrayLike) -> NDArray[np.uint8]:
    """Return an image as (H, W, 3) uint8, or say what is wrong with it."""
    image = np.asarray(rgb)
    if image.dtype != np.uint8:
        raise GeohueError(f"the image has type {image.dtype}: expected uint8 sRGB (0..255)")
    if image.ndim == 2:
        image = np.repeat(image[..., None], 3, axis=2)
    if image.ndim != 3 or image.shape[2] != 3 or image.size == 0:
        raise GeohueError(f"the image has shape {image.shape}: expected (H, W, 3) or (H, W)")
    return np.ascontiguousarray(image)


def check_depth(
    depth: ArrayLike, shape: tuple[int, ...], scale: float | None
) -> NDArray[np.float32]:
    """Return a depth map in metres with gaps for what is missing, or say what is wrong with it."""
    raw = np.asarray(depth)
    if raw.ndim != 2:
        raise GeohueError(
            f"the depth map has shape {raw.shape}: expected (H, W), one channel; "
            "a picture of the depth in colours cannot be used"
        )
    if raw.shape != shape:
        raise GeohueError(
            f"image and depth differ in size: {shape[1]} x {shape[0]} and "
            f"{raw.shape[1]} x {raw.shape[0]}; register the depth to the image first"
        )
    if not is_real(raw):
        raise GeohueError(f"the depth map has type {raw.dtype}: expected floats or integers")
    if scale is None and raw.dtype.kind in "iu":
        raise GeohueError(
            f"the depth map has type {raw.dtype}: say how many metres a unit is "
            "(depth_scale=0.001 for millimetres) or pass metres as floats"
        )
    if scale is not None and not 0 < scale < np.inf:
        raise GeohueError(f"depth_scale is {scale}: expected a positive number of metres per unit")
    with np.errstate(over="ignore"):  # a value that float32 cannot hold becomes inf: missing
        metres = (raw * np.float64(scale or 1.0)).astype(np.float32)
    metres[~(np.isfinite(metres) & (metres > 0))] = np.nan
    return metres


def check_disparity(disparity: ArrayLike) -> NDArray[np.floating[Any]]:
    """Return a disparity map as floats, or say what is wrong with it."""
    values = np.asarray(disparity)
    if values.ndim != 2 or not is_real(values):
        raise GeohueError(
            f"the disparity has shape {values.shape} and type {values.dtype}: expected (H, W) "
            "numbers in pixels"
        )
    return values.astype(np.float64)


def check_cloud_colors(colors: NDArray[np.generic], shape: tuple[int, ...]) -> NDArray[np.uint8]:
    """Return the colours of a cloud as uint8, or say what is wrong with them."""
    if colors.shape != shape:
        raise GeohueError(
            f"points and colours differ in shape: {shape} and {colors.shape}; "
            "every point needs red, green and blue"
        )
    if colors.dtype == np.uint8:
        return np.ascontiguousarray(colors, dtype=np.uint8)
    values = colors.astype(np.float64) if colors.dtype.kind == "f" else None
    if values is None or not (values.size == 0 or (values.min() >= 0 and values.max() <= 1)):
        raise GeohueError(
            f"the colours have type {colors.dtype}: expected uint8, or floats within 0..1"
        )
    return np.rint(values * 255).astype(np.uint8)


def check_normals(normals: ArrayLike | None, shape: tuple[int, ...]) -> NDArray[np.float32] | None:
    """Return the normals of a cloud with length 1, NaN where there is none, or say what is wrong.

    Examples
    --------
    >>> check_normals([[0, 3, 4], [0, 0, 0]], (2, 3)).tolist()
    [[0.0, 0.6000000238418579, 0.800000011920929], [nan, nan, nan]]
    """
    if normals is None:
        return None
    values = np.asarray(normals)
    if values.shape != shape or not is_real(values):
        raise GeohueError(
            f"the normals have shape {values.shape} and type {values.dtype}: expected numbers in "
            f"the shape of the points, {shape}"
        )
    values = values.astype(np.float64)
    with np.errstate(all="ignore"):
        length = np.sqrt((values**2).sum(axis=-1, keepdims=True))
        unit = np.where((length > 0) & (length < np.inf), values / length, np.nan)
    return unit.astype(np.float32)


def centered(
    xyz: NDArray[np.generic],
) -> tuple[NDArray[np.float32], tuple[float, float, float]]:
    """Cast to float32, after the offset of map coordinates is taken off: no label depends on it.

    Returns the points and the offset.
    """
    points = xyz.astype(np.float64)
    finite = np.isfinite(points).all(axis=-1)
    points[~finite] = np.nan
    offset = np.zeros(3)
    if finite.any():
        low, high = points[finite].min(axis=0), points[finite].max(axis=0)
        if np.abs(np.stack([low, high])).max() > 1e3 * max((high - low).max(), 1e-300):
            offset = (low + high) / 2
            points -= offset
    with np.errstate(over="ignore"):
        cast = points.astype(np.float32)
    cast[~np.isfinite(cast).all(axis=-1)] = np.nan
    return cast, (float(offset[0]), float(offset[1]), float(offset[2]))
