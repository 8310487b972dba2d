"""Depth of one camera brought into the view of another (Sec. VI-C)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.sensors.lens import Lens
from geohue.sensors.rig import PosedCamera, Rig
from geohue.sensors.surface import Surface


def register_depth(
    depth: NDArray[np.floating[Any]],
    rig: Rig,
    size: tuple[int, int] | None = None,
    camera: int = 0,
) -> NDArray[np.float32]:
    """Bring an unregistered depth map into the view of a colour camera.

    The surface between the depth pixels is sampled densely enough to leave no gaps in the colour
    view, and the foremost sample of each pixel counts: what the colour camera does not see behind
    a nearer surface disappears. Pixels that the depth camera did not measure, or could not see,
    have no depth.

    Parameters
    ----------
    depth : (H, W) float
        Metres; NaN, infinite and not positive values are missing. Scaled calibrations are used
        where the size differs from that of the calibration.
    rig : Rig
        Depth camera and colour cameras.
    size : (int, int), optional
        Width and height of the colour picture; by default those of its calibration.
    camera : int
        Which of the rig's colour cameras.

    Returns
    -------
    (height, width) float32
        Distance along the colour camera's axis, for its picture as it is (not undistorted).

    Raises
    ------
    GeohueError
        If the rig has no depth camera or no such colour camera, or a size is not known.

    Examples
    --------
    A camera that is its own colour camera sees what it saw:

    >>> from geohue import Intrinsics
    >>> lens = Lens(Intrinsics(50.0, 50.0, 4.5, 2.5, 10, 6))
    >>> depth = np.linspace(1, 2, 60, dtype=np.float32).reshape(6, 10)
    >>> np.allclose(register_depth(depth, Rig((PosedCamera(lens),), lens)), depth)
    True
    """
    view, width, height = color_view(rig, camera, size)
    surface = Surface.from_depth(_clean(depth), rig.depth_lens)
    return surface.seen_from(view, height, width)


def undistorted(rgb: NDArray[np.uint8], lens: Lens) -> NDArray[np.uint8]:
    """Return a picture as a camera without distortion and with the same intrinsics gives it.

    Parameters
    ----------
    rgb : (H, W, 3) or (H, W) uint8
    lens : Lens

    Returns
    -------
    uint8, same shape
        Black where the lens saw nothing.
    """
    import cv2

    height, width = rgb.shape[:2]
    scaled = lens.scaled_to(width, height)
    if scaled.is_straight:
        return rgb
    rays = Lens(scaled.camera).rays(height, width).reshape(-1, 3)
    source = scaled.project(rays).reshape(height, width, 2)
    x, y = (np.nan_to_num(source[..., i], nan=-9.0).astype(np.float32) for i in (0, 1))
    return np.asarray(cv2.remap(np.ascontiguousarray(rgb), x, y, cv2.INTER_LINEAR), np.uint8)


def color_view(rig: Rig, camera: int, size: tuple[int, int] | None) -> tuple[PosedCamera, int, int]:
    """Return the colour camera at a size of picture, and that size."""
    if not 0 <= camera < len(rig.cameras):
        raise GeohueError(f"colour camera {camera}: the rig has {len(rig.cameras)}, from 0")
    chosen = rig.cameras[camera]
    width, height = size or (chosen.lens.camera.width, chosen.lens.camera.height)
    if width is None or height is None:
        raise GeohueError("the calibration has no size of the colour picture: give it")
    return chosen.scaled_to(width, height), width, height


def _clean(depth: NDArray[np.floating[Any]]) -> NDArray[np.float32]:
    metres = np.array(depth, np.float32)
    if metres.ndim != 2 or metres.size == 0:
        raise GeohueError(f"the depth map has shape {metres.shape}: expected (H, W)")
    metres[~(np.isfinite(metres) & (metres > 0))] = np.nan
    return metres
