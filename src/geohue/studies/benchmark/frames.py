"""Folders of labelled frames: one folder a frame, with colour, depth, labels and camera."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.measures.crop import Crop, window
from geohue.scene import Scene

_COLORS = ("rgb.png", "rgb.jpg")
_LABELS = ("labels_object.png", "labels.png")


@dataclass(frozen=True, slots=True)
class Frame:
    """A labelled frame on disk.

    Attributes
    ----------
    name : str
        The name of its folder.
    color, depth, labels : Path
        The image, the depth map and the true labels.
    intrinsics : Path or None
        The camera.
    """

    name: str
    color: Path
    depth: Path
    labels: Path
    intrinsics: Path | None


def find_frames(folder: str | Path, limit: int | None = None) -> list[Frame]:
    """List the frames of a folder.

    Parameters
    ----------
    folder : str or Path
        A folder of frames, or one that has them in ``frames/``. A frame is a folder with
        ``rgb.png`` or ``rgb.jpg``, ``depth.png``, ``labels_object.png`` or else ``labels.png``,
        and maybe ``intrinsics.json``; other folders are passed over.
    limit : int, optional
        At most so many frames, spread evenly over all.

    Returns
    -------
    list of Frame
        In the order of their names.

    Raises
    ------
    GeohueError
        If there is no such folder or no frame in it, or for a limit below 1.
    """
    root = Path(folder)
    if not root.is_dir():
        raise GeohueError(f"{folder}: no such folder; check the name")
    if limit is not None and limit < 1:
        raise GeohueError(f"limit is {limit}: expected at least 1")
    nested = root / "frames"
    parts = sorted((nested if nested.is_dir() else root).iterdir())
    frames = [frame for part in parts if (frame := _frame(part)) is not None]
    if not frames:
        raise GeohueError(
            f"{folder}: no frames; each is a folder with {' or '.join(_COLORS)}, depth.png and "
            f"{' or '.join(_LABELS)}"
        )
    if limit is None or limit >= len(frames):
        return frames
    return [frames[i * len(frames) // limit] for i in range(limit)]


def _frame(part: Path) -> Frame | None:
    color = _first(part, _COLORS)
    depth = _first(part, ("depth.png",))
    labels = _first(part, _LABELS)
    if color is None or depth is None or labels is None:
        return None
    return Frame(part.name, color, depth, labels, _first(part, ("intrinsics.json",)))


def _first(part: Path, names: tuple[str, ...]) -> Path | None:
    return next((part / name for name in names if (part / name).is_file()), None)


def load_frame(frame: Frame, crop: Crop | None = None) -> tuple[Scene, NDArray[np.int32]]:
    """Read a frame.

    Parameters
    ----------
    frame : Frame
    crop : (top, bottom, left, right), optional
        The part to keep, ends excluded.

    Returns
    -------
    scene : Scene
    truth : (H, W) int32
        True labels; 0 is none.

    Raises
    ------
    GeohueError
        If a file cannot be read, the sizes differ, or the crop does not fit.
    """
    from geohue.read.images.pictures import read_labels
    from geohue.read.scenes.scenes import read_scene

    camera = None if frame.intrinsics is None else str(frame.intrinsics)
    scene = read_scene(frame.color, frame.depth, camera)
    truth = read_labels(frame.labels)
    if truth.shape != scene.shape:
        raise GeohueError(
            f"{frame.labels}: differs in size from {frame.color.name}: {truth.shape[1]} x "
            f"{truth.shape[0]} and {scene.shape[1]} x {scene.shape[0]}"
        )
    if crop is None:
        return scene, truth
    rows, columns = window(crop, truth.shape)
    return crop_scene(scene, crop), truth[rows, columns]


def crop_scene(scene: Scene, crop: Crop) -> Scene:
    """Cut a window out of a scene; its points stay where they are.

    Parameters
    ----------
    scene : Scene
        On a grid.
    crop : (top, bottom, left, right)
        Ends excluded.

    Returns
    -------
    Scene
    """
    rows, columns = window(crop, scene.shape)
    positions = np.arange(scene.size).reshape(scene.shape)[rows, columns]
    camera = scene.intrinsics
    if camera is not None:
        camera = replace(
            camera,
            cx=camera.cx - columns.start,
            cy=camera.cy - rows.start,
            width=positions.shape[1],
            height=positions.shape[0],
        )
    return replace(scene.take(positions), intrinsics=camera)
