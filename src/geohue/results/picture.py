"""Segmentations as pictures: a fixed palette that colour-blind people can read, and overlays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.scene import Scene

# Okabe and Ito (2008) without black, then Tol's muted scheme: safe for colour-blind readers.
_BASE = (
    "0072B2 E69F00 009E73 CC79A7 56B4E9 D55E00 F0E442 "
    "332288 88CCEE 117733 999933 DDCC77 CC6677 882255 AA4499"
)

NO_LABEL = (40, 40, 40)
"""Colour of pixels without a label."""

_VIEW_SIZE = 640


def palette(n: int) -> NDArray[np.uint8]:
    """Colours of segments 0 to ``n - 1``, the same in every picture.

    Parameters
    ----------
    n : int
        How many; from the 16th on, the colours repeat darker, then lighter.

    Returns
    -------
    (n, 3) uint8

    Examples
    --------
    >>> palette(2).tolist()
    [[0, 114, 178], [230, 159, 0]]
    """
    base = np.array([list(bytes.fromhex(code)) for code in _BASE.split()], np.float64)
    turn = np.arange(n) // len(base) % 3
    colors = base[np.arange(n) % len(base)]
    mix = np.array([0.0, 0.4, 0.5])[turn][:, None]
    target = np.array([0.0, 0.0, 255.0])[turn][:, None]
    return np.asarray((colors * (1 - mix) + target * mix).round(), np.uint8)


def paint(labels: NDArray[np.int32]) -> NDArray[np.uint8]:
    """Show labels in the palette.

    Parameters
    ----------
    labels : (...) int32
        -1 for none.

    Returns
    -------
    (..., 3) uint8

    Examples
    --------
    >>> paint(np.array([0, -1], np.int32)).tolist()
    [[0, 114, 178], [40, 40, 40]]
    """
    colors = palette(int(labels.max(initial=-1)) + 1)
    table = np.concatenate([colors, np.array([NO_LABEL], np.uint8)])  # -1 is the last row
    return np.asarray(table[labels])


def overlay(image: NDArray[np.uint8], labels: NDArray[np.int32]) -> NDArray[np.uint8]:
    """Tint each segment of an image and draw the borders between segments.

    Parameters
    ----------
    image : (H, W, 3) uint8
        The scene.
    labels : (H, W) int32
        -1 for none.

    Returns
    -------
    (H, W, 3) uint8
    """
    # The colours repeat, so that a small table has all that a pixel may become.
    repeat = 3 * len(_BASE.split())
    colors = np.concatenate([palette(repeat), np.array([NO_LABEL], np.uint8)])  # the last is -1
    grey = 0.45 * (np.arange(3 * 255 + 1, dtype=np.float32) / 3)
    table = (grey[:, None] + (0.55 * colors)[:, None]).round().astype(np.uint8)
    place = np.arange(int(labels.max(initial=-1)) + 2, dtype=np.int32) % repeat
    place[-1] = repeat
    out = np.empty(image.shape, np.uint8)
    for rows in _bands(image.shape[0]):
        total = image[rows].astype(np.uint16)
        total = total[..., 0] + total[..., 1] + total[..., 2]
        out[rows] = table.reshape(-1, 3).take(place[labels[rows]] * len(grey) + total, axis=0)
    border = np.zeros(labels.shape, bool)
    border[:, 1:] |= labels[:, 1:] != labels[:, :-1]
    border[1:] |= labels[1:] != labels[:-1]
    out[border] = 255
    return out


def _bands(height: int) -> list[slice]:
    """Rows that are worked on at a time, so that what is made of them stays in the cache."""
    return [slice(y, y + 64) for y in range(0, height, 64)]


def picture(scene: Scene, labels: NDArray[np.int32]) -> NDArray[np.uint8]:
    """Show a segmented scene: the scene on the left, its segments on the right.

    A cloud without a grid is seen along the direction in which it is thinnest.

    Parameters
    ----------
    scene : Scene
    labels : shape of the scene, int32

    Returns
    -------
    (H, 2 W, 3) uint8
    """
    if scene.is_grid:
        return np.hstack([scene.colors, overlay(scene.colors, labels)])
    view = _face_view(scene)
    background = np.full((*view.shape, 3), 255, np.uint8)
    left, right = background.copy(), background
    seen = view >= 0
    left[seen] = scene.colors[view[seen]]
    right[seen] = paint(labels)[view[seen]]
    return np.hstack([left, right])


def _face_view(scene: Scene) -> NDArray[np.int64]:
    """Project a cloud along its thinnest axis; returns the nearest point of each pixel, or -1."""
    index = np.flatnonzero(scene.valid)
    if len(index) == 0:
        return np.full((_VIEW_SIZE, _VIEW_SIZE), -1)
    points = scene.points[index].astype(np.float64)
    points -= np.median(points, axis=0)
    # Strays of a photogrammetric cloud must not shrink the view of its body.
    reach = np.quantile(np.linalg.norm(points, axis=1), 0.98) or 1.0
    body = np.linalg.norm(points, axis=1) <= 1.2 * reach
    index, points = index[body], points[body]
    thinned = points[:: max(1, len(points) // 5000)]
    # Two points do not span space, and all of U would be 200 MB for 5000.
    _, _, axes = np.linalg.svd(thinned, full_matrices=len(thinned) < 3)
    flat = points @ axes.T
    scale = (_VIEW_SIZE - 6) / max(float(np.ptp(flat[:, :2], axis=0).max()), 1e-30)
    place = ((flat[:, :2] - flat[:, :2].min(axis=0)) * scale).astype(np.int64)
    width, height = (place.max(axis=0) + 5).tolist()
    # Points of one layer just about touch.
    dot = int(np.clip(np.ceil(np.sqrt(width * height / len(points))), 1, 4))
    order = np.argsort(flat[:, 2], kind="stable")
    view = np.full((height, width), -1)
    for dy in range(dot):
        for dx in range(dot):
            view[place[order, 1] + dy, place[order, 0] + dx] = index[order]
    return view
