"""Pairs of a stereo camera: left/ beside right/ (image_2/ beside image_3/, cam0/ beside cam1/)."""

from __future__ import annotations

import warnings
from pathlib import Path

from geohue.datasets.frames import Dataset, Frame, sorted_files
from geohue.errors import GeohueError, GeohueWarning
from geohue.read.cameras.stereo_calibration import read_stereo_calibration
from geohue.read.files import broken
from geohue.stereo.rig import StereoRig

_SIDES = (
    *(("left", "right"), ("Left", "Right"), ("image_2", "image_3"), ("image_02", "image_03")),
    *(("image_0", "image_1"), ("image_00", "image_01"), ("cam0", "cam1"), ("view1", "view5")),
)
_INNER = ("", "data")
_PICTURES = ("*.png", "*.jpg", "*.jpeg", "*.JPG", "*.PNG", "*.ppm", "*.pgm", "*.bmp", "*.tif")
_CALIBRATIONS = (
    *("calib.txt", "calib.yml", "calib.yaml", "calib.json", "stereo.yml", "stereo.yaml"),
    *("calibration.yml", "calibration.yaml", "calibration.json", "camchain.yaml"),
    *("calib_cam_to_cam.txt", "intrinsics.yml"),
)


def matches(folder: Path) -> bool:
    """Whether pictures of two cameras lie side by side, without any depth."""
    return folder.is_dir() and not (folder / "depth").is_dir() and _places(folder) is not None


def load(folder: Path) -> Dataset:
    """Pair the pictures by their names or, where those differ, by their order."""
    places = _places(folder)
    if places is None:
        raise broken(folder, "has no pictures in left/ and right/")
    left, right = (sorted_files(place, *_PICTURES) for place in places)
    by_stem = {file.stem: file for file in right}
    pairs = [(file, by_stem[file.stem]) for file in left if file.stem in by_stem]
    notes: tuple[str, ...] = ()
    if len(pairs) < len(left) or len(pairs) < len(right):
        counts = f"{len(left)} left and {len(right)} right picture(s)"
        if not pairs and len(left) == len(right):
            pairs = list(zip(left, right, strict=True))
            notes = (f"{folder}: names differ, so that pictures are paired in their order",)
        elif not pairs:
            raise broken(folder, f"has {counts}, of other names: give both sides the same names")
        else:
            notes = (f"{folder}: {counts}, of which {len(pairs)} have the same name",)
    rig, more = _calibration(folder)
    frames = [Frame(a.stem, a, None, right=b, stereo=rig) for a, b in pairs]
    return Dataset("stereo", folder, frames, (*notes, *more), registered=None)


def _places(folder: Path) -> tuple[Path, Path] | None:
    for one, other in _SIDES:
        for inner in _INNER:
            places = folder / one / inner, folder / other / inner
            if all(place.is_dir() and sorted_files(place, *_PICTURES) for place in places):
                return places
    return None


def _calibration(folder: Path) -> tuple[StereoRig | None, tuple[str, ...]]:
    """Read the first calibration beside the pictures that is one of a pair."""
    for name in _CALIBRATIONS:
        file = folder / name
        if file.is_file():
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore", GeohueWarning)
                    return read_stereo_calibration(file), ()
            except GeohueError:
                continue
    return None, (f"{folder}: no stereo calibration found beside the pictures: give rig=...",)
