"""How well a depth map lies on its colour picture, measured at their edges."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError

_JUMP = 0.1  # relative difference of depth that is an edge of an object
_GAP = 12  # pixels without depth across which an edge is looked for


def edge_agreement(
    rgb: NDArray[np.uint8], depth: NDArray[np.floating[Any]], shift: tuple[int, int] = (0, 0)
) -> float:
    """Measure how much stronger the colour edges are at the depth edges than elsewhere.

    Objects end in colour where they end in depth. The colour gradient (smoothed by one pixel) at
    the pixels of near surfaces beside others at least 10 % farther (also across a gap of up to 12
    pixels: the shadow of an object) is divided by its mean over all pixels with depth.

    Parameters
    ----------
    rgb : (H, W, 3) uint8
        The colour picture.
    depth : (H, W) float
        Its depth map, NaN where missing.
    shift : (int, int)
        Columns and rows by which the depth map is moved first, to see whether it would lie
        better elsewhere.

    Returns
    -------
    float
        1 for a depth map that has nothing to do with the picture, more where edges agree; NaN
        without any depth edge.

    Raises
    ------
    GeohueError
        If the sizes differ.

    Examples
    --------
    >>> rgb = np.zeros((20, 40, 3), np.uint8)
    >>> rgb[:, 20:] = 200
    >>> depth = np.where(np.arange(40) < 20, 1.0, 2.0)[None].repeat(20, 0)
    >>> edge_agreement(rgb, depth) > 5 * edge_agreement(rgb, depth, (6, 0))
    True
    """
    import cv2

    if rgb.shape[:2] != depth.shape:
        raise GeohueError(f"picture {rgb.shape} and depth {depth.shape} differ in size")
    smooth = cv2.GaussianBlur(rgb, (0, 0), 1.0).astype(np.float32)
    strength = np.zeros(depth.shape)
    for axis in (0, 1):
        strength += (np.gradient(smooth, axis=axis) ** 2).sum(axis=-1)
    strength = np.sqrt(strength)
    moved = np.full(depth.shape, np.nan, np.float32)
    dx, dy = shift
    moved[_slice(dy), _slice(dx)] = depth[_slice(-dy), _slice(-dx)]
    edges = _edges(moved)
    known = np.isfinite(moved)
    mean = float(strength[known].mean()) if known.any() else 0.0
    return float(strength[edges].mean() / mean) if edges.any() and mean > 0 else float("nan")


def _slice(offset: int) -> slice:
    return slice(offset, None) if offset >= 0 else slice(None, offset)


def _edges(depth: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Return the pixels of near surfaces beside farther ones, across gaps of a few pixels."""
    edges = np.zeros(depth.shape, bool)
    for turn in range(4):  # right, then the other three directions
        turned = np.rot90(depth, turn)
        following = _next_known(turned)
        with np.errstate(invalid="ignore"):
            jump = following > (1 + _JUMP) * turned
        edges |= np.rot90(jump, -turn)
    return edges


def _next_known(depth: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the next known depth to the right of each pixel, NaN if it is farther than a gap."""
    width = depth.shape[1]
    columns = np.where(np.isfinite(depth), np.arange(width), width)
    after = np.full(depth.shape, width)
    after[:, :-1] = np.minimum.accumulate(columns[:, :0:-1], axis=1)[:, ::-1]
    near = after - np.arange(width) <= _GAP
    found = np.take_along_axis(depth, np.minimum(after, width - 1), axis=1)
    return np.where(near & (after < width), found, np.nan)
