"""What is given to `segment` in place of a scene: used where it is plain, else what to write."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.scene import Scene
from geohue.scene.given import FilePath, is_path, read

_FROM_RGBD = "geohue.Scene.from_rgbd(rgb, depth, intrinsics)"
_FROM_CLOUD = "geohue.Scene.from_cloud(points, colors)"


class HasScene(Protocol):
    """A frame of a data set."""

    def scene(self) -> Scene:
        """Read it."""
        ...


Segmentable = HasScene | FilePath | NDArray[Any]
"""What `segment` takes beside a scene."""


def scene_given(given: Any, k: object, cues: str) -> Scene:
    """Return the scene that the first argument of `segment` means.

    Parameters
    ----------
    given : object
        A scene; a frame of a data set; the path of a cloud; with ``cues="color"``, an image or
        its path.
    k : object
        The second argument, which is a depth map at times.
    cues : str
        What is gone by.

    Raises
    ------
    GeohueError
        For anything else, with what to write instead.

    Examples
    --------
    >>> scene_given(None, "auto", "fusion")
    Traceback (most recent call last):
    geohue.errors.GeohueError: segment(None): give a scene, such as geohue.Scene.from_rgbd(...
    """
    a_file = is_path(k) and k != "auto" and (is_path(given) or not isinstance(k, str))
    if isinstance(k, np.ndarray | list) or a_file:
        raise GeohueError(
            f"segment takes one scene, and {_told(k)} as its k: write geohue.segment({_FROM_RGBD})"
        )
    if isinstance(given, Scene):
        return given
    if is_path(given):
        return _scene_of_file(Path(given), cues)
    if callable(getattr(given, "scene", None)):
        found = given.scene()
        if isinstance(found, Scene):
            return found
    if isinstance(given, np.ndarray):
        return _scene_of_array(given, cues)
    name = "None" if given is None else f"a {type(given).__name__}"
    raise GeohueError(
        f"segment({name}): give a scene, such as {_FROM_RGBD}, {_FROM_CLOUD} or "
        'geohue.load_sample("motorcycle")'
    )


def _told(value: Any) -> str:
    return f"has an array of shape {np.shape(value)}" if not is_path(value) else f"has {value!r}"


def _scene_of_file(path: Path, cues: str) -> Scene:
    if path.is_dir():
        found: Scene | None = read("model", path)
        if found is not None:
            return found
        raise GeohueError(
            f"{path}: is a folder; write geohue.segment(geohue.open_dataset({str(path)!r})[0]) for "
            "its first frame"
        )
    scene: Scene = read("scene", path)
    if scene.is_grid and not scene.valid.any() and cues != "color":
        raise GeohueError(
            f"{path}: is an image without depth; write geohue.segment(geohue.Scene.from_rgbd("
            f'{str(path)!r}, depth, intrinsics)), or go by the colours alone with cues="color"'
        )
    return scene


def _scene_of_array(array: NDArray[Any], cues: str) -> Scene:
    if array.ndim == 3 and array.shape[2] in (3, 4):
        if cues == "color":
            return Scene.from_image(array)
        instead = f'{_FROM_RGBD}), or go by the colours alone with cues="color"'
    elif array.ndim == 2 and array.shape[1] in (3, 4, 6, 7):
        instead = f"{_FROM_CLOUD})"
    else:
        instead = f"{_FROM_RGBD}) or geohue.segment({_FROM_CLOUD})"
    raise GeohueError(
        f"an array of shape {array.shape} is no scene: write geohue.segment({instead}"
    )
