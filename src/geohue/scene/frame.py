"""An image and a depth map in its view, made to fit: size, orientation, limits, camera."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics
from geohue.compute.checks import check_depth
from geohue.errors import GeohueError
from geohue.scene.given import (
    Camera,
    Notes,
    Picture,
    camera_given,
    is_path,
    picture_given,
    read,
    values_given,
)
from geohue.sensors.orientation import swaps_sides, upright, upright_camera
from geohue.sensors.scaling import same_shape, sample_nearest, scale_depth

_FARTHEST = 100.0  # metres: a median beyond is that of millimetres given as metres
_PLAUSIBLE_VIEW = (10.0, 150.0)  # degrees
_CENTRED = 0.2  # relative distance of the principal point from the middle, for a guess

Size = tuple[int, int]


@dataclass(frozen=True, slots=True)
class Trust:
    """Which of a depth map's values are used.

    Parameters
    ----------
    confidence : array-like or path, optional
        How sure the sensor is of each pixel of the depth map, higher is surer: 0, 1, 2 (phones),
        0..255 or 0..1.
    least : float, optional
        Confidence from which on depth is used; by default half of the highest there is.
    nearest, farthest : float, optional
        Metres; depth outside is not used.

    Raises
    ------
    GeohueError
        For limits that leave nothing, or `least` without a confidence.
    """

    confidence: Picture | None = None
    least: float | None = None
    nearest: float | None = None
    farthest: float | None = None

    def __post_init__(self) -> None:
        near, far = self.nearest, self.farthest
        for name, value in (("min_depth", near), ("max_depth", far)):
            if value is not None and not 0 <= value < np.inf:
                raise GeohueError(f"{name} is {value}: expected metres, 0 or more")
        if near is not None and far is not None and near >= far:
            raise GeohueError(f"min_depth={near} and max_depth={far} leave no depth between them")
        if self.least is not None and self.confidence is None:
            raise GeohueError("least has no confidence to compare with: give confidence too")


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """What `build_frame` returns: arrays of one size, and the camera of that size."""

    colors: NDArray[np.uint8]
    depth: NDArray[np.float32]
    camera: Intrinsics
    orientation: int
    notes: Notes


def build_frame(
    rgb: Picture,
    depth: Picture,
    intrinsics: Camera | None,
    depth_scale: float | str | None,
    trust: Trust,
) -> Frame:
    """Read and check an image and its depth map, and make them fit."""
    camera, notes = camera_given(intrinsics)
    if depth_scale is None and camera is not None and camera.depth_scale is not None:
        depth_scale = 1 / camera.depth_scale if is_path(depth) else None
    colors, orientation = picture_given(rgb)
    metres, more = _depth_given(depth, depth_scale)
    metres, doubts = _trusted(metres, trust)
    notes = (*notes, *more, *doubts)
    camera = _sized(camera, colors.shape, metres.shape)
    colors, metres, camera, said = _turned(colors, metres, camera, orientation)
    height, width = colors.shape[:2]
    if metres.shape != (height, width):
        metres, fitted = _fitted(metres, (height, width), rgb, depth)
        said = (*said, fitted)
    notes = (*notes, *said)
    if camera is None:
        camera = Intrinsics.guess(width, height)
        return Frame(colors, metres, camera, orientation, (*notes, _guessed(camera)))
    if (camera.width, camera.height) not in ((width, height), (None, None)):
        note = (
            f"intrinsics are for {camera.width} x {camera.height}: "
            f"scaled to the image's {width} x {height}"
        )
        notes = (*notes, note)
    camera = camera.scaled_to(width, height)

    notes = (*notes, *_view_doubts(camera, (height, width)))
    return Frame(colors, metres, camera, orientation, notes)


def _guessed(camera: Intrinsics) -> str:
    return (
        f"no intrinsics given: assuming a typical depth camera (fx = fy = {camera.fx:.0f} px, "
        "centre of the image)"
    )


def _depth_given(given: Picture, scale: float | str | None) -> tuple[NDArray[np.float32], Notes]:
    """Return a depth map in metres, and doubts of its unit."""
    if is_path(given):
        found: tuple[NDArray[np.float32], Notes] = read("depth", Path(given), scale)
        return found
    values = np.asarray(given)
    if isinstance(scale, str):
        unit = read("unit", scale)
        if unit.decode is not None:
            values = unit.decode(values.astype(np.uint16))
        return check_depth(values, unit.scale), ()
    metres = check_depth(values, scale)
    known = metres[np.isfinite(metres)]
    median = float(np.median(known.astype(np.float64))) if known.size else 0.0
    if median <= _FARTHEST or scale is not None:
        return metres, ()
    return metres, (
        f"the median depth is {median:.4g} m: if these are millimetres, give depth_scale=0.001",
    )


def _trusted(depth: NDArray[np.float32], trust: Trust) -> tuple[NDArray[np.float32], Notes]:
    """Leave out what lies beyond the limits, or is not sure enough."""
    out = np.zeros(depth.shape, bool)
    notes: list[str] = []
    known = np.isfinite(depth)
    with np.errstate(invalid="ignore"):
        if trust.nearest is not None:
            out |= depth < trust.nearest
        if trust.farthest is not None:
            out |= depth > trust.farthest
    if trust.confidence is not None:
        sure, least = _confidence(trust.confidence, trust.least, depth.shape)
        out |= sure < least
        share = float((out & known).sum() / max(1, known.sum()))
        notes.append(f"depth with a confidence below {least:g} is left out ({share:.0%} of it)")
    if known.any() and not (known & ~out).any():
        raise GeohueError(
            "no depth is left within min_depth, max_depth and the least confidence: widen them"
        )
    return np.where(out, np.float32(np.nan), depth), tuple(notes)


def _confidence(
    given: Picture, least: float | None, shape: Size
) -> tuple[NDArray[np.float32], float]:
    """Return the confidence of each pixel of a depth map, and the least that counts."""
    sure = values_given(given)
    if sure.ndim == 3 and sure.shape[2] == 1:
        sure = sure[..., 0]
    if sure.ndim != 2 or sure.dtype.kind not in "biuf" or sure.size == 0:
        raise GeohueError(
            f"the confidence has shape {sure.shape} and type {sure.dtype}: expected a number for "
            "each pixel of the depth map"
        )
    if not same_shape(sure.shape, shape):
        raise GeohueError(
            f"the confidence is {_size(sure.shape)}, the depth map {_size(shape)}: "
            "give the one that belongs to it"
        )
    values = sample_nearest(sure.astype(np.float32), shape)
    return values, float(np.nanmax(values)) / 2 if least is None else least


def _sized(camera: Intrinsics | None, image: tuple[int, ...], depth: Size) -> Intrinsics | None:
    """Say which of two sizes a camera is for, where it does not say so itself."""
    if camera is None or camera.width is not None or image[:2] == depth:
        return camera
    for height, width in (image[:2], depth):
        if abs(2 * camera.cx / width - 1) < _CENTRED and abs(2 * camera.cy / height - 1) < _CENTRED:
            return replace(camera, width=width, height=height)
    return camera


def _turned(
    colors: NDArray[np.uint8],
    depth: NDArray[np.float32],
    camera: Intrinsics | None,
    orientation: int,
) -> tuple[NDArray[np.uint8], NDArray[np.float32], Intrinsics | None, Notes]:
    """Turn a picture as its mark says, with what was recorded the same way."""
    if orientation == 1:
        return colors, depth, camera, ()
    height, width = colors.shape[:2]
    seen = (width, height) if swaps_sides(orientation) else (height, width)
    together = same_shape(depth.shape, (height, width))
    if not together and not same_shape(depth.shape, seen):
        return colors, depth, camera, ()  # which `_fitted` refuses
    parts = ["the picture"]
    if together:
        depth = upright(depth, orientation)
        parts.append("its depth map")
    if camera is not None and not _is_upright(camera, seen, (height, width), together):
        wide, high = camera.width or width, camera.height or height
        camera = upright_camera(camera, orientation, wide, high)
        parts.append("the intrinsics")
    said = " and ".join([", ".join(parts[:-1]), parts[-1]] if parts[1:] else parts)
    note = f"{said} turned upright, as the picture's mark (EXIF orientation {orientation}) says"
    return upright(colors, orientation), depth, camera, (note,)


def _is_upright(camera: Intrinsics, seen: Size, stored: Size, together: bool) -> bool:
    """Whether a camera is that of the turned picture, by its size, else as the depth map is."""
    if camera.width is None or camera.height is None:
        return not together
    own = camera.height, camera.width
    return same_shape(own, seen) and (not same_shape(own, stored) or not together)


def _fitted(
    depth: NDArray[np.float32], shape: Size, rgb: Picture, given: Picture
) -> tuple[NDArray[np.float32], str]:
    """Scale a depth map to its picture, or ask for registration."""
    sizes = f"{_size(shape)} and {_size(depth.shape)}"
    if not same_shape(depth.shape, shape):
        who = "image and depth differ"
        if is_path(rgb) and is_path(given):
            who = f"{given!s}: differs in shape from {rgb!s}"
        raise GeohueError(
            f"{who}: {sizes}; register the depth to the image first (geohue register, "
            "geohue.sensors.register_depth)"
        )
    note = (
        f"the depth map of {_size(depth.shape)} is taken to show the view of the image and scaled "
        f"to its {_size(shape)}; register it first if it does not"
    )
    return scale_depth(depth, shape), note


def _view_doubts(camera: Intrinsics, shape: Size) -> Notes:
    """Return a warning where the camera's field of view is implausible for the image."""
    height, width = shape
    wide, high = (
        float(np.degrees(2 * np.arctan(n / (2 * f))))
        for n, f in ((width, camera.fx), (height, camera.fy))
    )
    centred = 0 <= camera.cx < width and 0 <= camera.cy < height
    if centred and all(_PLAUSIBLE_VIEW[0] <= angle <= _PLAUSIBLE_VIEW[1] for angle in (wide, high)):
        return ()
    return (
        f"the intrinsics see {wide:.0f} x {high:.0f} degrees with the axis at ({camera.cx:.0f}, "
        f"{camera.cy:.0f}) of {width} x {height}: implausible; are they for another size?",
    )


def _size(shape: tuple[int, ...]) -> str:
    return f"{shape[1]} x {shape[0]}"


def mask_given(given: Picture, shape: Size, orientation: int = 1) -> NDArray[np.bool_]:
    """Return a mask in the size of an image that may have been turned: what to keep."""
    values = values_given(given)
    mask = np.asarray(values[..., :3].any(axis=-1) if values.ndim == 3 else values)
    if mask.ndim != 2 or mask.dtype.kind not in "biuf" or mask.size == 0:
        raise GeohueError(
            f"the mask has shape {mask.shape} and type {mask.dtype}: expected (H, W) numbers, 0 "
            "where the image is to be left out"
        )
    if orientation != 1 and not same_shape(mask.shape, shape):
        mask = upright(mask, orientation)
    if not same_shape(mask.shape, shape):
        raise GeohueError(
            f"the mask is {_size(mask.shape)}, the image {_size(shape)}: give one of its shape"
        )
    return sample_nearest(mask != 0, shape)
