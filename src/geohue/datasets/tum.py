"""TUM RGB-D: lists of time stamps, depth at 5000 a metre."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics
from geohue.datasets.frames import (
    Dataset,
    Frame,
    inside,
    numbers,
    pose_from_quaternion,
    read_rows,
)

_APART = 0.02  # seconds between what counts as one moment
_CAMERAS = {
    "freiburg1": Intrinsics(517.3, 516.5, 318.6, 255.3, 640, 480),
    "freiburg2": Intrinsics(520.9, 521.0, 325.1, 249.7, 640, 480),
    "freiburg3": Intrinsics(535.4, 539.2, 320.1, 247.6, 640, 480),
}
_ANY = Intrinsics(525.0, 525.0, 319.5, 239.5, 640, 480)


def matches(folder: Path) -> bool:
    """Whether the folder has the lists rgb.txt and depth.txt."""
    return (folder / "rgb.txt").is_file() and (folder / "depth.txt").is_file()


def load(folder: Path) -> Dataset:
    """Pair each picture with the depth map, and the pose, nearest in time."""
    rgb, depth = (_list(folder / f"{name}.txt", folder) for name in ("rgb", "depth"))
    truth = folder / "groundtruth.txt"
    poses = [numbers(row[:8], truth) for row in read_rows(truth, 8)] if truth.is_file() else []
    pose_times = np.array([row[0] for row in poses])
    depth_times = np.array([time for time, _ in depth])
    name = str(folder.resolve()).lower()
    camera = next((c for key, c in _CAMERAS.items() if key in name), None)
    notes = () if camera else ("camera unknown: fx = fy = 525 px (ROS default) assumed",)
    frames = []
    for time, file in rgb:
        i, j = _nearest(depth_times, time), _nearest(pose_times, time)
        if i is None:
            continue
        pose = None if j is None else pose_from_quaternion(poses[j][1:])
        frames.append(Frame(file.stem, file, depth[i][1], camera or _ANY, "tum", pose))
    return Dataset("tum", folder, frames, notes)


def _list(path: Path, folder: Path) -> list[tuple[float, Path]]:
    rows = read_rows(path, 2)
    return sorted((numbers(row[:1], path)[0], inside(folder, row[1])) for row in rows)


def _nearest(times: NDArray[np.float64], time: float) -> int | None:
    if len(times) == 0:
        return None
    i = int(np.argmin(np.abs(times - time)))
    return i if abs(times[i] - time) <= _APART else None
