"""Segments in the viewer rerun. Needs ``pip install rerun-sdk``."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np

from geohue.errors import GeohueError
from geohue.results.picture import paint
from geohue.segmentation.result import Segmentation


def log(seg: Segmentation, path: str = "scene", recording: Any = None, boxes: bool = True) -> None:
    """Log the points of a scene with their segments, the label image and the oriented boxes.

    Parameters
    ----------
    seg : Segmentation
        With its scene.
    path : str
        Where in the recording: ``path/points``, ``path/labels`` and ``path/boxes``.
    recording : rerun.RecordingStream, optional
        By default the one that `rerun.init` made.
    boxes : bool
        Whether to log the boxes.

    Raises
    ------
    GeohueError
        If rerun is not installed, or the segmentation has no scene.
    """
    try:
        rr = import_module("rerun")
    except ImportError as error:
        raise GeohueError("logging to rerun needs it: pip install rerun-sdk") from error
    measured = seg.segments.measured
    scene, given = measured.scene, {"recording": recording}
    known = np.isfinite(scene.points[..., 2])
    labels = seg.labels[known]
    if known.any():
        points = rr.Points3D(scene.points[known], colors=paint(labels), class_ids=labels + 1)
        rr.log(f"{path}/points", points, **given)
    if scene.is_grid:
        rr.log(f"{path}/color", rr.Image(scene.colors), **given)
        image = rr.SegmentationImage((seg.labels + 1).astype(np.uint16))
        rr.log(f"{path}/labels", image, **given)
    there = np.isfinite(measured.boxes.center[:, 0])
    if boxes and there.any():
        found = measured.boxes
        rr.log(
            f"{path}/boxes",
            rr.Boxes3D(
                centers=found.center[there],
                sizes=found.size[there],
                quaternions=quaternions(found.axes[there]),
                colors=paint(np.flatnonzero(there).astype(np.int32)),
            ),
            **given,
        )


def quaternions(axes: np.ndarray[Any, np.dtype[np.float64]]) -> Any:
    """Return the turns that lead x, y and z to the rows of `axes`, (K, 4) as x, y, z, w.

    Examples
    --------
    >>> quaternions(np.eye(3)[None]).tolist()
    [[0.0, 0.0, 0.0, 1.0]]
    """
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(axes.transpose(0, 2, 1)).as_quat()
