"""The cameras of a stereo pair from the keys that the calibration files in use have."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics, first_value
from geohue.errors import GeohueError
from geohue.stereo.rig import StereoRig, camera_from_matrix

Content = Mapping[str, Any]
Matrix = NDArray[np.float64]

_MILLIMETRES = 10.0  # no pair of cameras stands so many metres apart: it is millimetres

# Middlebury 2005 and 2006, of which dmin.txt says only the rest.
_FOCAL_2006, _BASELINE_2006, _ROWS_2006 = 3740.0, 0.160, 1110


def rig_from_content(content: Content) -> StereoRig | None:
    """Return the rig that a calibration describes.

    Parameters
    ----------
    content : mapping
        Its keys in lower case; matrices as lists of numbers, as texts of numbers, or as mappings
        with ``data``.

    Returns
    -------
    StereoRig or None
        None if it is no stereo calibration of a known kind.

    Raises
    ------
    GeohueError, ValueError, TypeError
        If it is one, and its numbers do not fit together.

    Examples
    --------
    >>> rig = rig_from_content({"p2": "700 0 320 0 0 700 240 0 0 0 1 0",
    ...                         "p3": "700 0 320 -70 0 700 240 0 0 0 1 0"})
    >>> rig.left.fx, rig.baseline
    (700.0, 0.1)
    """
    rigs = (build(content) for build in _FORMATS)
    return next((rig for rig in rigs if rig is not None), None)


def _from_matrices(content: Content) -> StereoRig | None:
    """OpenCV: K1 D1 K2 D2 R T, under any of its names."""
    cameras = []
    for n, side in ((1, "left"), (2, "right")):
        names = (f"k{n}", f"m{n}", f"cameramatrix{n}", f"camera_matrix_{n}", f"camera_matrix{n}")
        K = first_value(
            content, (*names, f"k_{side}", f"camera_matrix_{side}", f"{side}_camera_matrix")
        )
        cameras.append(None if K is None else _matrix(K, 3, 3))
    K1, K2 = cameras
    if K1 is None or K2 is None:
        return None
    bends = [
        tuple(
            _flat(first_value(content, (f"d{n}", f"distcoeffs{n}", f"dist_coeffs{n}", f"d_{side}")))
        )
        for n, side in ((1, "left"), (2, "right"))
    ]
    size = _size(content)
    rotation, shift = (
        first_value(content, ("r", "rotation")),
        first_value(content, ("t", "translation")),
    )
    T, notes = (None, ()) if shift is None else _in_metres(np.array(_flat(shift)))
    R = None if rotation is None else _matrix(rotation, 3, 3)
    rig = StereoRig(
        camera_from_matrix(K1, *size),
        camera_from_matrix(K2, *size),
        None,
        _number(content, "doffs"),
        left_distortion=bends[0],
        right_distortion=bends[1],
        rotation=R,
        translation=T,
        warnings=notes,
    )
    # With T along x and R = 1 the images are rectified, and nothing but the baseline is needed.
    return replace(rig, rotation=None, translation=None) if rig.is_rectified else rig


def _from_q(content: Content) -> StereoRig | None:
    """OpenCV's Q, which takes (x, y, d, 1) to a point."""
    if "q" not in content:
        return None
    Q = _matrix(content["q"], 4, 4)
    if Q[3, 2] == 0:
        raise GeohueError("Q has no baseline (its entry in row 4, column 3 is 0)")
    baseline, notes = _length(1.0 / abs(Q[3, 2]))
    doffs = float(Q[3, 3] / Q[3, 2])
    left = Intrinsics(Q[2, 3], Q[2, 3], -Q[0, 3], -Q[1, 3], *_size(content))
    return StereoRig(left, replace(left, cx=left.cx + doffs), baseline, doffs, warnings=notes)


def _from_projections(content: Content) -> StereoRig | None:
    """KITTI (P2 and P3, colour, before P0 and P1, grey), or OpenCV's P1 and P2."""
    for left, right in (("p_rect_02", "p_rect_03"), ("p2", "p3"), ("p_rect_00", "p_rect_01"),
                        ("p0", "p1"), ("p1", "p2")):  # fmt: skip
        if left in content and right in content:
            P1, P2 = (_matrix(content[name], 3, 4) for name in (left, right))
            size = _flat(content.get(left.replace("p_rect", "s_rect")))
            known = (int(size[0]), int(size[1])) if len(size) == 2 else _size(content)
            return _projected(P1, P2, known)
    return None


def _projected(P1: Matrix, P2: Matrix, size: tuple[int | None, int | None]) -> StereoRig:
    """Return the rectified rig of two projection matrices, whose fourth column is -f b."""
    step = P1[0, 3] / P1[0, 0] - P2[0, 3] / P2[0, 0]
    if step == 0:
        raise GeohueError("both projection matrices have the same place: there is no baseline")
    if step < 0:
        raise GeohueError("the second camera stands to the left of the first; exchange them")
    baseline, notes = _length(step)
    left, right = (camera_from_matrix(P, *size) for P in (P1, P2))
    return StereoRig(left, right, baseline, warnings=notes)


def _from_kalibr(content: Content) -> StereoRig | None:
    """Kalibr's camchain: cam0 and cam1, each with intrinsics, and T_cn_cnm1 from the first on."""
    sides = content.get("cam0"), content.get("cam1")
    if not all(isinstance(side, Mapping) and "intrinsics" in side for side in sides):
        return None
    models = {str(side.get("distortion_model", "radtan")) for side in sides if side}
    if not models <= {"radtan", "none"}:
        raise GeohueError(
            f"has the distortion model {', '.join(sorted(models))}: pairs are rectified with "
            "radtan (Brown's) only; calibrate with pinhole-radtan, or give the rectified images"
        )
    first, second = (
        Intrinsics.from_numbers(_flat(side["intrinsics"]), *_size(side)) for side in sides if side
    )
    bends = [tuple(_flat(side.get("distortion_coeffs"))) for side in sides if side]
    pose = (sides[1] or {}).get("t_cn_cnm1")
    if pose is None:
        raise GeohueError("cam1 has no T_cn_cnm1 (the pose of cam0 in cam1)")
    T = _matrix(pose, 4, 4)
    rig = StereoRig(
        first,
        second,
        left_distortion=bends[0],
        right_distortion=bends[1],
        rotation=T[:3, :3],
        translation=T[:3, 3],
    )
    return replace(rig, rotation=None, translation=None) if rig.is_rectified else rig


def _from_middlebury(content: Content) -> StereoRig | None:
    """Middlebury 2014 and 2021: cam0, cam1, doffs, baseline in millimetres."""
    if "cam0" not in content or "cam1" not in content:
        return None
    size = _size(content)
    left, right = (
        camera_from_matrix(_matrix(content[name], 3, 3), *size) for name in ("cam0", "cam1")
    )
    length = _number(content, "baseline")
    baseline = None if length is None else length / 1000
    return StereoRig(left, right, baseline, _number(content, "doffs"))


def _from_dmin(content: Content) -> StereoRig | None:
    """Middlebury 2005 and 2006: numbers for the full size of 1110 rows, whatever the copy's."""
    dmin = _number(content, "dmin")
    if dmin is None:
        return None
    focal = _number(content, "focal", "f", "fx", "focal_length") or _FOCAL_2006
    length = _number(content, "baseline")
    baseline = _BASELINE_2006 if length is None else _length(length)[0]
    camera = Intrinsics(focal, focal, 0.0, 0.0, None, _ROWS_2006)
    note = (
        f"Middlebury 2005/2006: f {focal:g} px, baseline {1000 * baseline:g} mm and dmin {dmin:g} "
        "px are for 1110 rows and scaled to the images; the principal point is not in the file "
        "and taken as the centre"
    )
    return StereoRig(camera, camera, baseline, dmin, centre_known=False, warnings=(note,))


def _from_ros(content: Content) -> StereoRig | None:
    """ROS camera_info: both cameras with their P, or the right one's alone."""
    left, right = content.get("left"), content.get("right")
    if isinstance(left, dict) and isinstance(right, dict) and "projection_matrix" in right:
        return _from_ros_pair(left, right)
    if "projection_matrix" not in content:
        return None
    P = _matrix(content["projection_matrix"], 3, 4)
    size = _size(content)
    if P[0, 3] != 0:
        origin = P.copy()
        origin[:, 3] = 0
        return _projected(origin, P, size)
    camera = camera_from_matrix(P, *size)
    note = "this is the left camera alone: the baseline is unknown, depth is in baselines"
    return StereoRig(camera, camera, warnings=(note,))


def _from_ros_pair(left: Content, right: Content) -> StereoRig:
    """Undo the rectification that P and the rectification matrices are for: X_r = R X_l + T."""
    P1, P2 = (_matrix(side["projection_matrix"], 3, 4) for side in (left, right))
    rectified = _projected(P1, P2, _size(left))
    bends = [tuple(_flat(side.get("distortion_coefficients"))) for side in (left, right)]
    turns = [
        _matrix(side.get("rectification_matrix", np.eye(3).ravel().tolist()), 3, 3)
        for side in (left, right)
    ]
    straight = not any(any(bend) for bend in bends)
    if straight and all(np.allclose(turn, np.eye(3), atol=1e-6) for turn in turns):
        return rectified
    first, second = (
        camera_from_matrix(_matrix(side["camera_matrix"], 3, 3), *_size(side))
        for side in (left, right)
    )
    step = np.array([-(rectified.baseline or 1.0), 0.0, 0.0])
    return StereoRig(
        first,
        second,
        left_distortion=bends[0],
        right_distortion=bends[1],
        rotation=turns[1].T @ turns[0],
        translation=turns[1].T @ step,
        warnings=rectified.warnings,
    )


def _from_named(content: Content) -> StereoRig | None:
    """Plain values: f or fx, a baseline, and what else is there."""
    focal = _number(content, "f", "fx", "focal", "focal_length", "focal_length_px")
    baseline, notes = _baseline(content)
    if focal is None or baseline is None:
        return None
    cx, cy = _number(content, "cx0", "cx"), _number(content, "cy", "cy0")
    doffs, other = _number(content, "doffs"), _number(content, "cx1")
    if cx is not None and doffs is None and other is not None:
        doffs = other - cx
    known = cx is not None and cy is not None
    fy = _number(content, "fy") or focal
    left = Intrinsics(focal, fy, cx or 0.0, cy or 0.0, *_size(content))
    right = replace(left, cx=left.cx + (doffs or 0.0))
    return StereoRig(left, right, baseline, doffs, centre_known=known, warnings=notes)


_FORMATS = (
    *(_from_kalibr, _from_matrices, _from_middlebury, _from_dmin, _from_q, _from_projections),
    *(_from_ros, _from_named),
)


# --- values ------------------------------------------------------------------------------------


def _number(content: Content, *names: str) -> float | None:
    value = first_value(content, names)
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    return float(value)


def _flat(value: Any) -> list[float]:
    """Return the numbers of a list, a nested list, a text, or a matrix with ``data``."""
    if isinstance(value, Mapping):
        value = value.get("data")
    if isinstance(value, str):
        value = [float(word) for word in re.split(r"[\s,;]+", value.strip())]
    if value is None:
        return []
    return [float(x) for x in np.asarray(value, np.float64).ravel()]


def _matrix(value: Any, rows: int, columns: int) -> Matrix:
    numbers = _flat(value)
    if len(numbers) != rows * columns or not np.isfinite(numbers).all():
        raise GeohueError(f"a matrix has {len(numbers)} numbers instead of {rows * columns}")
    return np.array(numbers).reshape(rows, columns)


def _baseline(content: Content) -> tuple[float | None, tuple[str, ...]]:
    """Return the baseline in metres, under any of its names."""
    metres = _number(content, "baseline_meters", "baseline_m")
    if metres is not None:
        return metres, ()
    millimetres = _number(content, "baseline_mm")
    if millimetres is not None:
        return millimetres / 1000, ()
    length = _number(content, "baseline")
    return (None, ()) if length is None else _length(length)


def _size(content: Content) -> tuple[int | None, int | None]:
    width = _number(content, "width", "image_width")
    height = _number(content, "height", "image_height")
    if width is None or height is None:
        size = _flat(first_value(content, ("image_size", "size", "resolution")))
        if len(size) != 2:
            return None, None
        width, height = size
    return int(width), int(height)


def _length(value: float) -> tuple[float, tuple[str, ...]]:
    """Return metres, and a note where a large number was taken as millimetres."""
    if abs(value) < _MILLIMETRES:
        return float(value), ()
    note = f"a baseline of {value:g} is taken as millimetres; geohue works in metres"
    return float(value) / 1000, (note,)


def _in_metres(shift: Matrix) -> tuple[Matrix, tuple[str, ...]]:
    """Return T in metres, as `_length`."""
    length = float(np.linalg.norm(shift))
    metres, notes = _length(length)
    return (shift * (metres / length) if length else shift), notes
