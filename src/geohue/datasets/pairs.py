"""Any folder of pictures and depth maps: rgb.png beside depth.png, color/ beside depth/."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import numpy as np

from geohue.camera import Intrinsics
from geohue.datasets.frames import (
    Dataset,
    Frame,
    numbers,
    pose_from_quaternion,
    read_rows,
    sorted_files,
)
from geohue.datasets.rig import rig_beside
from geohue.errors import GeohueError, GeohueWarning
from geohue.read.cameras.intrinsics import read_intrinsics

_COLOR = ("color", "colour", "rgb", "image", "images", "left")
_COLOR_NAME = re.compile(r"(?i)(color|colour|rgb|image)")
_PICTURES = ("*.png", "*.jpg", "*.jpeg", "*.ppm", "*.JPG", "*.PNG")
_DEPTHS = ("*.png", "*.pgm", "*.tif", "*.tiff", "*.npy", "*.npz", "*.exr", "*.pfm")
_CAMERAS = (
    *("intrinsics.json", "camera_params.json", "camera.json", "intrinsic.json"),
    *(
        "intrinsics.txt",
        "camera-intrinsics.txt",
        "intrinsics.yml",
        "intrinsics.yaml",
        "camera.yaml",
    ),
)
_UNREGISTERED = (
    "{} calibrates a depth and a colour camera: the depth maps are taken to be registered already; "
    "if they are as the sensor gave them, use geohue register"
)
_MOST_FRAMES = 1_000_000


def matches(folder: Path) -> bool:
    """Whether there is at least one picture with a depth map of a matching name."""
    return folder.is_dir() and bool(_all_pairs(folder))


def load(folder: Path) -> Dataset:
    """Pair pictures and depth maps by their names."""
    pairs = _all_pairs(folder)
    poses = _poses(folder / "pose.txt", len(pairs))
    frames = []
    for i, (color, depth) in enumerate(pairs):
        place = color.parent
        camera = camera_beside(place, _CAMERAS) or camera_beside(folder, _CAMERAS)
        labels = next((f for n in ("labels.png", "label.png") if (f := place / n).is_file()), None)
        own = place != folder and color.stem.lower() in _COLOR
        name = place.name if own else color.stem
        frames.append(Frame(name, color, depth, camera, None, poses.get(i), labels=labels))
    known = any(frame.intrinsics for frame in frames)
    notes = () if known else ("no camera file found",)
    file = rig_beside(folder)
    if file is not None:
        notes = (*notes, _UNREGISTERED.format(file))
    return Dataset("pairs", folder, frames, notes, registered=None)


def _all_pairs(folder: Path) -> list[tuple[Path, Path]]:
    found = folder_pairs(folder) or _named_pairs(folder)
    if found:
        return found
    inner = sorted(p for p in folder.iterdir() if p.is_dir())[:_MOST_FRAMES]
    nested = [pair for place in inner for pair in _named_pairs(place)]
    return nested or [p for place in inner if place.name == "frames" for p in _all_pairs(place)]


def folder_pairs(folder: Path) -> list[tuple[Path, Path]]:
    """Pair the files of color/ (rgb/, image/) with those of depth/, by stem or else by order."""
    place = next((folder / name for name in _COLOR if (folder / name).is_dir()), None)
    if place is None or not (folder / "depth").is_dir():
        return []
    colors = sorted_files(place, *_PICTURES)
    depths = sorted_files(folder / "depth", *_DEPTHS)
    by_stem = {depth.stem: depth for depth in depths}
    paired = [(color, by_stem[color.stem]) for color in colors if color.stem in by_stem]
    if paired or len(colors) != len(depths):
        return paired
    return list(zip(colors, depths, strict=True))


def _named_pairs(folder: Path) -> list[tuple[Path, Path]]:
    """Pair files of one folder whose names differ in "color" (or rgb, or nothing) and "depth"."""
    depths = {
        f.stem.lower(): f for f in sorted_files(folder, *_DEPTHS) if "depth" in f.stem.lower()
    }
    pairs = []
    for color in sorted_files(folder, *_PICTURES) if depths else []:
        stem = color.stem.lower()
        if "depth" in stem:
            continue
        names = [_COLOR_NAME.sub("depth", stem), f"{stem}_depth", f"{stem}-depth"]
        depth = next((depths[name] for name in names if name in depths), None)
        if depth is not None:
            pairs.append((color, depth))
    return pairs


def camera_beside(folder: Path, names: tuple[str, ...]) -> Intrinsics | None:
    """Read the first camera file of a folder that is one; None if there is none."""
    for name in names:
        if (folder / name).is_file():
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore", GeohueWarning)
                    return read_intrinsics(folder / name)
            except GeohueError:
                continue
    return None


def _poses(path: Path, count: int) -> dict[int, np.ndarray[tuple[int, ...], np.dtype[np.float64]]]:
    """Read a row of tx ty tz qx qy qz qw (camera to world) for each frame."""
    rows = read_rows(path, 7) if path.is_file() else []
    if len(rows) != count:
        return {}
    return {i: pose_from_quaternion(numbers(row[:7], path)) for i, row in enumerate(rows)}
