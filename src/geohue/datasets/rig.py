"""Pictures and unregistered depth with their calibration: NNN_rgb, NNN_depth, calibration.json."""

from __future__ import annotations

import re
from pathlib import Path

from geohue.datasets.frames import Dataset, Frame, sorted_files
from geohue.errors import GeohueError
from geohue.read.cameras.rig import read_rig
from geohue.read.images.depth_units import DepthUnit
from geohue.read.images.raw_depth import looks_raw
from geohue.sensors.rig import Rig

_CALIBRATIONS = (
    *("calibration.json", "calib.json", "calibration.yml", "calibration.yaml"),
    *("rig.json", "rig.yml"),
)
_PARTS = {
    "color": re.compile(r"(?i)^(.*?)[-_.]?(rgb1?|colou?r1?|c1)$"),
    "second": re.compile(r"(?i)^(.*?)[-_.]?(rgb2|colou?r2|c2)$"),
    "depth": re.compile(r"(?i)^(.*?)[-_.]?(depth|disparity|d|tof)$"),
}
_FILES = ("*.png", "*.jpg", "*.jpeg", "*.ppm", "*.pgm", "*.tif", "*.tiff", "*.npy")


def matches(folder: Path) -> bool:
    """Whether a calibration of depth and colour lies here or one folder up, with frames for it."""
    return folder.is_dir() and bool(_named(folder)) and rig_beside(folder) is not None


def load(folder: Path) -> Dataset:
    """Pair pictures of one or two cameras and depth by their names."""
    file = rig_beside(folder)
    if file is None:
        raise GeohueError(f"{folder}: no calibration.json of depth and colour beside the frames")
    rig = read_rig(file)
    frames = []
    for name, parts in _named(folder).items():
        second = parts.get("second") if len(rig.cameras) > 1 else None
        unit = _unit(parts["depth"], rig)
        frames.append(
            Frame(name, parts["color"], parts["depth"], None, unit, rig=rig, second=second)
        )
    return Dataset("rig", folder, frames, rig.warnings)


def _unit(depth: Path, rig: Rig) -> float | DepthUnit | None:
    if rig.disparity is not None and looks_raw(depth):
        return DepthUnit(1.0, rig.disparity.depth)
    return rig.depth_unit


def rig_beside(folder: Path) -> Path | None:
    """Return the first file that is a calibration of a rig with a depth camera."""
    for file in (place / name for place in (folder, folder.parent) for name in _CALIBRATIONS):
        if file.is_file():
            try:
                if read_rig(file).depth is not None:
                    return file
            except GeohueError:
                continue
    return None


def _named(folder: Path) -> dict[str, dict[str, Path]]:
    """Return the files of each frame by what they are."""
    found: dict[str, dict[str, Path]] = {}
    for file in sorted_files(folder, *_FILES):
        for part, pattern in _PARTS.items():
            match = pattern.match(file.stem)
            if match:
                found.setdefault(match.group(1) or folder.name, {}).setdefault(part, file)
                break
    return {name: parts for name, parts in found.items() if {"color", "depth"} <= parts.keys()}
