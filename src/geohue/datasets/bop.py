"""BOP (pose estimation benchmark): a scene with rgb/, depth/ and scene_camera.json."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from geohue.camera import Intrinsics
from geohue.datasets.frames import Dataset, Frame, picture_in, sorted_files
from geohue.errors import GeohueError
from geohue.read.files import broken, read_bytes, reason


def matches(folder: Path) -> bool:
    """Whether scene_camera.json lies beside depth/, here or in the folders of a split."""
    return any(_scenes(folder))


def load(folder: Path) -> Dataset:
    """List the frames of a scene, or of all scenes of a split."""
    scenes = _scenes(folder)
    frames = [frame for scene in scenes for frame in _frames(scene, len(scenes) > 1)]
    return Dataset("bop", folder, frames)


def _scenes(folder: Path) -> list[Path]:
    places = [folder, *sorted(p for p in folder.iterdir() if p.is_dir())] if folder.is_dir() else []
    return [p for p in places if (p / "scene_camera.json").is_file() and (p / "depth").is_dir()]


def _frames(scene: Path, several: bool) -> list[Frame]:
    file = scene / "scene_camera.json"
    try:
        cameras = json.loads(read_bytes(file, 1 << 28))
    except (ValueError, RecursionError) as error:
        raise broken(file, f"is damaged JSON ({reason(error)}); download it again") from error
    if not isinstance(cameras, dict):
        raise broken(file, "has no cameras by frame; download it again")
    frames = []
    for depth in sorted_files(scene / "depth", "*.png", "*.tif"):
        number = depth.stem.lstrip("0") or "0"
        color = picture_in(scene / "rgb", depth.stem) or picture_in(scene / "gray", depth.stem)
        if color is None or number not in cameras:
            continue
        name = f"{scene.name}/{depth.stem}" if several else depth.stem
        frames.append(_frame(name, color, depth, cameras[number], file))
    return frames


def _frame(name: str, color: Path, depth: Path, camera: Any, file: Path) -> Frame:
    """Read K, the scale (millimetres a unit) and the pose (world to camera, millimetres)."""
    try:
        K = np.array(camera["cam_K"], np.float64).reshape(3, 3)
        scale = float(camera["depth_scale"]) / 1000
        pose = None
        if "cam_R_w2c" in camera and "cam_t_w2c" in camera:
            pose = np.eye(4)
            R = np.array(camera["cam_R_w2c"], np.float64).reshape(3, 3)
            pose[:3, :3] = R.T
            pose[:3, 3] = -R.T @ np.array(camera["cam_t_w2c"], np.float64).reshape(3) / 1000
        intrinsics = Intrinsics(K[0, 0], K[1, 1], K[0, 2], K[1, 2])
    except GeohueError:
        raise
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise broken(file, f"frame {name}: {reason(error)} is missing or no number") from error
    return Frame(name, color, depth, intrinsics, scale, pose)
