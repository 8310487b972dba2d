"""Middlebury stereo (2003, 2005, 2006, 2014) with ground-truth disparity as depth."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics
from geohue.datasets.frames import Dataset, Frame, numbers, picture_in
from geohue.read.files import broken, read_bytes
from geohue.read.images.integrity import picture_size

_FOCAL, _BASELINE = 3740.0, 0.160  # 2005 and 2006, full size, by the data set's page
_HEIGHT = 1110  # of full size
_NAMES = (("view1", "disp1"), ("im2", "disp2"), ("im0", "disp0"))


@dataclass(frozen=True, slots=True)
class _Set:
    color: Path
    disparity: Path


def matches(folder: Path) -> bool:
    """Whether a left view lies beside its disparity, here or one folder below."""
    return bool(_sets(folder))


def load(folder: Path) -> Dataset:
    """List the left views; depth is ``b f / (d + doffs)``."""
    notes: list[str] = []
    frames = [_frame(found, folder, notes) for found in _sets(folder)]
    return Dataset("middlebury", folder, frames, tuple(dict.fromkeys(notes)))


def _sets(folder: Path) -> list[_Set]:
    if not folder.is_dir():
        return []
    found = []
    for place in (folder, *sorted(p for p in folder.iterdir() if p.is_dir())):
        for view, name in _NAMES:
            color = picture_in(place, view)
            disparity = place / f"{name}.pfm"
            if not disparity.is_file():
                disparity = picture_in(place, name) or place / f"{name}.pgm"
            if color is not None and disparity.is_file():
                found.append(_Set(color, disparity))
                break
    return found


def _frame(found: _Set, folder: Path, notes: list[str]) -> Frame:
    place = found.color.parent
    name = place.name if place != folder else folder.name
    if (place / "calib.txt").is_file():
        focal, baseline, offset, camera = _calibration(place / "calib.txt")
        return Frame(name, found.color, _depth(found, focal * baseline, 1.0, offset), camera)
    dmin = place / "dmin.txt"
    shift = 0.0
    if dmin.is_file():
        words = read_bytes(dmin, 4096).decode("latin-1").split()
        shift = float(words[0]) if words and re.fullmatch(r"\d+(\.\d+)?", words[0]) else 0.0
    else:
        notes.append("no dmin.txt: depth is bent (disparities are less a constant)")
    # Z = f b / (value + dmin) with f and values both at full size, whatever the picture's size.
    depth = _depth(found, _FOCAL * _BASELINE, 1.0, shift)
    return Frame(name, found.color, depth, _camera_2006(found.color))


def _camera_2006(color: Path) -> Intrinsics | None:
    """Return the camera at full, half or third size; None for the sets of other years."""
    size = picture_size(read_bytes(color))
    if size is None or all(abs(size[1] - _HEIGHT / n) > 1 for n in (1, 2, 3)):
        return None
    focal = _FOCAL * size[1] / _HEIGHT
    return Intrinsics(focal, focal, (size[0] - 1) / 2, (size[1] - 1) / 2, *size)


def _depth(
    found: _Set, focal_baseline: float, scale: float, offset: float
) -> Callable[[], NDArray[np.float32]]:
    """Return what reads the disparity as depth in metres; 0 and infinite are missing."""

    def read() -> NDArray[np.float32]:
        from geohue.read.images.pictures import read_depth

        values = read_depth(found.disparity, scale).depth  # NaN for 0, negative, infinite
        shifted = values + np.float32(offset)
        with np.errstate(all="ignore"):
            return np.asarray(np.where(shifted > 0, focal_baseline / shifted, np.nan), np.float32)

    return read


def _calibration(path: Path) -> tuple[float, float, float, Intrinsics]:
    """Read calib.txt of 2014: cam0, doffs, baseline (mm), width, height."""
    text = read_bytes(path, 1 << 16).decode("latin-1")
    K = numbers(re.sub(r"[\[\];,]", " ", _line(text, "cam0", path)).split(), path)
    if len(K) != 9:
        raise broken(path, "cam0 is no 3 x 3 matrix; download it again")
    keys = ("doffs", "baseline", "width", "height")
    doffs, base, width, height = numbers([_line(text, key, path) for key in keys], path)
    if not (1 <= width <= 1e6 and 1 <= height <= 1e6):
        raise broken(path, f"announces pictures of {width:g} x {height:g}; download it again")
    camera = Intrinsics(K[0], K[4], K[2], K[5], int(width), int(height))
    return K[0], base / 1000, doffs, camera


def _line(text: str, key: str, path: Path) -> str:
    found = re.search(rf"(?m)^{key}\s*=\s*(\[[^\]]*\]|[-+.\deE]+)\s*$", text)
    if found is None:
        raise broken(path, f"has no {key}; it is no calibration of Middlebury 2014")
    return found.group(1)
