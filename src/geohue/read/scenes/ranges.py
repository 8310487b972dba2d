"""From the files of a range sensor and its colour cameras to a scene (Sec. VI-A)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

from geohue.read.cameras.rig import read_rig
from geohue.read.clouds.cloud import read_cloud
from geohue.read.files import broken
from geohue.read.images.pictures import read_color
from geohue.read.images.raw_depth import read_range
from geohue.read.scenes.scenes import is_cloud
from geohue.scene import Scene


def read_range_scene(
    source: str | Path,
    images: Sequence[str | Path],
    calib: Sequence[str | Path],
    depth_scale: float | str | None = None,
    views: Literal[1, 2] = 2,
) -> Scene:
    """Read range data and the pictures of calibrated cameras as one scene.

    Parameters
    ----------
    source : path-like
        The depth picture or raw disparities of the rig's depth camera, or a cloud in the frame of
        the range sensor (KITTI's .bin, .ply ...), whose own colours are not used.
    images : sequence of path-like
        A picture of each camera, in the calibration's order.
    calib : sequence of path-like
        The calibration (`geohue.read.cameras.rig.read_rig`).
    depth_scale : float or str, optional
        Unit of a depth picture.
    views : {1, 2}
        As `Scene.from_range_and_cameras`.

    Returns
    -------
    Scene

    Raises
    ------
    GeohueError
        If a file cannot be read, or they do not fit together.
    """
    if not images:
        raise broken(source, "needs at least one picture of a calibrated camera")
    rig = read_rig(*calib)
    pictures = [read_color(image) for image in images]
    if is_cloud(source):
        cloud = read_cloud(source)
        if cloud.offset.any():
            place = ", ".join(f"{value:.6g}" for value in cloud.offset)
            raise broken(source, f"is in map coordinates ({place}); give it in the sensor's frame")
        return Scene.from_range_and_cameras(cloud.points, pictures, rig, views)
    depth = read_range(source, rig, depth_scale)
    scene = Scene.from_range_and_cameras(depth.depth, pictures, rig, views)
    return replace(scene, warnings=(*depth.warnings, *scene.warnings))
