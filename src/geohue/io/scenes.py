"""From files to a scene, the kind of input guessed from what is given."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

from geohue.camera import Intrinsics
from geohue.errors import GeohueError, GeohueWarning
from geohue.io.cloud import read_cloud
from geohue.io.files import broken
from geohue.io.images import read_color, read_depth
from geohue.io.intrinsics import read_intrinsics
from geohue.scene import Scene

CLOUD_SUFFIXES = (".ply", ".pcd")
"""Endings of the files that are read as clouds."""


def read_scene(
    source: str | Path,
    depth: str | Path | None = None,
    intrinsics: str | Path | None = None,
    depth_scale: float | str | None = None,
) -> Scene:
    """Read an RGB-D frame, a coloured cloud, or an image alone.

    Parameters
    ----------
    source : str or Path
        A cloud (.ply, .pcd), or the colour image.
    depth : str or Path, optional
        The depth map registered to the colour image.
    intrinsics : str or Path, optional
        A camera file or "fx,fy,cx,cy" (`read_intrinsics`).
    depth_scale : float or str, optional
        Metres per unit of the depth map, or a name such as "tum" (`DEPTH_UNITS`); by default what the camera file says, else 0.001 for
        integers and 1 for floats.

    Returns
    -------
    Scene
        Its `warnings` tell every guess that was made.

    Raises
    ------
    GeohueError
        If a file cannot be read or the files do not fit together.
    """
    if Path(source).suffix.lower() in CLOUD_SUFFIXES:
        if depth is not None:
            raise broken(source, f"is a cloud and has its own geometry; leave out {depth}")
        return _cloud_scene(source)
    colors = read_color(source)
    if depth is None:
        return Scene.from_image(colors)
    if Path(depth).suffix.lower() in CLOUD_SUFFIXES:
        raise broken(depth, f"is a cloud; give it alone, without {source}")
    camera, notes = (None, ()) if intrinsics is None else _camera(intrinsics)
    if depth_scale is None and camera is not None and camera.depth_scale is not None:
        depth_scale = 1 / camera.depth_scale
    image = read_depth(depth, depth_scale)
    if image.depth.shape != colors.shape[:2]:
        sizes = " and ".join(f"{a.shape[1]} x {a.shape[0]}" for a in (image.depth, colors))
        raise broken(
            depth, f"differs in size from {source}: {sizes}; register the depth to the image first"
        )
    scene = Scene.from_rgbd(colors, image.depth, camera)
    return replace(scene, warnings=(*notes, *image.warnings, *scene.warnings))


def _camera(source: str | Path) -> tuple[Intrinsics, tuple[str, ...]]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", GeohueWarning)
        camera = read_intrinsics(source)
    return camera, tuple(str(w.message) for w in caught)


def _cloud_scene(path: str | Path) -> Scene:
    cloud = read_cloud(path)
    if cloud.colors is None:
        raise broken(path, "has no colours; export the cloud with red, green and blue")
    try:
        scene = Scene.from_cloud(cloud.points, cloud.colors)
    except GeohueError as error:
        raise broken(path, str(error)) from error
    if not cloud.offset.any():
        return scene
    place = ", ".join(f"{value:.10g}" for value in cloud.offset)
    return replace(
        scene, warnings=(*scene.warnings, f"{path}: coordinates are relative to ({place})")
    )
