"""Stereo calibrations as OpenCV YAML."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geohue.results.atomic import atomic_write
from geohue.stereo.rig import StereoRig, camera_matrix


def write_stereo_calibration(
    path: str | Path, rig: StereoRig, values: Mapping[str, float] | None = None
) -> None:
    """Write a rig as OpenCV YAML (K1 D1 K2 D2 R T), whole or not at all.

    Parameters
    ----------
    path : path-like
        The file, ending in ``.yml`` or ``.yaml``.
    rig : StereoRig
        The rig.
    values : dict of str to float, optional
        More numbers to note, such as the reprojection error.

    Raises
    ------
    GeohueError
        If the file cannot be written.

    Examples
    --------
    >>> file = getfixture("tmp_path") / "stereo.yml"
    >>> from geohue import Intrinsics
    >>> from geohue.read.cameras.stereo_calibration import read_stereo_calibration
    >>> camera = Intrinsics(500.0, 500.0, 320.0, 240.0, 640, 480)
    >>> write_stereo_calibration(file, StereoRig(camera, camera, 0.1))
    >>> read_stereo_calibration(file).baseline
    0.1
    """
    shift = rig.translation
    if shift is None:
        shift = np.array([-(rig.baseline or 1.0), 0.0, 0.0])
    turn = np.eye(3) if rig.rotation is None else rig.rotation
    lines = ["%YAML:1.0", "---"]
    if rig.left.width is not None and rig.left.height is not None:
        lines += [f"image_width: {rig.left.width}", f"image_height: {rig.left.height}"]
    for number, camera, distortion in (
        (1, rig.left, rig.left_distortion),
        (2, rig.right, rig.right_distortion),
    ):
        lines += _yaml_matrix(f"K{number}", camera_matrix(camera))
        lines += _yaml_matrix(f"D{number}", np.array([distortion or (0.0,) * 5]))
    lines += _yaml_matrix("R", turn) + _yaml_matrix("T", shift.reshape(3, 1))
    if rig.doffs is not None:
        lines.append(f"doffs: {rig.doffs!r}")
    lines += [f"{name}: {float(value)!r}" for name, value in (values or {}).items()]
    with atomic_write(path) as temporary:
        temporary.write_text("\n".join(lines) + "\n", encoding="ascii")


def _yaml_matrix(name: str, matrix: NDArray[np.float64]) -> list[str]:
    numbers = ", ".join(repr(float(value)) for value in matrix.ravel())
    rows, columns = matrix.shape
    return [
        f"{name}: !!opencv-matrix",
        f"   rows: {rows}",
        f"   cols: {columns}",
        "   dt: d",
        f"   data: [ {numbers} ]",
    ]
