"""What a thing is, by its attributes, and the arrays in it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.interop.ros import cloud_fields

Kind = Literal[
    "scene",
    "open3d",
    "open3d-tensor",
    "rgbd",
    "pyvista",
    "laspy",
    "trimesh",
    "ros-cloud",
    "ros-image",
    "tensor",
    "array",
]


class Points(NamedTuple):
    """A cloud as arrays: (N, 3) or (H, W, 3) each, None where there is nothing."""

    points: NDArray[Any]
    colors: NDArray[Any] | None
    normals: NDArray[Any] | None


_MARKS: dict[Kind, tuple[str, ...]] = {
    "scene": ("colors", "points", "is_grid", "thinning"),
    "open3d": ("points", "colors", "has_colors", "has_normals"),
    "open3d-tensor": ("point", "get_min_bound", "to_legacy"),
    "rgbd": ("color", "depth", "is_empty"),
    "pyvista": ("points", "point_data", "n_points"),
    "laspy": ("xyz", "point_format", "header"),
    "trimesh": ("vertices", "metadata", "bounds"),
    "ros-cloud": ("fields", "point_step", "row_step", "data"),
    "ros-image": ("encoding", "step", "is_bigendian", "data"),
    "tensor": ("detach", "cpu", "numpy"),
}


def kind_of(thing: Any) -> Kind:
    """Return what a thing is.

    Raises
    ------
    GeohueError
        If it is nothing that is known.

    Examples
    --------
    >>> kind_of(np.zeros((4, 6)))
    'array'
    """
    if isinstance(thing, np.ndarray):
        return "array"
    for kind, marks in _MARKS.items():
        if all(hasattr(thing, mark) for mark in marks):
            return kind
    name = f"{type(thing).__module__}.{type(thing).__qualname__}"
    raise GeohueError(
        f"{name} is nothing that is known: give a cloud of Open3D, trimesh, pyvista, laspy or ROS, "
        "an (N, 6) array or tensor, or an RGBDImage"
    )


def points_in(thing: Any, kind: Kind) -> Points:
    """Return the cloud that a thing holds."""
    readers = {
        "open3d": _open3d,
        "open3d-tensor": _open3d_tensor,
        "pyvista": _pyvista,
        "laspy": _laspy,
        "trimesh": _trimesh,
        "ros-cloud": _ros_cloud,
        "tensor": lambda tensor: _rows(_numpy(tensor)),
        "array": _rows,
    }
    if kind not in readers:
        raise GeohueError(f"a thing of kind {kind} is no cloud")
    return readers[kind](thing)


def _open3d(cloud: Any) -> Points:
    colors = np.asarray(cloud.colors) if cloud.has_colors() else None
    normals = np.asarray(cloud.normals) if cloud.has_normals() else None
    return Points(np.asarray(cloud.points), colors, normals)


def _open3d_tensor(cloud: Any) -> Points:
    parts = {name: _numpy(cloud.point[name]) for name in cloud.point}
    return Points(parts["positions"], parts.get("colors"), parts.get("normals"))


def _pyvista(mesh: Any) -> Points:
    data: Mapping[str, Any] = mesh.point_data
    names = {str(name).lower(): name for name in data.keys()}  # noqa: SIM118, no plain mapping
    found = [names[name] for name in ("rgb", "rgba", "colors", "color") if name in names]
    colors = np.asarray(data[found[0]])[:, :3] if found else None
    normals = np.asarray(data[names["normals"]]) if "normals" in names else None
    return Points(np.asarray(mesh.points), colors, normals)


def _laspy(cloud: Any) -> Points:
    names = set(cloud.point_format.dimension_names)
    if not {"red", "green", "blue"} <= names:
        return Points(np.asarray(cloud.xyz), None, None)
    colors = np.stack([np.asarray(cloud[name]) for name in ("red", "green", "blue")], axis=1)
    wide = int(colors.max(initial=0)) > 255  # 16 bits by the standard, 8 in many files
    return Points(np.asarray(cloud.xyz), (colors >> (8 if wide else 0)).astype(np.uint8), None)


def _trimesh(cloud: Any) -> Points:
    colors = getattr(cloud, "colors", None)
    if colors is None:
        colors = getattr(getattr(cloud, "visual", None), "vertex_colors", None)
    colors = None if colors is None or len(colors) == 0 else np.asarray(colors)[:, :3]
    return Points(np.asarray(cloud.vertices), colors, None)


def _ros_cloud(message: Any) -> Points:
    fields = cloud_fields(message)
    points = np.stack([fields[axis] for axis in "xyz"], axis=-1)
    packed = fields.get("rgb", fields.get("rgba"))
    if packed is None:
        return Points(points, None, None)
    bits = np.ascontiguousarray(packed).view(np.uint32)
    return Points(points, np.stack([bits >> 16, bits >> 8, bits], axis=-1).astype(np.uint8), None)


def _rows(rows: NDArray[Any]) -> Points:
    """Take x, y, z and red, green, blue (and nx, ny, nz) of each row."""
    if rows.ndim not in (2, 3) or rows.shape[-1] not in (3, 6, 9):
        raise GeohueError(
            f"an array of shape {rows.shape}: expected rows of x, y, z, or these and red, green, "
            "blue (0 to 1, or 0 to 255), or these and a normal"
        )
    colors = rows[..., 3:6] if rows.shape[-1] >= 6 else None
    return Points(rows[..., :3], colors, rows[..., 6:9] if rows.shape[-1] == 9 else None)


def _numpy(tensor: Any) -> NDArray[Any]:
    there = tensor.detach() if hasattr(tensor, "detach") else tensor
    return np.asarray(there.cpu().numpy())
