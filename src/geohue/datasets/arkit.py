"""ARKit frames as apps and ARKitScenes store them: pictures, LiDAR depth in mm, confidence."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from geohue.camera import Intrinsics
from geohue.datasets.frames import Dataset, Frame, numbers, sorted_files
from geohue.read.cameras.intrinsics import read_intrinsics
from geohue.read.files import broken, read_bytes, with_notes


@dataclass(frozen=True, slots=True)
class _Files:
    """Where one app puts the files of a frame, by the name of its picture."""

    color: str  # the pictures, as a pattern
    depth: Callable[[Path, str], Path]
    camera: Callable[[Path, str], Path]
    confidence: Callable[[Path, str], Path]


def _number(stem: str) -> str:
    return stem.removeprefix("frame_")


_SCANNER_APP = _Files(
    "frame_*.jpg",
    lambda folder, stem: folder / f"depth_{_number(stem)}.png",
    lambda folder, stem: folder / f"{stem}.json",
    lambda folder, stem: folder / f"conf_{_number(stem)}.png",
)
_POLYCAM = _Files(
    "images/*.jpg",
    lambda folder, stem: folder / "depth" / f"{stem}.png",
    lambda folder, stem: folder / "cameras" / f"{stem}.json",
    lambda folder, stem: folder / "confidence" / f"{stem}.png",
)
_ARKITSCENES = _Files(
    "lowres_wide/*.png",
    lambda folder, stem: folder / "lowres_depth" / f"{stem}.png",
    lambda folder, stem: folder / "lowres_wide_intrinsics" / f"{stem}.pincam",
    lambda folder, stem: folder / "confidence" / f"{stem}.png",
)
_APPS = (_SCANNER_APP, _POLYCAM, _ARKITSCENES)


def matches(folder: Path) -> bool:
    """Whether pictures lie beside depth maps and cameras as one of the apps puts them."""
    return folder.is_dir() and _found(folder) is not None


def load(folder: Path) -> Dataset:
    """List the pictures that have a depth map."""
    found = _found(folder)
    if found is None:
        raise broken(folder, "has no pictures with LiDAR depth; export all data of the scan")
    place, app = found
    frames = []
    for color in sorted_files(place, app.color):
        depth = app.depth(place, color.stem)
        if not depth.is_file():
            continue
        confidence = app.confidence(place, color.stem)
        camera = _camera(app.camera(place, color.stem))
        sure = confidence if confidence.is_file() else None
        frames.append(Frame(color.stem, color, depth, camera, "mm", confidence=sure))
    return Dataset("arkit", folder, frames)


def _found(folder: Path) -> tuple[Path, _Files] | None:
    """Return the folder that has the frames, this one or keyframes/ in it, and the app."""
    for place in (folder, folder / "keyframes"):
        for app in _APPS:
            color = next(place.glob(app.color), None)
            if color is None:
                continue
            stems = (file.stem for file in place.glob(app.color))
            if any(app.depth(place, stem).is_file() for stem in stems):
                return place, app
    return None


def _camera(file: Path) -> Intrinsics | None:
    """Read the camera of one frame; None where there is no file."""
    if not file.is_file():
        return None
    if file.suffix != ".pincam":
        return with_notes(read_intrinsics, file)[0]
    # width, height, fx, fy, cx, cy
    values = numbers(read_bytes(file, 4096).decode("latin-1").split(), file)
    if len(values) != 6:
        raise broken(file, "is no camera of ARKitScenes (six numbers); download it again")
    fx, fy, cx, cy = values[2:]
    return Intrinsics(fx, fy, cx, cy, int(values[0]), int(values[1]))
