"""Calibrations of a range sensor with its colour cameras, from the files that are in use."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics, first_value
from geohue.errors import GeohueError
from geohue.read.cameras.intrinsics import (
    _from_matrix,
    _image_size,
    _lookup,
    _numbers,
    plain_value,
)
from geohue.read.cameras.text import NUMBER, parse_camera_text
from geohue.read.files import broken, read_bytes
from geohue.sensors.kinect import DisparityModel
from geohue.sensors.lens import Lens, LensModel
from geohue.sensors.rig import PosedCamera, Rig, Vector

_READ = (
    "what is read: JSON or YAML with a depth and a colour camera (K, dist) and R, T from depth "
    "to colour; OpenCV's stereo calibration (M1, D1, M2, D2, R, T; camera 1 is the depth "
    "camera); KITTI's calib.txt; ROS camera_info of depth and colour with a transform"
)
_FILE_LIMIT = 16 << 20
_RANGE_NAMES = ("depth", "ir", "infrared", "tof", "range", "depth_camera", "left_ir")
_COLOR_NAMES = (
    *("rgb", "color", "colour", "rgb_camera", "color_camera", "c1", "c2"),
    *("color1", "color2", "rgb1", "rgb2", "left", "right", "cam1", "cam2", "camera1", "camera2"),
)
_FAR = 1.0  # metres between depth and colour camera beyond which the unit is in doubt

_Place = tuple[Mapping[str, Any], tuple[str, ...], tuple[str, ...]]


def read_rig(path: str | Path, *more: str | Path) -> Rig:
    """Read the calibration of a range sensor and its colour cameras.

    Parameters
    ----------
    path, *more : path-like
        One file: JSON or YAML with named cameras (``depth`` or ``ir``; ``rgb``, ``color``,
        ``c1`` ..), each with ``K`` and ``dist``, and R, T such that ``X_color = R X_depth + T``;
        OpenCV's stereo calibration in YAML or XML, with the depth or infrared camera as the
        first; or KITTI's calib.txt (LiDAR, left and right colour camera). OpenCV's intrinsics and
        extrinsics may be two files. For ROS: the camera_info of the depth camera, that of the
        colour camera and a transform.

    Returns
    -------
    Rig

    Raises
    ------
    GeohueError
        If a file cannot be read, or the calibration is none of these or incomplete.
    """
    texts = [read_bytes(p, _FILE_LIMIT).decode("utf-8-sig", "replace") for p in (path, *more)]
    if not more and re.search(r"(?m)^P2\s*:", texts[0]):
        return _kitti(texts[0], path)
    contents = [parse_camera_text(text, p) for text, p in zip(texts, (path, *more), strict=True)]
    try:
        if len(contents) == 3:
            return _checked(_ros(contents), path)
        merged: dict[str, Any] = {}
        for content in contents:
            merged |= content if isinstance(content, dict) else {}
        return _checked(_named(merged) or _opencv(merged), path)
    except GeohueError as error:
        raise broken(path, str(error)) from error


def rig_from_mapping(content: Mapping[Any, Any]) -> Rig:
    """Return the rig that a mapping describes, with the keys of `read_rig`'s JSON and YAML.

    Parameters
    ----------
    content : mapping
        Numbers, lists or arrays by name, also nested: depth and colour cameras with R and T, or
        OpenCV's M1, D1, M2, D2, R, T.

    Raises
    ------
    GeohueError
        If it describes no rig.
    """
    plain = {str(key): plain_value(value) for key, value in content.items()}
    try:
        return _checked(_named(plain) or _opencv(plain), "rig")
    except GeohueError as error:
        raise broken("rig", str(error)) from error


def _checked(rig: Rig | None, path: str | Path) -> Rig:
    if rig is None:
        raise GeohueError(f"is no calibration of a range sensor with colour cameras; {_READ}")
    far = max(float(np.linalg.norm(camera.translation)) for camera in rig.cameras)
    if far <= _FAR or rig.depth is None:
        return rig
    note = (
        f"{path}: the colour camera is {far:.3g} m from the depth camera; T must be in metres "
        "(divide it by 1000 if it is in millimetres)"
    )
    return replace(rig, warnings=(*rig.warnings, note))


# --- named cameras ---------------------------------------------------------------------------


def _named(content: dict[str, Any]) -> Rig | None:
    """Read ``{"depth": {K, dist}, "rgb": {K, dist}, "R_depth_to_rgb": ...}`` and its kin."""
    lower = {str(key).lower(): value for key, value in content.items()}
    depth = next((lower[n] for n in _RANGE_NAMES if isinstance(lower.get(n), dict)), None)
    colors = {n: lower[n] for n in _COLOR_NAMES if isinstance(lower.get(n), dict)}
    if depth is None or not colors:
        return None
    cameras: list[PosedCamera] = []
    for name, camera in colors.items():
        R, T = _pose_of(name, camera, lower, cameras, alone=len(colors) == 1)
        cameras.append(PosedCamera(_lens(camera, content), R, T, name))
    unit = lower.get("depth_unit_m")
    return Rig(
        tuple(cameras),
        _lens(depth, content),
        _disparity_model(depth),
        float(unit) if isinstance(unit, int | float) and 0 < unit < 1e3 else None,
    )


def _pose_of(
    name: str,
    camera: Mapping[str, Any],
    whole: Mapping[str, Any],
    before: Sequence[PosedCamera],
    alone: bool,
) -> tuple[Vector, Vector]:
    """Return R and T of ``X_camera = R X_depth + T``."""
    own = {str(key).lower(): value for key, value in camera.items()}
    if "r2" in own and "t2" in own and before:  # Herrera: X = R2' (X_first - t2)
        R2, t2 = _array(own["r2"], (3, 3), "R2"), _array(own["t2"], (3,), "t2")
        first = before[0]
        return R2.T @ first.rotation, R2.T @ (first.translation - t2)
    places: list[_Place] = [(own, ("r", "rotation"), ("t", "translation"))]
    tail = f"depth_to_{name}"
    places.append((whole, (f"r_{tail}", f"dr_{tail}"), (f"t_{tail}", f"dt_{tail}")))
    if alone:
        places.append((whole, ("r", "rotation"), ("t", "translation")))
    for place, rotations, translations in places:
        R, T = first_value(place, rotations), first_value(place, translations)
        if R is not None and T is not None:
            return _array(R, (3, 3), "R"), _array(T, (3,), "T")
    matrix = next((own[k] for k in own if k.startswith("t_") and len(own[k]) in (3, 4)), None)
    if matrix is not None:
        T4 = _array(matrix, (4, 4), "transform")
        return T4[:3, :3], T4[:3, 3]
    raise GeohueError(f"has no R and T from the depth camera to the camera {name!r}; add them")


def _disparity_model(depth: Mapping[str, Any]) -> DisparityModel | None:
    values = _numbers(depth.get("dc"))
    return DisparityModel(values[0], values[1]) if values and len(values) == 2 else None


# --- OpenCV, ROS, KITTI ------------------------------------------------------------------------


def _opencv(content: dict[str, Any]) -> Rig | None:
    """Read a stereo calibration whose first camera is the depth or infrared camera."""
    flat = {re.sub(r"_", "", str(key).lower()): value for key, value in content.items()}
    lenses = []
    for n in ("1", "2"):
        K = first_value(flat, [s + n for s in ("m", "k", "cameramatrix", "intrinsics")])
        D = first_value(flat, [s + n for s in ("d", "distcoeffs", "distortion")])
        if not K:
            return None
        size = {key: content[key] for key in content if "size" in key or key in ("width", "height")}
        lenses.append(_lens({"k": K, "d": D, **size}, {}))
    R, T = first_value(flat, ("r", "rotation")), first_value(flat, ("t", "translation"))
    if R is None or T is None:
        raise GeohueError("has no R and T between its two cameras; give the extrinsics file too")
    pose = _array(R, (3, 3), "R"), _array(T, (3,), "T")
    note = "the first camera is taken for the depth camera, the second for the colour camera"
    return Rig((PosedCamera(lenses[1], *pose),), lenses[0], warnings=(note,))


def _ros(contents: list[Any]) -> Rig:
    """Read the camera_info of depth and colour and the transform between them, in any order."""
    infos = [c for c in contents if isinstance(c, dict) and _has_matrix(c)]
    others = [c for c in contents if not (isinstance(c, dict) and _has_matrix(c))]
    if len(infos) != 2 or len(others) != 1 or not isinstance(others[0], dict):
        raise GeohueError("three files: expected camera_info of depth, of colour, and a transform")
    depth, color = infos
    transform = others[0]
    R, T = _transform(transform)
    frames = [_frame(c) for c in (depth, color, transform)]
    if frames[2] and frames[2] == frames[0] and frames[0] != frames[1]:
        R, T = R.T, -R.T @ T  # tf: a point of the child (colour) in the parent's (depth) frame
    return Rig((PosedCamera(_lens(color, {}), R, T),), _lens(depth, {}))


def _has_matrix(content: Mapping[str, Any]) -> bool:
    return _numbers(_lookup(content, "matrix")) is not None and not _named_part(content, "rotation")


def _named_part(content: Mapping[str, Any], name: str) -> Any:
    inner = content.get("transform", content)
    return inner.get(name) if isinstance(inner, dict) else None


def _frame(content: Mapping[str, Any]) -> object:
    header = content.get("header", content)
    return header.get("frame_id") if isinstance(header, dict) else None


def _transform(content: Mapping[str, Any]) -> tuple[Vector, Vector]:
    """Read a translation with a quaternion (x, y, z, w) or a matrix."""
    turn, shift = _named_part(content, "rotation"), _named_part(content, "translation")
    if turn is None or shift is None:
        raise GeohueError("the transform has no rotation and translation")
    if isinstance(turn, dict) and all(key in turn for key in "xyzw"):
        turn = [turn[key] for key in "xyzw"]
    if isinstance(shift, dict):
        shift = [shift.get(key) for key in "xyz"]
    values = _numbers(turn) or []
    T = _array(shift, (3,), "translation")
    if len(values) == 4:
        return rotation_from_quaternion(values), T
    return _array(turn, (3, 3), "rotation"), T


def rotation_from_quaternion(xyzw: Sequence[float]) -> Vector:
    """Return the rotation matrix of a quaternion x, y, z, w.

    Examples
    --------
    >>> rotation_from_quaternion([0, 0, 1, 1]).round().tolist()
    [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    """
    from scipy.spatial.transform import Rotation

    q = np.asarray(xyzw, np.float64)
    if q.shape != (4,) or not 0 < np.linalg.norm(q) < np.inf:
        raise GeohueError(f"quaternion {list(xyzw)[:6]}: expected x, y, z, w, not all zero")
    return np.asarray(Rotation.from_quat(q).as_matrix())


def _kitti(text: str, path: str | Path) -> Rig:
    """Read a calib.txt of KITTI object: P2, P3, R0_rect, Tr_velo_to_cam."""
    rows: dict[str, list[float]] = {}
    for line in text.splitlines():
        key, _, rest = line.partition(":")
        words = rest.split()
        if len(words) in (9, 12) and all(re.fullmatch(NUMBER, word) for word in words):
            rows[key.strip()] = [float(word) for word in words]
    try:
        velo = np.vstack([_array(rows["Tr_velo_to_cam"], (3, 4), "Tr_velo_to_cam"), [0, 0, 0, 1]])
        rect = np.eye(4)
        rect[:3, :3] = _array(rows["R0_rect"], (3, 3), "R0_rect")
        views = [(n, _array(rows[f"P{n}"], (3, 4), f"P{n}")) for n in (2, 3) if f"P{n}" in rows]
        cameras = tuple(_kitti_camera(P, rect @ velo, f"image_{n}") for n, P in views)
        return Rig(cameras)
    except KeyError as error:
        raise broken(
            path, f"has no line {error.args[0]}; use the calib file of the frame"
        ) from error
    except GeohueError as error:
        raise broken(path, str(error)) from error


def _kitti_camera(P: Vector, velo_to_rect: Vector, name: str) -> PosedCamera:
    """Split ``P = K [I | t]``; `velo_to_rect` brings LiDAR points to the rectified camera 0."""
    K = P[:, :3]
    fx, fy, cx, cy = (float(K[i]) for i in ((0, 0), (1, 1), (0, 2), (1, 2)))
    lens = Lens(Intrinsics(fx, fy, cx, cy))
    shift = np.linalg.solve(K, P[:, 3])
    return PosedCamera(lens, velo_to_rect[:3, :3], velo_to_rect[:3, 3] + shift, name)


# --- one camera --------------------------------------------------------------------------------


def _lens(camera: Mapping[str, Any], whole: Mapping[str, Any]) -> Lens:
    named = [_lookup(camera, name) for name in ("fx", "fy", "cx", "cy")]
    if any(not isinstance(value, int | float) for value in named):
        named = list(_from_matrix(_numbers(_lookup(camera, "matrix")) or [], "the calibration"))
    fx, fy, cx, cy = (float(value) for value in named)  # type: ignore[arg-type]
    size = _image_size(dict(camera))
    if size == (None, None):
        size = _image_size(dict(whole))
    bends_rays = any(str(key).lower() == "dkc" for key in camera)
    distortion = camera.get("dkc") if bends_rays else _lookup(camera, "distortion")
    model = str(camera.get("distortion_model", camera.get("model", ""))).lower()
    kind: LensModel = "inverse" if bends_rays else "brown"
    if any(word in model for word in ("equidistant", "fisheye", "kannala")):
        kind = "fisheye"
    values = [] if distortion is None else _numbers(distortion)
    if values is None:
        raise GeohueError("has distortion coefficients that are no numbers; export it again")
    if not any(values):
        values = []
    return Lens(Intrinsics(fx, fy, cx, cy, *size), tuple(values), kind)


def _array(value: object, shape: tuple[int, ...], name: str) -> NDArray[np.float64]:
    numbers = _numbers(value)
    if numbers is None or len(numbers) != int(np.prod(shape)) or not np.isfinite(numbers).all():
        raise GeohueError(f"{name} must be {' x '.join(map(str, shape))} numbers")
    return np.array(numbers).reshape(shape)
