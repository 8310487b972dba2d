"""ScanNet as its exporter writes it: color/, depth/, pose/, intrinsic/."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics
from geohue.datasets.frames import Dataset, Frame, picture_in, read_pose, sorted_files
from geohue.read.files import broken


def matches(folder: Path) -> bool:
    """Whether the camera of the depth map lies in intrinsic/."""
    return (folder / "intrinsic" / "intrinsic_depth.txt").is_file() and (folder / "depth").is_dir()


def load(folder: Path) -> Dataset:
    """List the frames; pictures are resized to the depth maps, which show the same view."""
    file = folder / "intrinsic" / "intrinsic_depth.txt"
    matrix = read_pose(file)
    if matrix is None:
        raise broken(file, "is no 4 x 4 matrix; export the scan again")
    camera = _camera(matrix)
    frames = []
    for depth in sorted_files(folder / "depth", "*.png", "*.pgm"):
        color = picture_in(folder / "color", depth.stem)
        if color is not None:
            pose = read_pose(folder / "pose" / f"{depth.stem}.txt")
            labels = picture_in(folder / "instance-filt", depth.stem)
            frames.append(Frame(depth.stem, color, depth, camera, "scannet", pose, labels=labels))
    return Dataset("scannet", folder, frames)


def _camera(matrix: NDArray[np.float64]) -> Intrinsics:
    fx, fy, cx, cy = (float(matrix[i]) for i in ((0, 0), (1, 1), (0, 2), (1, 2)))
    return Intrinsics(fx, fy, cx, cy, 640, 480)
