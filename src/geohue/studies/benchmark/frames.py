"""Labelled frames: folders with colour, depth, labels and camera, or those of a data set."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geohue.datasets.layouts import guess_layout
from geohue.errors import GeohueError
from geohue.measures.crop import Crop, window
from geohue.read.images.pictures import read_labels
from geohue.scene import Scene
from geohue.studies.items import Files, Item, check_limit, find_items, spread_evenly

_COLORS = ("rgb.png", "rgb.jpg")
_LABELS = ("labels_object.png", "labels.png")


def find_frames(folder: str | Path, limit: int | None = None) -> list[Item]:
    """List the labelled frames of a folder.

    Parameters
    ----------
    folder : str or Path
        A folder of frames, or one that has them in ``frames/``. A frame is a folder with
        ``rgb.png`` or ``rgb.jpg``, ``depth.png``, ``labels_object.png`` or else ``labels.png``,
        and maybe ``intrinsics.json``; other folders are passed over. Or a data set in a known
        layout (`geohue.datasets.open_dataset`) some of whose frames have labels.
    limit : int, optional
        At most so many frames, spread evenly over all.

    Returns
    -------
    list of Item
        In the order of their names, or of the data set.

    Raises
    ------
    GeohueError
        If there is no such folder or no frame in it, or for a limit below 1.
    """
    root = Path(folder)
    if not root.exists():
        raise GeohueError(f"{folder}: no such folder; check the name")
    check_limit(limit)
    frames = _own_frames(root) if root.is_dir() else []
    if not frames and guess_layout(root):
        frames = [item for item in find_items(root)[0] if item.labels is not None]
    if not frames:
        raise GeohueError(
            f"{folder}: no frames with labels; each is a folder with {' or '.join(_COLORS)}, "
            f"depth.png and {' or '.join(_LABELS)}, or one of a data set that has them"
        )
    return spread_evenly(frames, limit)


def _own_frames(root: Path) -> list[Item]:
    nested = root / "frames"
    parts = sorted((nested if nested.is_dir() else root).iterdir())
    return [frame for part in parts if (frame := _frame(part)) is not None]


def _frame(part: Path) -> Item | None:
    color = _first(part, _COLORS)
    depth = _first(part, ("depth.png",))
    labels = _first(part, _LABELS)
    if color is None or depth is None or labels is None:
        return None
    return Item(part.name, Files(color, depth, _first(part, ("intrinsics.json",))), labels)


def _first(part: Path, names: tuple[str, ...]) -> Path | None:
    return next((part / name for name in names if (part / name).is_file()), None)


def load_frame(frame: Item, crop: Crop | None = None) -> tuple[Scene, NDArray[np.int32]]:
    """Read a labelled frame.

    Parameters
    ----------
    frame : Item
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
    if frame.labels is None:
        raise GeohueError(f"{frame.name}: the frame has no labels")
    scene, truth = frame.read(), read_labels(frame.labels)
    if truth.shape != scene.shape:
        sizes = " and ".join(f"{shape[1]} x {shape[0]}" for shape in (truth.shape, scene.shape))
        raise GeohueError(f"{frame.labels}: differs in size from the frame's scene: {sizes}")
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
