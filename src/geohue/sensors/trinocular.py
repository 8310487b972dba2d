"""Colours for range points from the cameras beside the sensor (Sec. VI-A)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.sensors.lens import Lens
from geohue.sensors.rig import PosedCamera, Rig
from geohue.sensors.surface import Surface

ColorChoice = Literal["first", "blend"]
COLOR_CHOICES: tuple[ColorChoice, ...] = get_args(ColorChoice)

_HIDDEN = 0.05  # a point this much (relative) behind the foremost surface is hidden
_PARALLAX = 1.5  # pixels
_ENOUGH = 50  # points that both cameras see, to bring their tones together
_MOST_GAIN = 4.0

Bytes = NDArray[np.uint8]
Floats = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class RangeColors:
    """The colours of range points.

    Attributes
    ----------
    colors : uint8, shape of the points
        sRGB, in the tones of the first camera. Points that no camera sees have the colour of the
        nearest point that one sees.
    second_colors : uint8, same shape, or None
        As the second camera sees the points, in its own tones; `colors` in those tones where only
        the first sees them. None if there is one camera.
    seen_by : uint8, shape of the points less the last axis
        Bit i is set where camera i sees the point; 0 where none does.
    warnings : tuple of str
        What the user should know.
    """

    colors: Bytes
    second_colors: Bytes | None
    seen_by: Bytes
    warnings: tuple[str, ...] = ()


def color_range_points(
    points: Floats, images: Sequence[Bytes], rig: Rig, choice: ColorChoice = "first"
) -> RangeColors:
    """Give range points the colours that the cameras see.

    A camera sees a point that lies in its picture and in front of whatever else the sensor
    measured on that line of sight (a z-buffer of the surface between the range points). Pictures
    that are finer than the points are averaged over the area that a point stands for. The second
    camera's tones are brought to those of the first by a gain and an offset for each channel, such
    that the points that both see have the same mean and deviation.

    Parameters
    ----------
    points : (N, 3) or (H, W, 3) float32
        In the frame of the range sensor; NaN where missing.
    images : sequence of (h, w, 3) uint8
        One for each camera of the rig, in its order.
    rig : Rig
        The calibration.
    choice : {"first", "blend"}
        Where several cameras see a point: the colour of the first of them, or the mean of all.

    Returns
    -------
    RangeColors

    Raises
    ------
    GeohueError
        If there are more pictures than cameras, or no camera sees any point.
    """
    if choice not in COLOR_CHOICES:
        raise GeohueError(f"choice {choice!r}: choose one of {', '.join(COLOR_CHOICES)}")
    if not 1 <= len(images) <= len(rig.cameras):
        raise GeohueError(f"{len(images)} picture(s) for {len(rig.cameras)} calibrated camera(s)")
    flat = points.reshape(-1, 3)
    surface, turn = _surface(points, rig)
    seen = np.zeros((len(images), len(flat)), bool)
    sampled = np.zeros((len(images), len(flat), 3), np.float32)
    for i, image in enumerate(images):
        height, width = image.shape[:2]
        camera = rig.cameras[i].scaled_to(width, height)
        seen[i], sampled[i] = _look(flat, image, camera, surface, turn)
    if not seen.any():
        raise GeohueError("no camera sees any range point: check R, T, their unit and direction")
    some: NDArray[np.bool_] = np.asarray(seen.any(axis=0))
    tones = [_tone(sampled[i], sampled[0], seen[i] & seen[0]) for i in range(len(images))]
    colors = _chosen(sampled, seen, tones, choice)
    source = _sources(flat, some)
    second = None
    if len(images) > 1:
        gain, offset = tones[1]
        second = np.where(seen[1][:, None], sampled[1], (colors - offset) / gain)
        second = second[source]
    colors = colors[source]
    bits = (seen.astype(np.uint8) << np.arange(len(images), dtype=np.uint8)[:, None]).sum(axis=0)
    return RangeColors(
        _bytes(colors).reshape(points.shape),
        None if second is None else _bytes(second).reshape(points.shape),
        bits.astype(np.uint8).reshape(points.shape[:-1]),
        rig.warnings,
    )


def _surface(points: Floats, rig: Rig) -> tuple[Surface, NDArray[np.float64]]:
    """Return the sensor's surface and the rotation of its frame against that of the points."""
    if points.ndim == 3 and (rig.depth is not None or np.nanmedian(points[..., 2]) > 0):
        return Surface.from_grid(points), np.eye(3)
    # A scanner's own axes may point anywhere: take those of the first camera, at the scanner.
    turn = rig.cameras[0].rotation
    flat = PosedCamera(rig.cameras[0].lens, turn).transform(points.reshape(-1, 3))
    with np.errstate(invalid="ignore"):
        ahead = flat[:, 2] > 0  # assumes that all cameras look about the same way
    return Surface.from_scan(flat[ahead]), turn


def _look(
    points: Floats, image: Bytes, camera: PosedCamera, surface: Surface, turn: NDArray[np.float64]
) -> tuple[NDArray[np.bool_], Floats]:
    """Return which points a camera sees, and its colours there."""
    import cv2

    height, width = image.shape[:2]
    there = replace(camera, rotation=camera.rotation @ turn.T)
    shrink = max(1.0, surface.gap(there, height, width))
    h, w = max(1, round(height / shrink)), max(1, round(width / shrink))
    small = image
    if shrink > 1:
        small = np.asarray(cv2.resize(image, (w, h), interpolation=cv2.INTER_AREA), np.uint8)
    sized = Lens(replace(camera.lens.camera, width=width, height=height), *_bend(camera.lens))
    camera, there = (replace(c, lens=sized.scaled_to(w, h)) for c in (camera, there))
    front = surface.seen_from(there, h, w)
    seen_at = camera.transform(points)
    place = camera.lens.project(seen_at)
    with np.errstate(invalid="ignore"):
        inside = (place > -0.5).all(axis=1) & (place[:, 0] < w - 0.5) & (place[:, 1] < h - 0.5)
        cell = np.rint(np.where(inside[:, None], place, 0)).astype(np.int64)
        hidden = _is_hidden(seen_at[:, 2], front[cell[:, 1], cell[:, 0]], camera)
    return inside & ~hidden, _sampled(small, np.where(inside[:, None], place, 0))


def _is_hidden(depth: Floats, front: Floats, camera: PosedCamera) -> NDArray[np.bool_]:
    """Tell which points lie behind the foremost surface in their pixel.

    The sensor saw them all, so a surface hides a point only if the way from the sensor to the
    camera moves the two against each other by more than a pixel.
    """
    parallax = camera.lens.camera.fx * np.linalg.norm(camera.translation) * (1 / front - 1 / depth)
    return np.asarray((depth > front * (1 + _HIDDEN)) & (parallax > _PARALLAX))


def _bend(lens: Lens) -> tuple[tuple[float, ...], Literal["brown", "fisheye", "inverse"]]:
    return lens.distortion, lens.model


def _sampled(image: Bytes, place: Floats) -> Floats:
    """Interpolate a picture between pixels."""
    x, y = (np.clip(place[:, i], 0, image.shape[1 - i] - 1) for i in (0, 1))
    left, top = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    right = np.minimum(left + 1, image.shape[1] - 1)
    low = np.minimum(top + 1, image.shape[0] - 1)
    wx, wy = (x - left)[:, None], (y - top)[:, None]
    above = (1 - wx) * image[top, left] + wx * image[top, right]
    below = (1 - wx) * image[low, left] + wx * image[low, right]
    return np.asarray((1 - wy) * above + wy * below, np.float32)


def _tone(colors: Floats, reference: Floats, both: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Return gain and offset that give `colors` the mean and deviation of the reference."""
    gain, offset = np.ones(3, np.float32), np.zeros(3, np.float32)
    if colors is reference or both.sum() < _ENOUGH:
        return gain, offset
    ours, theirs = colors[both], reference[both]
    spread = ours.std(axis=0)
    usable = spread > 1
    gain[usable] = np.clip(theirs.std(axis=0)[usable] / spread[usable], 1 / _MOST_GAIN, _MOST_GAIN)
    offset = np.asarray(theirs.mean(axis=0) - gain * ours.mean(axis=0), np.float32)
    return gain, offset


def _chosen(
    sampled: Floats,
    seen: NDArray[np.bool_],
    tones: Sequence[tuple[Floats, Floats]],
    choice: ColorChoice,
) -> Floats:
    """Return the colour of each point in the first camera's tones; anything where unseen."""
    toned = np.stack(
        [part * gain + offset for part, (gain, offset) in zip(sampled, tones, strict=True)]
    )
    if choice == "blend":
        total = (toned * seen[..., None]).sum(axis=0)
        return np.asarray(total / np.maximum(seen.sum(axis=0), 1)[:, None], np.float32)
    first = seen.argmax(axis=0)
    return np.asarray(toned[first, np.arange(toned.shape[1])], np.float32)


def _sources(points: Floats, seen: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return whose colour each point has: its own, or for unseen points the nearest seen one's."""
    from scipy.spatial import cKDTree

    source = np.arange(len(points))
    source[~seen] = np.flatnonzero(seen)[0]
    lacking = np.flatnonzero(~seen & np.isfinite(points).all(axis=1))
    if len(lacking):
        _, nearest = cKDTree(points[seen]).query(points[lacking])
        source[lacking] = np.flatnonzero(seen)[nearest]
    return source


def _bytes(colors: Floats) -> Bytes:
    return np.asarray(np.clip(np.rint(colors), 0, 255), np.uint8)
