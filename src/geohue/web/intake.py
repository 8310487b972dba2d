"""From the files of a request to a scene, within the limits."""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from pathlib import Path

from geohue.errors import GeohueError
from geohue.read.files import broken, read_bytes
from geohue.read.images.integrity import picture_size
from geohue.scene import Scene
from geohue.web.limits import Limits
from geohue.web.store import SCENE
from geohue.web.wishes import Wishes

ROLES = ("color", "depth", "right", "disparity", "calib", "intrinsics", "cloud")
"""What an uploaded file can be."""

IMAGES = ("color", "depth", "right", "disparity")

_PICTURES = (".png", ".jpg", ".jpeg", ".ppm", ".pgm", ".bmp", ".tif", ".tiff", ".webp")
_MAPS = (*_PICTURES, ".npy", ".npz", ".pfm", ".exr")
_TEXTS = (".txt", ".json", ".yml", ".yaml", ".xml", ".cal", ".ini", ".csv")
_CLOUDS = (".ply", ".pcd", ".las", ".laz", ".e57", ".xyz", ".xyzrgb", ".txt", ".asc", ".csv")

ENDINGS: dict[str, tuple[str, ...]] = {
    "color": _PICTURES,
    "right": _PICTURES,
    "depth": _MAPS,
    "disparity": _MAPS,
    "calib": _TEXTS,
    "intrinsics": _TEXTS,
    "cloud": (*_CLOUDS, ".pts", ".npy", ".npz"),
}
"""How the name of a file of each role may end. Nothing else of the name is used."""


def kept_name(role: str, given: str) -> str:
    """Return the name under which an uploaded file is kept.

    Raises
    ------
    GeohueError
        For an unknown role, or an ending that no file of this role has.

    Examples
    --------
    >>> kept_name("depth", "../../etc/Depth.PNG")
    'depth.png'
    """
    if role not in ROLES:
        raise GeohueError(f"no file is called {role[:40]!r}: there are {', '.join(ROLES)}")
    ending = next((e for e in ENDINGS[role] if given.lower().endswith(e)), None)
    if ending is None:
        raise GeohueError(f"{role}: a file with another ending; expected {' '.join(ENDINGS[role])}")
    return role + ending


def check_roles(files: Mapping[str, str], sample: str, again: bool) -> None:
    """Raise `GeohueError` unless there is exactly one scene in the files of a request."""
    ways = [bool(sample), again, "cloud" in files, "color" in files]
    if sum(ways) != 1:
        raise GeohueError("give one scene: a color image, a cloud, a sample or the scene of a job")
    if "color" not in files and set(files) - {"cloud"}:
        raise GeohueError(f"{sorted(set(files) - {'cloud'})[0]}: needs a color image beside it")
    if "right" in files and {"depth", "intrinsics"} & set(files):
        raise GeohueError("a stereo pair has its own depth: leave out depth and intrinsics")
    if "right" not in files and {"disparity", "calib"} & set(files):
        raise GeohueError("disparity and calib belong to a stereo pair: give the right image too")
    if "intrinsics" in files and "depth" not in files:
        raise GeohueError("intrinsics belong to a depth map: give that too")


def read_task_scene(
    folder: Path, files: Mapping[str, str], sample: str, wishes: Wishes, limits: Limits
) -> Scene:
    """Read the scene of a task.

    Parameters
    ----------
    folder : Path
        Where its files are.
    files : mapping
        The name there of each file, by its role.
    sample : str
        A built-in scene; empty for none.
    wishes : Wishes
        Scales and calibrations given as text.
    limits : Limits

    Returns
    -------
    Scene

    Raises
    ------
    GeohueError
        If the files cannot be read or are beyond the limits.
    """
    if (folder / SCENE).exists():
        scene: Scene = pickle.loads((folder / SCENE).read_bytes())
    elif sample:
        from geohue.datasets.samples import load_sample

        scene = load_sample(sample)
    else:
        places = {role: folder / name for role, name in files.items()}
        for role in IMAGES:
            if role in places:
                check_pixels(places[role], limits.pixels)
        scene = _read(folder, places, wishes)
    most = limits.pixels if scene.is_grid else limits.points
    if scene.size > most:
        what = "pixels" if scene.is_grid else "points"
        raise GeohueError(f"the scene has {scene.size} {what}, more than {most}: thin it first")
    return scene


def check_pixels(file: Path, most: int) -> None:
    """Raise `GeohueError` if a picture's header tells of more pixels than the limit."""
    size = picture_size(read_bytes(file))
    if size is not None and size[0] * size[1] > most:
        raise broken(file, f"has {size[0]} x {size[1]} pixels, more than {most}: make it smaller")


def _read(folder: Path, places: Mapping[str, Path], wishes: Wishes) -> Scene:
    from geohue.read.scenes.scenes import read_scene
    from geohue.read.scenes.stereo import read_stereo_scene

    if "cloud" in places:
        return read_scene(places["cloud"])
    if "right" in places:
        calib = places.get("calib") or _as_file(folder / "calib.txt", wishes.calib)
        disparity, scale = places.get("disparity"), wishes.disparity_scale or None
        return read_stereo_scene(places["color"], places["right"], disparity, scale, calib)
    camera = places.get("intrinsics") or _as_file(folder / "intrinsics.txt", wishes.intrinsics)
    return read_scene(places["color"], places.get("depth"), camera, wishes.depth_scale or None)


def _as_file(file: Path, text: str) -> Path | None:
    """Write numbers to a file: readers take a text that they cannot parse for a file's name."""
    if not text.strip():
        return None
    file.write_text(text, encoding="utf-8")
    return file
