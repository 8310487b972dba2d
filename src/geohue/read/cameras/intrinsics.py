"""Camera intrinsics from text or from the camera files that are in use."""

from __future__ import annotations

import re
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics, first_value
from geohue.errors import GeohueError, GeohueWarning
from geohue.read.arrays import read_npy
from geohue.read.cameras.text import NUMBER, parse_camera_text
from geohue.read.files import broken, read_bytes

_READ = (
    "what is read: 'fx,fy,cx,cy' as text, JSON (fx, fy, cx, cy; Open3D; K), "
    "OpenCV YAML or XML, ROS camera_info YAML, Kalibr YAML, a 3 x 3 matrix as text or NPY"
)
_FILE_LIMIT = 16 << 20
_ALIASES: dict[str, tuple[str, ...]] = {
    "fx": ("fx",),
    "fy": ("fy",),
    "cx": ("cx", "ppx", "cx0", "x_offset"),
    "cy": ("cy", "ppy", "cy0", "y_offset"),
    "width": ("width", "image_width", "img_width", "w"),
    "height": ("height", "image_height", "img_height", "h"),
    "matrix": (
        *("intrinsic_matrix", "camera_matrix", "cameramatrix", "camera_matrix_left"),
        *("k", "cam_k", "k1", "k_left", "m1", "mtx", "intrinsic", "intrinsics", "rgb_intrinsics"),
        *("cameraintrinsics", "camera_intrinsics", "intrinsicmatrix", "camera_k"),
    ),
    "distortion": (
        *("distortion_coefficients", "distortion_coeffs", "dist_coeffs", "distcoeffs"),
        *("distortion", "dist", "coeffs", "d", "d1"),
    ),
    "size": ("size", "resolution", "image_size"),
}


def read_intrinsics(text_or_path: str | Path) -> Intrinsics:
    """Read pinhole intrinsics from four numbers or from a file.

    Parameters
    ----------
    text_or_path : str or Path
        ``"fx,fy,cx,cy"`` in pixels, or a file: JSON with fx, fy, cx, cy (also RealSense's ppx,
        ppy), width, height; Open3D's camera or trajectory JSON; JSON, OpenCV YAML or XML, or ROS
        camera_info YAML with a camera matrix; Kalibr's YAML of one camera; text with a 3 x 3
        matrix or the four numbers; NPY with a 3 x 3 matrix.

    Returns
    -------
    Intrinsics
        With the image size where the file has it, and `depth_scale` (units per metre) where the
        file has one of at least 1.

    Raises
    ------
    GeohueError
        If there is no such file, nothing recognisable in it, a matrix that is no camera matrix, or
        several cameras to choose from.

    Warns
    -----
    GeohueWarning
        If the file gives lens distortion, which is left out: the picture is taken as undistorted.
        Also if its depth_scale is below 1 and therefore not in units per metre.

    Examples
    --------
    >>> read_intrinsics("525, 525, 319.5, 239.5")
    Intrinsics(fx=525.0, fy=525.0, cx=319.5, cy=239.5, width=None, height=None, depth_scale=None)
    """
    numbers = _four_numbers(text_or_path)
    if numbers is not None:
        fx, fy, cx, cy = numbers
        return Intrinsics(fx, fy, cx, cy)
    try:
        data = read_bytes(text_or_path, _FILE_LIMIT)
    except GeohueError as error:
        if "no such file" not in str(error):
            raise
        cause = "no such file, nor the four numbers fx,fy,cx,cy"
        raise broken(text_or_path, f"{cause}; {_READ}") from error
    if data.startswith(b"\x93NUMPY"):
        return _from_array(read_npy(text_or_path), text_or_path)
    text = data.decode("utf-8-sig", "replace")
    content = parse_camera_text(text, text_or_path)
    if content is None:
        content = _plain_numbers(text)
    camera = _find_camera(content, text_or_path)
    if camera is None:
        raise broken(text_or_path, f"has no camera intrinsics; {_READ}")
    return _from_mapping(camera, text_or_path)


def intrinsics_from_mapping(content: Mapping[Any, Any], name: str = "intrinsics") -> Intrinsics:
    """Return the camera that a mapping describes, with the keys of `read_intrinsics`' files.

    Parameters
    ----------
    content : mapping
        Numbers, lists or arrays by name: fx, fy, cx, cy; or a camera matrix.
    name : str
        What errors and warnings call it.

    Examples
    --------
    >>> intrinsics_from_mapping({"K": np.diag([500.0, 500.0, 1.0]), "width": 640, "height": 480}).fx
    500.0
    """
    plain = {str(key): plain_value(value) for key, value in content.items()}
    camera = _find_camera(plain, name)
    if camera is None:
        keys = ", ".join(plain) or "none"
        raise broken(name, f"fx, fy, cx, cy or K expected, found the keys: {keys[:80]}")
    return _from_mapping(camera, name)


def plain_value(value: Any) -> Any:
    """Return arrays and NumPy's numbers as Python's own."""
    if isinstance(value, Mapping):
        return {str(key): plain_value(inner) for key, inner in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    return list(value) if isinstance(value, tuple) else value


def _from_array(array: NDArray[Any], path: str | Path) -> Intrinsics:
    try:
        return Intrinsics.from_numbers(array)
    except GeohueError as error:
        raise broken(path, f"{error}; save K alone") from error


def _four_numbers(text: object) -> list[float] | None:
    """Return four numbers if that is all that the text has."""
    if not isinstance(text, str):
        return None
    words = [word for word in re.split(r"[\s,;]+", text.strip()) if word]
    if len(words) != 4 or not all(re.fullmatch(NUMBER, word) for word in words):
        return None
    return [float(word) for word in words]


def _plain_numbers(text: str) -> dict[str, Any]:
    """Return what a file of bare numbers means: four intrinsics or a 3 x 3 (or 3 x 4) matrix."""
    text = re.sub(r"(?m)#.*$", "", text)
    words = [word for word in re.split(r"[\s,;\[\]]+", text[:10_000]) if word]
    if not all(re.fullmatch(NUMBER, word) for word in words):
        return {}
    numbers = [float(word) for word in words]
    if len(numbers) == 4:
        return dict(zip(("fx", "fy", "cx", "cy"), numbers, strict=True))
    return {"k": numbers} if len(numbers) == 9 else {}


def _lookup(camera: Mapping[str, Any], meaning: str) -> object:
    """Return what a camera file says of `meaning`, under any of its names."""
    return first_value(camera, _ALIASES[meaning])


def _find_camera(content: object, path: str | Path, depth: int = 0) -> dict[str, Any] | None:
    """Return the mapping, at any level, that has a camera; GeohueError if several differ."""
    if depth > 4:
        return None
    if isinstance(content, list):  # a trajectory: every pose repeats its camera
        inner = [c for item in content[:1] if (c := _find_camera(item, path, depth + 1))]
        return inner[0] if inner else None
    if not isinstance(content, dict):
        return None
    if _has_camera(content):
        return content
    found = {key: c for key, v in content.items() if (c := _find_camera(v, path, depth + 1))}
    if len({repr(camera) for camera in found.values()}) > 1:
        names = ", ".join(str(key) for key in list(found)[:8])
        cause = f"has several cameras ({names})"
        raise broken(path, f"{cause}; give the one of the picture as fx,fy,cx,cy")
    return next((content | camera for camera in found.values()), None)


def _has_camera(content: dict[str, Any]) -> bool:
    named = all(_lookup(content, name) is not None for name in ("fx", "fy", "cx", "cy"))
    matrix = _lookup(content, "matrix")
    return named or _numbers(matrix) is not None


def _numbers(value: object) -> list[float] | None:
    """Return a flat list of the numbers in a list, a nested list or an OpenCV/ROS matrix."""
    if isinstance(value, dict):
        value = value.get("data")
    if not isinstance(value, list) or len(value) > 100:
        return None
    try:
        return [float(x) for x in np.asarray(value, np.float64).ravel()]
    except (TypeError, ValueError, OverflowError):
        return None


def _from_mapping(camera: dict[str, Any], path: str | Path) -> Intrinsics:
    named = [_lookup(camera, name) for name in ("fx", "fy", "cx", "cy")]
    if any(value is None for value in named):
        named = list(_from_matrix(_numbers(_lookup(camera, "matrix")) or [], path))
    width, height = _image_size(camera)
    scale = _depth_scale(camera, path)
    distortion = _numbers(_lookup(camera, "distortion"))
    if distortion and any(distortion):
        cause = "its lens distortion is left out; undistort the picture first if edges look bent"
        warnings.warn(f"{path}: {cause}", GeohueWarning, stacklevel=3)
    try:
        fx, fy, cx, cy = (float(value) for value in named)  # type: ignore[arg-type]
        return Intrinsics(fx, fy, cx, cy, width, height, scale)
    except (TypeError, ValueError, OverflowError) as error:
        cause = str(error) if isinstance(error, GeohueError) else "fx, fy, cx, cy must be numbers"
        raise broken(path, cause) from error


def _from_matrix(numbers: list[float], path: str | Path) -> tuple[float, float, float, float]:
    """Return fx, fy, cx, cy of a matrix written row by row or (Open3D) column by column."""
    try:
        if len(numbers) not in (4, 9):
            raise GeohueError("its matrix is not a camera matrix [fx 0 cx; 0 fy cy; 0 0 1]")
        camera = Intrinsics.from_numbers(numbers)
    except GeohueError as error:
        raise broken(path, f"{error}; give fx,fy,cx,cy") from error
    return camera.fx, camera.fy, camera.cx, camera.cy


def _image_size(camera: dict[str, Any]) -> tuple[int | None, int | None]:
    width, height = _lookup(camera, "width"), _lookup(camera, "height")
    both = _numbers(_lookup(camera, "size"))
    if width is None and height is None and both and len(both) == 2:
        width, height = both
    sides = [_whole(width), _whole(height)]
    return (sides[0], sides[1]) if None not in sides else (None, None)


def _whole(value: object) -> int | None:
    if not isinstance(value, int | float) or not 1 <= value <= 1e6:
        return None
    return int(value)


def _depth_scale(camera: dict[str, Any], path: str | Path) -> float | None:
    value = camera.get("depth_scale")
    if not isinstance(value, int | float) or isinstance(value, bool):
        return None
    if 0 < value < 1:  # metres (RealSense) or millimetres (BOP) a unit: they cannot be told apart
        cause = f"its depth_scale {value} is not in units per metre and is left out"
        warnings.warn(f"{path}: {cause}; give depth_scale", GeohueWarning, stacklevel=4)
        return None
    return float(value) if 1 <= value < 1e9 else None
