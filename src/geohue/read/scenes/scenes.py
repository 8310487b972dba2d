"""From files to a scene, the kind of input guessed from what is given."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from geohue.errors import GeohueError
from geohue.read.cameras.intrinsics import read_intrinsics
from geohue.read.clouds.cloud import CLOUD_READERS, is_colmap, read_cloud
from geohue.read.files import broken, with_notes
from geohue.read.images.pictures import read_color, read_depth
from geohue.scene import Scene

_PLAUSIBLE_VIEW = (10.0, 150.0)  # degrees


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
        A cloud (`read_cloud`), or the colour image.
    depth : str or Path, optional
        The depth map registered to the colour image.
    intrinsics : str or Path, optional
        A camera file or "fx,fy,cx,cy" (`read_intrinsics`).
    depth_scale : float or str, optional
        Metres per unit of the depth map, or a name such as "tum" (`DEPTH_UNITS`); by
        default what the camera file says, else 0.001 for integers and 1 for floats.

    Returns
    -------
    Scene
        Its `warnings` tell every guess that was made.

    Raises
    ------
    GeohueError
        If a file cannot be read or the files do not fit together.
    """
    if is_cloud(source):
        if depth is not None:
            raise broken(source, f"is a cloud and has its own geometry; leave out {depth}")
        return _cloud_scene(source)
    colors = read_color(source)
    if depth is None:
        return Scene.from_image(colors)
    if Path(depth).suffix.lower() not in (".npy", ".npz") and is_cloud(depth):
        raise broken(depth, f"is a cloud; give it alone, without {source}")
    camera, notes = (None, ()) if intrinsics is None else with_notes(read_intrinsics, intrinsics)
    if depth_scale is None and camera is not None and camera.depth_scale is not None:
        depth_scale = 1 / camera.depth_scale
    image = read_depth(depth, depth_scale)
    if image.depth.shape != colors.shape[:2]:
        sizes = " and ".join(f"{a.shape[1]} x {a.shape[0]}" for a in (image.depth, colors))
        raise broken(
            depth, f"differs in size from {source}: {sizes}; register the depth to the image first"
        )
    scene = Scene.from_rgbd(colors, image.depth, camera)
    doubts = () if camera is None else view_doubts(scene)
    return replace(scene, warnings=(*notes, *image.warnings, *scene.warnings, *doubts))


def is_cloud(path: str | Path) -> bool:
    """Whether a file is read as a cloud, by its name; or a folder, by the model in it."""
    file = Path(path)
    return file.suffix.lower() in CLOUD_READERS or is_colmap(file)


def view_doubts(scene: Scene) -> tuple[str, ...]:
    """Return a warning where the camera's field of view is implausible for the image."""
    camera = scene.intrinsics
    if camera is None:
        return ()
    height, width = scene.shape
    wide, high = (
        float(np.degrees(2 * np.arctan(n / (2 * f))))
        for n, f in ((width, camera.fx), (height, camera.fy))
    )
    centred = 0 <= camera.cx < width and 0 <= camera.cy < height
    if centred and all(_PLAUSIBLE_VIEW[0] <= angle <= _PLAUSIBLE_VIEW[1] for angle in (wide, high)):
        return ()
    return (
        f"the intrinsics see {wide:.0f} x {high:.0f} degrees with the axis at ({camera.cx:.0f}, "
        f"{camera.cy:.0f}) of {width} x {height}: implausible; are they for another size?",
    )


def _cloud_scene(path: str | Path) -> Scene:
    cloud = read_cloud(path)
    if cloud.colors is None:
        raise broken(path, "has no colours; export the cloud with red, green and blue")
    try:
        scene = Scene.from_cloud(cloud.points, cloud.colors, cloud.normals)
    except GeohueError as error:
        raise broken(path, str(error)) from error
    x, y, z = (cloud.offset + scene.offset).tolist()
    scene = replace(scene, offset=(x, y, z), source=cloud.source)
    if not cloud.offset.any():
        return scene
    place = ", ".join(f"{value:.10g}" for value in cloud.offset)
    return replace(
        scene, warnings=(*scene.warnings, f"{path}: coordinates are relative to ({place})")
    )
