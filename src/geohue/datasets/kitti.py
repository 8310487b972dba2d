"""KITTI object: velodyne/, image_2/, image_3/, calib/; or one frame in a folder."""

from __future__ import annotations

from pathlib import Path

from geohue.datasets.frames import Dataset, Frame, picture_in, sorted_files
from geohue.read.cameras.rig import read_rig


def matches(folder: Path) -> bool:
    """Whether there are scans with calibration and pictures."""
    return bool(_training(folder)) or _single(folder)


def load(folder: Path) -> Dataset:
    """List the frames: LiDAR points, the left picture and, where it is there, the right one."""
    frames = []
    for scan, left, right, calib in _training(folder):
        frames.append(_frame(scan.stem, scan, left, right, calib))
    if not frames and _single(folder):
        view = picture_in(folder, "left")
        if view is not None:
            second, calib = picture_in(folder, "right"), folder / "calib.txt"
            frames.append(_frame(folder.name, folder / "lidar.bin", view, second, calib))
    return Dataset("kitti", folder, frames)


def _frame(name: str, scan: Path, left: Path, right: Path | None, calib: Path) -> Frame:
    return Frame(name, left, scan, rig=read_rig(calib), second=right)


def _single(folder: Path) -> bool:
    return all((folder / name).is_file() for name in ("lidar.bin", "calib.txt"))


def _training(folder: Path) -> list[tuple[Path, Path, Path | None, Path]]:
    base = next((p for p in (folder, folder / "training") if (p / "velodyne").is_dir()), None)
    if base is None:
        return []
    found = []
    for scan in sorted_files(base / "velodyne", "*.bin"):
        left, right = (picture_in(base / f"image_{n}", scan.stem) for n in (2, 3))
        calib = base / "calib" / f"{scan.stem}.txt"
        if left is not None and calib.is_file():
            found.append((scan, left, right, calib))
    return found
