"""Record3D (iOS), unpacked: rgb/ and depth/ (EXR), or rgbd/ with .jpg, .depth and .conf."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics
from geohue.datasets.frames import (
    Dataset,
    Depth,
    Frame,
    picture_in,
    pose_from_quaternion,
    sorted_files,
)
from geohue.errors import GeohueError
from geohue.read.extras import optional
from geohue.read.files import broken, read_bytes, reason

_NAMES = ("metadata", "metadata.json")


def matches(folder: Path) -> bool:
    """Whether there is a metadata file with a camera, beside rgbd/ or depth/."""
    if not any((folder / part).is_dir() for part in ("rgbd", "depth")):
        return False
    try:
        return "K" in _metadata(folder)
    except GeohueError:
        return False


def load(folder: Path) -> Dataset:
    """List the frames; depth is in metres, at a lower resolution than the pictures."""
    about = _metadata(folder)
    poses = about.get("poses", [])
    frames: list[Frame] = []
    place = folder / "rgb" if (folder / "rgb").is_dir() else folder / "rgbd"
    for color in sorted_files(place, "*.jpg", "*.png"):
        depth, confidence = _depth_of(folder, color.stem, about)
        if depth is None:
            continue
        i = int(color.stem) if color.stem.isdigit() else len(frames)
        pose = pose_from_quaternion([*poses[i][4:7], *poses[i][:4]]) if i < len(poses) else None
        camera = _camera(about, i, folder)
        frames.append(Frame(color.stem, color, depth, camera, 1.0, pose, confidence=confidence))
    return Dataset("record3d", folder, frames)


def _metadata(folder: Path) -> dict[str, Any]:
    file = next((f for name in _NAMES if (f := folder / name).is_file()), None)
    if file is None:
        return {}
    try:
        content = json.loads(read_bytes(file, 1 << 28))
    except (ValueError, RecursionError) as error:
        raise broken(file, f"is damaged JSON ({reason(error)}); export it again") from error
    return content if isinstance(content, dict) else {}


def _camera(about: dict[str, Any], i: int, folder: Path) -> Intrinsics:
    """Return the camera of a picture, of which each may have its own."""
    own = about.get("perFrameIntrinsicCoeffs") or []
    values = own[i] if i < len(own) else about["K"]
    try:
        return Intrinsics.from_numbers(values, int(about["w"]), int(about["h"]))
    except (GeohueError, KeyError, TypeError, ValueError) as error:
        raise broken(folder, f"its metadata has no camera ({reason(error)})") from error


def _depth_of(
    folder: Path, stem: str, about: dict[str, Any]
) -> tuple[Depth | None, Path | Any | None]:
    """Return where a frame's depth and confidence come from; None where it has none."""
    exr = folder / "depth" / f"{stem}.exr"
    if exr.is_file():
        return exr, picture_in(folder / "conf", stem)
    packed, sure = (folder / "rgbd" / f"{stem}.{end}" for end in ("depth", "conf"))
    if not packed.is_file():
        return None, None
    shape = int(about.get("dh", 0)), int(about.get("dw", 0))
    confidence = partial(_unpacked, sure, shape, "uint8") if sure.is_file() else None
    return partial(_unpacked, packed, shape, "<f4"), confidence


def _unpacked(path: Path, shape: tuple[int, int], kind: str) -> NDArray[Any]:
    """Return the numbers of a file that Record3D has compressed."""
    lzfse = optional("liblzfse", "phones", path)
    try:
        values = np.frombuffer(lzfse.decompress(read_bytes(path)), kind)
        return values.reshape(shape)
    except GeohueError:
        raise
    except Exception as error:  # the library's own class of errors
        raise broken(path, f"is no compressed map of {shape[1]} x {shape[0]}") from error
