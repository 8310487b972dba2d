"""A calibration as the plain JSON that `geohue.read.cameras.rig.read_rig` reads."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from geohue.results.atomic import atomic_write
from geohue.sensors.lens import Lens
from geohue.sensors.rig import Rig

_NAMES = ("color", "color2")


def write_rig(path: str | Path, rig: Rig) -> None:
    """Write a calibration with a depth camera and one or two colour cameras.

    Parameters
    ----------
    path : path-like
        The JSON file.
    rig : Rig
        Its disparity distortion by pixel (`DisparityModel.beta`) is left out.

    Raises
    ------
    GeohueError
        If the rig has no depth camera, or the file cannot be written.

    Examples
    --------
    >>> from geohue import Intrinsics
    >>> from geohue.read.cameras.rig import read_rig
    >>> from geohue.sensors import PosedCamera
    >>> lens = Lens(Intrinsics(500.0, 500.0, 320.0, 240.0, 640, 480), (0.1, 0.0, 0.0, 0.0, 0.0))
    >>> file = getfixture("tmp_path") / "calibration.json"
    >>> write_rig(file, Rig((PosedCamera(lens),), lens))
    >>> read_rig(file).depth == lens
    True
    """
    content: dict[str, Any] = {
        "note": "X_camera = R X_depth + T, metres; dist in OpenCV's order",
        "depth": _camera(rig.depth_lens),
    }
    if rig.disparity is not None:
        content["depth"]["dc"] = [rig.disparity.c0, rig.disparity.c1]
    if rig.depth_unit is not None:
        content["depth_unit_m"] = rig.depth_unit
    for name, camera in zip(_NAMES, rig.cameras, strict=False):
        content[name] = _camera(camera.lens) | {
            "R": camera.rotation.tolist(),
            "T": camera.translation.tolist(),
        }
    with atomic_write(path) as temporary:
        temporary.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")


def _camera(lens: Lens) -> dict[str, Any]:
    camera = lens.camera
    content: dict[str, Any] = {
        "K": [[camera.fx, 0.0, camera.cx], [0.0, camera.fy, camera.cy], [0.0, 0.0, 1.0]],
        "dkc" if lens.model == "inverse" else "dist": list(lens.distortion),
    }
    if camera.width is not None:
        content["size"] = [camera.width, camera.height]
    if lens.model == "fisheye":
        content["distortion_model"] = "fisheye"
    return content
