"""Microsoft 7-Scenes: frame-XXXXXX.color, .depth (millimetres) and .pose.txt."""

from __future__ import annotations

from pathlib import Path

from geohue.camera import Intrinsics
from geohue.datasets.frames import Dataset, Frame, picture_in, read_pose, sorted_files
from geohue.datasets.pairs import camera_beside

_CAMERA = Intrinsics(585.0, 585.0, 320.0, 240.0, 640, 480)


def matches(folder: Path) -> bool:
    """Whether there is a frame-*.depth.png."""
    return next(folder.glob("frame-*.depth.png"), None) is not None


def load(folder: Path) -> Dataset:
    """List the frames that have picture and depth."""
    camera = camera_beside(folder, ("camera-intrinsics.txt",)) or _CAMERA
    if camera.width is None:
        camera = Intrinsics(camera.fx, camera.fy, camera.cx, camera.cy, 640, 480)
    frames = []
    for depth in sorted_files(folder, "frame-*.depth.png"):
        name = depth.name.removesuffix(".depth.png")
        color = picture_in(folder, f"{name}.color")
        if color is not None:
            pose = read_pose(folder / f"{name}.pose.txt")
            frames.append(Frame(name, color, depth, camera, "7scenes", pose))
    notes = ("depth is registered only roughly to colour (several pixels) in this data set",)
    return Dataset("sevenscenes", folder, frames, notes)
