"""Redwood and Open3D: folders of pictures and depth in millimetres, trajectory.log."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics
from geohue.datasets.frames import Dataset, Frame, numbers, read_rows
from geohue.datasets.pairs import camera_beside, folder_pairs

_CAMERA_FILES = ("camera_intrinsic.json", "intrinsic.json", "camera_primesense.json", "camera.json")
_TRAJECTORIES = ("trajectory.log", "odometry.log", "traj.log")
_PRIMESENSE = Intrinsics(525.0, 525.0, 319.5, 239.5, 640, 480)


def matches(folder: Path) -> bool:
    """Whether there are pictures, depth and a trajectory in the .log format."""
    logs = any((folder / name).is_file() for name in _TRAJECTORIES)
    return logs and bool(folder_pairs(folder))


def load(folder: Path) -> Dataset:
    """Pair pictures and depth maps in their order, each with its pose."""
    pairs = folder_pairs(folder)
    log = next((folder / name for name in _TRAJECTORIES if (folder / name).is_file()), None)
    poses = {} if log is None else _trajectory(log)
    places = (folder, folder.parent)
    camera = next((c for p in places if (c := camera_beside(p, _CAMERA_FILES))), None)
    notes = () if camera else ("camera unknown: PrimeSense fx = fy = 525 px assumed",)
    frames = [
        Frame(color.stem, color, depth, camera or _PRIMESENSE, "redwood", poses.get(i))
        for i, (color, depth) in enumerate(pairs)
    ]
    return Dataset("open3d", folder, frames, notes)


def _trajectory(path: Path) -> dict[int, NDArray[np.float64]]:
    """Read poses (camera to world): a row of three whole numbers, then a 4 x 4 matrix."""
    rows = [numbers(row, path) for row in read_rows(path, 3)]
    poses: dict[int, NDArray[np.float64]] = {}
    for i, row in enumerate(rows):
        body = rows[i + 1 : i + 5]
        whole = len(row) == 3 and len(body) == 4 and all(len(r) == 4 for r in body)
        if whole and np.isfinite(body).all():
            poses[len(poses)] = np.array(body)
    return poses
