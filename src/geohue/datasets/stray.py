"""Stray Scanner (iOS): rgb.mp4, depth/ in millimetres, confidence/, camera_matrix.csv."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics
from geohue.datasets.frames import (
    Dataset,
    Frame,
    numbers,
    picture_in,
    pose_from_quaternion,
    sorted_files,
)
from geohue.errors import GeohueError
from geohue.read.files import broken, read_bytes

_VIDEO = "rgb.mp4"
_MATRIX = "camera_matrix.csv"


def matches(folder: Path) -> bool:
    """Whether there is a camera_matrix.csv beside depth/."""
    return (folder / _MATRIX).is_file() and (folder / "depth").is_dir()


def load(folder: Path) -> Dataset:
    """List the depth maps with their pictures, frames of the video or files of rgb/."""
    words = read_bytes(folder / _MATRIX, 1 << 16).decode("latin-1").replace(",", " ").split()
    try:
        camera = Intrinsics.from_numbers(numbers(words, folder / _MATRIX))
    except GeohueError as error:
        raise broken(folder / _MATRIX, str(error)) from error
    poses = _poses(folder / "odometry.csv")
    video = folder / _VIDEO
    frames: list[Frame] = []
    for depth in sorted_files(folder / "depth", "*.png", "*.npy"):
        number = int(depth.stem) if depth.stem.isdigit() else len(frames)
        color = picture_in(folder / "rgb", depth.stem)
        if color is None and not video.is_file():
            continue
        frames.append(
            Frame(
                depth.stem,
                color or partial(read_video_frame, video, number),
                depth,
                camera,
                "mm",
                poses.get(number),
                confidence=picture_in(folder / "confidence", depth.stem),
            )
        )
    return Dataset("stray", folder, frames)


def read_video_frame(video: Path, number: int) -> NDArray[np.uint8]:
    """Decode one frame of a video as it is stored, whatever its mark says of turning it.

    Raises
    ------
    GeohueError
        If the video cannot be decoded, or has fewer frames.
    """
    import cv2

    if not video.is_file():
        raise broken(video, "no such file; copy the whole recording")
    film = cv2.VideoCapture(str(video))
    try:
        film.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)
        film.set(cv2.CAP_PROP_POS_FRAMES, number)
        there, picture = film.read()
    finally:
        film.release()
    if not there:
        raise broken(video, f"has no frame {number} that can be decoded; copy it again")
    return np.ascontiguousarray(np.asarray(picture, np.uint8)[..., ::-1])


def _poses(path: Path) -> dict[int, NDArray[np.float64]]:
    """Read rows of timestamp, frame, x, y, z, qx, qy, qz, qw."""
    if not path.is_file():
        return {}
    lines = read_bytes(path, 1 << 28).decode("latin-1").splitlines()[1:]
    rows = [line.split(",") for line in lines if line.count(",") >= 8]
    return {int(float(row[1])): pose_from_quaternion(numbers(row[2:9], path)) for row in rows}
