"""What a scene is given as a path or a mapping in place of an array or a camera.

`geohue.scene.given` calls these by name.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics
from geohue.read.arrays import read_npy
from geohue.read.cameras.intrinsics import intrinsics_from_mapping, read_intrinsics
from geohue.read.cameras.rig import read_rig, rig_from_mapping
from geohue.read.cameras.stereo_calibration import read_stereo_calibration
from geohue.read.clouds.cloud import CLOUD_READERS, CloudData, read_cloud
from geohue.read.files import read_bytes, with_notes
from geohue.read.images.depth_units import DepthUnit, depth_unit
from geohue.read.images.disparity import parse_disparity_scale, read_disparity
from geohue.read.images.pictures import decode_picture, read_color, read_depth
from geohue.read.images.raw_depth import read_range
from geohue.read.scenes.scenes import is_cloud, read_scene
from geohue.scene import Scene
from geohue.sensors.rig import Rig
from geohue.stereo.rig import StereoRig

Notes = tuple[str, ...]
_ORIENTATION = 0x0112  # the tag of EXIF


def picture(path: str | Path) -> tuple[NDArray[np.uint8], int]:
    """Read a colour picture as it is stored, and EXIF's mark of how it is turned, 1 to 8."""
    return read_color(path), read_orientation(path)


def read_orientation(path: str | Path) -> int:
    """Read how a picture is to be turned; 1 where the file does not say."""
    from PIL import Image

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            with Image.open(io.BytesIO(read_bytes(path))) as image:
                mark = image.getexif().get(_ORIENTATION, 1)
        except Exception:  # whatever a damaged or unknown header makes a plug-in raise
            return 1
    return mark if isinstance(mark, int) and 1 <= mark <= 8 else 1


def depth(path: str | Path, scale: float | str | None) -> tuple[NDArray[np.float32], Notes]:
    """Read a depth map in metres, NaN where missing."""
    image = read_depth(path, scale)
    return image.depth, image.warnings


def unit(name: str) -> DepthUnit:
    """Return the unit of depth that a name stands for."""
    return depth_unit(name)


def values(path: str | Path) -> NDArray[Any]:
    """Read a map of numbers, such as a confidence or a mask."""
    if Path(path).suffix.lower() == ".npy":
        return read_npy(path)
    return decode_picture(path)


def camera(given: str | Path | Mapping[Any, Any]) -> tuple[Intrinsics, Notes]:
    """Read the camera of a file, a text or a mapping."""
    if isinstance(given, Mapping):
        return with_notes(intrinsics_from_mapping, given)
    return with_notes(read_intrinsics, given)


def stereo_rig(given: str | Path) -> tuple[StereoRig, Notes]:
    """Read the calibration of a stereo pair."""
    return with_notes(read_stereo_calibration, given)


def rig(given: str | Path | Mapping[Any, Any] | Sequence[str | Path]) -> Rig:
    """Read the calibration of a range sensor and its cameras from one or more files."""
    if isinstance(given, Mapping):
        return rig_from_mapping(given)
    return read_rig(given) if isinstance(given, str | Path) else read_rig(*given)


def disparity(path: str | Path, scale: float | str | None) -> tuple[NDArray[np.float32], Notes]:
    """Read a disparity map in pixels, NaN where missing."""
    pixels = parse_disparity_scale(scale) if isinstance(scale, str) else scale
    image = read_disparity(path, pixels)
    return image.disparity, image.warnings


def cloud(path: str | Path) -> tuple[CloudData, Notes]:
    """Read a cloud."""
    return with_notes(read_cloud, path)


def scene(path: str | Path) -> Scene:
    """Read a cloud, or an image alone."""
    return read_scene(path)


def model(folder: str | Path) -> Scene | None:
    """Read the cloud of a folder that has one (COLMAP), None otherwise."""
    return read_scene(folder) if is_cloud(folder) else None


def range_points(
    path: str | Path, calibration: Rig, scale: float | str | None = None
) -> tuple[NDArray[np.float32], Notes]:
    """Read a scan, or the depth map of a rig's depth camera."""
    if Path(path).suffix.lower() in CLOUD_READERS and calibration.depth is None:
        return read_cloud(path).points, ()
    image = read_range(path, calibration, scale)
    return image.depth, image.warnings
