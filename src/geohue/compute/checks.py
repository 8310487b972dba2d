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
    """Return an image as (H, W, 3) uint8, or say what is wrong with it.

    Examples
    --------
    >>> check_image(np.full((1, 1, 4), 0.5)).tolist(), check_image(np.uint16([[513]])).tolist()
    ([[[128, 128, 128]]], [[[2, 2, 2]]])
    """
    image = np.asarray(rgb)
    channels = image[..., None] if image.ndim == 2 else image
    if channels.ndim != 3 or channels.shape[2] not in (1, 3, 4) or channels.size == 0:
        raise GeohueError(
            f"the image has shape {image.shape}: expected (H, W, 3), (H, W, 4) with alpha, or "
            "(H, W) for grey"
        )
    colors = as_bytes(channels[..., :3], "image")
    return np.ascontiguousarray(np.repeat(colors, 3, axis=2) if colors.shape[2] == 1 else colors)


def as_bytes(values: NDArray[np.generic], what: str) -> NDArray[np.uint8]:
    """Return colours of any usual type as 0..255, or say what is wrong with them.

    Whole numbers up to 255 are taken as they are, 16-bit ones beyond by their upper byte, and
    fractions within 0..1 times 255.
    """
    if values.dtype == np.uint8:
        return np.asarray(values, np.uint8)
    expected = "expected uint8 (0..255), uint16, or floats within 0..1"
    if not is_real(values):
        raise GeohueError(f"{what} of type {values.dtype}: {expected}")
    if values.size == 0:
        return values.astype(np.uint8)
    low, high = values.min(), values.max()
    if values.dtype.kind == "f":
        if not (low >= 0 and high <= 1):
            mend = "; divide it by 255" if 1 < high <= 255 and low >= 0 else ""
            found = f"{low:.4g} to {high:.4g}"
            raise GeohueError(f"{what} with {values.dtype} values from {found}: {expected}{mend}")
        return np.rint(values.astype(np.float64) * 255).astype(np.uint8)
    if low >= 0 and high <= 255:
        return values.astype(np.uint8)
    if values.dtype == np.uint16:
        return (values.astype(np.uint16) >> 8).astype(np.uint8)
    raise GeohueError(f"{what} with {values.dtype} values from {low} to {high}: {expected}")


def check_depth(depth: ArrayLike, scale: float | None) -> NDArray[np.float32]:
    """Return a depth map in metres with gaps for what is missing, or say what is wrong with it."""
    given = np.asarray(depth)
    raw = given[..., 0] if given.ndim == 3 and given.shape[2] == 1 else given
    if raw.ndim != 2 or raw.size == 0:
        raise GeohueError(
            f"the depth map has shape {raw.shape}: expected (H, W), one channel; "
            "a picture of the depth in colours cannot be used"
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
    rgb = colors[..., :3] if colors.ndim == len(shape) and colors.shape[-1:] == (4,) else colors
    if rgb.shape != shape:
        raise GeohueError(
            f"points and colours differ in shape: {shape} and {colors.shape}; "
            "every point needs red, green and blue"
        )
    return np.ascontiguousarray(as_bytes(rgb, "colours"))


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
    offset = map_offset(xyz)
    return without_offset(xyz, offset), (float(offset[0]), float(offset[1]), float(offset[2]))


def map_offset(xyz: NDArray[np.generic]) -> NDArray[np.float64]:
    """Return the middle of points that lie far from zero for their extent, else zero, (3,)."""
    points = xyz.astype(np.float64).reshape(-1, 3)
    points = points[np.isfinite(points).all(axis=1)]
    if len(points):
        low, high = points.min(axis=0), points.max(axis=0)
        with np.errstate(over="ignore"):
            if np.abs(np.stack([low, high])).max() > 1e3 * max((high - low).max(), 1e-300):
                return np.asarray(low / 2 + high / 2)
    return np.zeros(3)


def without_offset(xyz: NDArray[np.generic], offset: NDArray[np.float64]) -> NDArray[np.float32]:
    """Take an offset off and cast to float32; a point that is not finite is NaN throughout."""
    with np.errstate(over="ignore", invalid="ignore"):
        cast = (xyz.astype(np.float64) - offset).astype(np.float32)
    cast[~np.isfinite(cast).all(axis=-1)] = np.nan
    return cast
