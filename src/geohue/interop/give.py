"""Segments as things of the kind that the scene came from."""

from __future__ import annotations

import copy
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.interop.kinds import Kind, kind_of, points_in
from geohue.interop.ros import with_field, with_pixels
from geohue.results.picture import paint
from geohue.segmentation.result import Segmentation

NAME = "segment"
"""What the labels are called in a thing that has names for values."""

Labels = NDArray[np.int32]


def labelled(thing: Any, seg: Segmentation | Labels) -> Any:
    """Return a copy of a thing with the labels of its points.

    Parameters
    ----------
    thing : object
        What `as_scene` made the scene of.
    seg : Segmentation or integer array
        Its segments, a label for each point in its order.

    Returns
    -------
    object
        Of the same kind. Labels are int32, -1 = none:

        - Open3D ``PointCloud``: painted in the colours of the segments, as it has no place for
          labels; the tensor one: ``point["segment"]``.
        - pyvista: point data ``segment``. laspy: extra dimension ``segment``.
        - trimesh: ``metadata["segment"]``, the points painted.
        - ROS ``PointCloud2``: a further field ``segment``; ``Image``: ``16UC1``, 0 = no label,
          segments from 1, as in ``labels.png``.
        - RGBDImage, torch tensor, array: the labels themselves as an array, for a tensor as one on
          its device.

    Raises
    ------
    GeohueError
        If the thing is nothing that is known, or has another number of points.

    Examples
    --------
    >>> labelled(np.zeros((2, 3)), np.array([1, 0])).tolist()
    [1, 0]
    """
    labels = np.asarray(getattr(seg, "labels", seg)).astype(np.int32)
    kind = kind_of(thing)
    if kind == "scene":
        raise GeohueError("a Scene has no place for labels: they are in seg.labels")
    if kind == "ros-image":
        return with_pixels(thing, (_image(thing, labels) + 1).astype(np.uint16))
    if kind == "rgbd":
        return _image(np.asarray(thing.depth), labels)
    if kind in ("tensor", "array") and labels.ndim == 2:
        return _plain(thing, kind, labels)
    n = int(np.prod(points_in(thing, kind).points.shape[:-1]))
    if labels.size != n:
        raise GeohueError(f"{labels.size} labels for {n} points: segment as_scene(thing)")
    return _GIVERS[kind](thing, labels.reshape(-1))


def _image(thing: Any, labels: Labels) -> Labels:
    size = thing.shape if isinstance(thing, np.ndarray) else (thing.height, thing.width)
    if labels.shape != tuple(size):
        raise GeohueError(f"labels have shape {labels.shape}, the image {tuple(size)}")
    return labels


def _plain(thing: Any, kind: Kind, labels: Labels) -> Any:
    if tuple(thing.shape[:2]) != labels.shape:
        raise GeohueError(f"labels have shape {labels.shape}, the rows {tuple(thing.shape[:2])}")
    return _tensor(thing, labels) if kind == "tensor" else labels


def _tensor(thing: Any, labels: Labels) -> Any:
    # The library is there, as the tensor is one of its own.
    return import_module(type(thing).__module__.split(".")[0]).as_tensor(
        labels, device=thing.device
    )


def _open3d(cloud: Any, labels: Labels) -> Any:
    made = copy.copy(cloud)
    # Open3D's own vector of numbers, whose type the points have too.
    made.colors = type(cloud.points)(paint(labels).astype(np.float64) / 255)
    return made


def _open3d_tensor(cloud: Any, labels: Labels) -> Any:
    made = cloud.clone()
    positions = made.point["positions"]
    made.point[NAME] = type(positions)(labels[:, None].copy())
    return made


def _pyvista(mesh: Any, labels: Labels) -> Any:
    made = mesh.copy()
    made.point_data[NAME] = labels
    return made


def _laspy(cloud: Any, labels: Labels) -> Any:
    made = type(cloud)(copy.deepcopy(cloud.header))
    made.points = cloud.points.copy()
    if NAME not in set(made.point_format.dimension_names):
        laspy = import_module(type(cloud).__module__.split(".")[0])
        made.add_extra_dim(laspy.ExtraBytesParams(name=NAME, type=np.int32))
    made[NAME] = labels
    return made


def _trimesh(cloud: Any, labels: Labels) -> Any:
    made = cloud.copy()
    made.metadata[NAME] = labels
    colors = np.concatenate([paint(labels), np.full((len(labels), 1), 255, np.uint8)], axis=1)
    if hasattr(made, "visual"):
        made.visual.vertex_colors = colors
    else:
        made.colors = colors
    return made


_GIVERS: dict[Kind, Any] = {
    "open3d": _open3d,
    "open3d-tensor": _open3d_tensor,
    "pyvista": _pyvista,
    "laspy": _laspy,
    "trimesh": _trimesh,
    "ros-cloud": lambda message, labels: with_field(message, NAME, labels),
    "tensor": _tensor,
    "array": lambda _, labels: labels,
}
