"""From files to a scene, the kind of input guessed from what is given."""

from __future__ import annotations

from pathlib import Path

from geohue.errors import GeohueError
from geohue.read.clouds.cloud import CLOUD_READERS, is_colmap
from geohue.read.files import broken
from geohue.scene import Scene
from geohue.scene.frame import mask_given


def read_scene(
    source: str | Path,
    depth: str | Path | None = None,
    intrinsics: str | Path | None = None,
    depth_scale: float | str | None = None,
    *,
    confidence: str | Path | None = None,
    least: float | None = None,
    min_depth: float | None = None,
    max_depth: float | None = None,
    mask: str | Path | None = None,
) -> Scene:
    """Read an RGB-D frame, a cloud, or an image alone.

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
    confidence, least, min_depth, max_depth, mask
        As `Scene.from_rgbd`, for an image with depth.

    Returns
    -------
    Scene
        Its `warnings` tell every guess that was made.

    Raises
    ------
    GeohueError
        If a file cannot be read or the files do not fit together.
    """
    trust: dict[str, object] = {"confidence": confidence, "least": least}
    trust |= {"min_depth": min_depth, "max_depth": max_depth}
    if depth is None:
        _check_absent(source, trust)
    if is_cloud(source):
        _check_absent(source, {"mask": mask})
        if depth is not None:
            raise broken(source, f"is a cloud and has its own geometry; leave out {depth}")
        return _cloud_scene(source)
    if depth is None:
        scene = Scene.from_image(source)
        if mask is None:
            return scene
        return scene.masked(mask_given(mask, (scene.shape[0], scene.shape[1])))
    if Path(depth).suffix.lower() not in (".npy", ".npz") and is_cloud(depth):
        raise broken(depth, f"is a cloud; give it alone, without {source}")
    return Scene.from_rgbd(
        source,
        depth,
        intrinsics,
        depth_scale,
        confidence=confidence,
        least=least,
        min_depth=min_depth,
        max_depth=max_depth,
        mask=mask,
    )


def is_cloud(path: str | Path) -> bool:
    """Whether a file is read as a cloud, by its name; or a folder, by the model in it."""
    file = Path(path)
    return file.suffix.lower() in CLOUD_READERS or is_colmap(file)


def _check_absent(source: str | Path, arguments: dict[str, object]) -> None:
    for name, value in arguments.items():
        if value is not None:
            raise broken(source, f"comes without a depth map, which {name} needs: leave it out")


def _cloud_scene(path: str | Path) -> Scene:
    try:
        return Scene.from_cloud(path)
    except GeohueError as error:
        raise error if str(error).startswith(f"{path}:") else broken(path, str(error)) from error
