"""Things of other libraries as scenes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics
from geohue.errors import GeohueError
from geohue.interop.kinds import Kind, kind_of, points_in
from geohue.scene import Scene

_GREY = 128
_MESSAGE = Path("image message")


def as_scene(
    thing: Any,
    depth: Any = None,
    intrinsics: Any = None,
    *,
    depth_scale: float | None = None,
) -> Scene:
    """Make a scene of a thing of another library.

    Parameters
    ----------
    thing : object
        A cloud: `open3d.geometry.PointCloud` or that of `open3d.t`, `trimesh.PointCloud` or a
        mesh's vertices, `pyvista.PolyData` or another data set (colours in the point data
        ``RGB``), `laspy.LasData`, a ROS ``PointCloud2`` message, a torch tensor or an array with
        rows of x, y, z, or these and red, green, blue, or these and a normal. Or a frame:
        `open3d.geometry.RGBDImage`; a ROS ``Image``, a tensor or an array of colours together with
        `depth`. A `Scene` stays as it is.
    depth : object, optional
        The depth of the frame: a ROS ``Image``, a tensor or an array.
    intrinsics : object, optional
        The camera of a frame: `Intrinsics`, Open3D's ``PinholeCameraIntrinsic``, a ROS
        ``CameraInfo`` message, or a 3 x 3 array.
    depth_scale : float, optional
        Metres per unit of a depth map of whole numbers.

    Returns
    -------
    Scene
        Its points are those of the thing, in their order. Points without colours are grey.

    Raises
    ------
    GeohueError
        If the thing is nothing that is known, or its arrays do not fit together.

    Examples
    --------
    >>> as_scene(np.array([[0.0, 0, 1, 1.0, 0, 0], [0, 1, 1, 0, 0, 1.0]])).colors.tolist()
    [[255, 0, 0], [0, 0, 255]]
    """
    if isinstance(thing, Scene):
        return thing
    kind = kind_of(thing)
    if kind == "rgbd":
        return _frame(np.asarray(thing.color), np.asarray(thing.depth), intrinsics, depth_scale)
    if depth is not None or kind == "ros-image":
        if depth is None:
            raise GeohueError("an image message alone has no depth: give as_scene(color, depth)")
        color = _pixels(thing, kind)
        return _frame(color, _depth(depth), intrinsics, depth_scale)
    found = points_in(thing, kind)
    colors = np.full(found.points.shape, _GREY, np.uint8)
    if found.colors is not None:
        colors = _eight_bits(found.colors)
    return Scene.from_cloud(found.points, colors, found.normals)


def _frame(color: NDArray[Any], depth: NDArray[Any], intrinsics: Any, scale: float | None) -> Scene:
    if color.ndim == 2 and color.dtype.kind == "f":  # Open3D's intensities
        color = np.repeat(_eight_bits(color)[..., None], 3, axis=2)
    camera = _camera(intrinsics)
    return Scene.from_rgbd(_eight_bits(color), depth, camera, depth_scale=scale)


def _pixels(thing: Any, kind: Kind) -> NDArray[Any]:
    if kind == "ros-image":
        from geohue.datasets.ros import decode_color

        return decode_color(thing, _MESSAGE)
    return np.asarray(thing.detach().cpu().numpy() if kind == "tensor" else thing)


def _depth(thing: Any) -> NDArray[Any]:
    kind = kind_of(thing)
    if kind == "ros-image":
        from geohue.datasets.ros import decode_depth

        return decode_depth(thing, _MESSAGE)
    return _pixels(thing, kind)


def _camera(given: Any) -> Intrinsics | None:
    """Read a camera, by its attributes."""
    if given is None or isinstance(given, Intrinsics):
        return given
    matrix = getattr(given, "intrinsic_matrix", None)
    if matrix is None:
        matrix = getattr(given, "k", getattr(given, "K", given))
    values = np.asarray(matrix, np.float64)
    if values.size != 9:
        raise GeohueError(f"intrinsics {given!r}: expected Intrinsics or a 3 x 3 matrix")
    fx, _, cx, _, fy, cy = values.reshape(-1)[:6].tolist()
    size = [getattr(given, side, None) for side in ("width", "height")]
    width, height = (int(side) if side else None for side in size)
    return Intrinsics(fx, fy, cx, cy, width, height)


def _eight_bits(colors: NDArray[Any]) -> NDArray[Any]:
    """Colours as 8 bits: floats in 0..1 or 0..255, and whole numbers of any type up to 255."""
    if colors.dtype == np.uint8:
        return colors
    top = float(np.nanmax(colors, initial=0.0))
    low = float(np.nanmin(colors, initial=0.0))
    if low < 0 or top > 255:
        raise GeohueError(f"colours from {low:g} to {top:g}: expected 0 to 1, or 0 to 255")
    unit = 255.0 if colors.dtype.kind == "f" and top <= 1 else 1.0
    return np.nan_to_num(colors * unit).round().astype(np.uint8)
