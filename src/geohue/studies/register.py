"""Registration from files to files: what ``geohue register`` does."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics
from geohue.read.cameras.rig import read_rig
from geohue.read.files import broken
from geohue.read.images.pictures import read_color
from geohue.read.images.raw_depth import read_range
from geohue.results.atomic import atomic_write
from geohue.results.png import write_png
from geohue.results.rig import write_rig
from geohue.sensors.alignment import edge_agreement
from geohue.sensors.lens import Lens
from geohue.sensors.refine import refine_translation
from geohue.sensors.registration import register_depth, undistorted
from geohue.sensors.rig import Rig

_FARTHEST = np.iinfo(np.uint16).max / 1000  # metres that 16-bit millimetres can tell


@dataclass(frozen=True, slots=True)
class Registered:
    """What came of a registration.

    Attributes
    ----------
    files : tuple of Path
        What was written.
    covered : float
        Share of the colour picture with depth.
    edge_agreement : float
        See `geohue.sensors.edge_agreement`; NaN where there is no edge.
    warnings : tuple of str
        What the user should know.
    """

    files: tuple[Path, ...]
    covered: float
    edge_agreement: float
    warnings: tuple[str, ...]

    def summary(self) -> dict[str, Any]:
        """Return everything, ready for JSON."""
        agreement = self.edge_agreement
        return {
            "files": [file.name for file in self.files],
            "covered": self.covered,
            "edge_agreement": agreement if math.isfinite(agreement) else None,
            "warnings": list(self.warnings),
        }


def register_files(
    color: str | Path,
    depth: str | Path,
    calib: Sequence[str | Path],
    folder: str | Path,
    depth_scale: float | str | None = None,
    camera: int = 0,
    undistort: bool = False,
    refine: bool = False,
) -> Registered:
    """Register a depth picture to a colour picture and write the result.

    Parameters
    ----------
    color, depth : path-like
        The pictures.
    calib : sequence of path-like
        The calibration (`geohue.read.cameras.rig.read_rig`).
    folder : path-like
        Receives ``depth_registered.png``, ``intrinsics.json`` and, with `undistort`,
        ``color_undistorted.png`` (the depth is then registered to that).
    depth_scale : float or str, optional
        Metres per unit, or a name; by default what the calibration says, else as `read_depth`.
        With "kinect" the calibration's own disparity model is used where it has one.
    camera : int
        Which of the calibration's colour cameras took the picture.
    undistort : bool
        Whether the lens distortion is taken out of the picture first.
    refine : bool
        Whether T is moved by up to 4 cm sideways and up or down until the edges agree
        (`geohue.sensors.refine_translation`); the new calibration is written as
        ``calibration_refined.json``.

    Returns
    -------
    Registered

    Raises
    ------
    GeohueError
        If a file cannot be read or written, or they do not fit together.
    """
    rig = read_rig(*calib)
    rgb, image = read_color(color), read_range(depth, rig, depth_scale)
    height, width = rgb.shape[:2]
    notes = [*rig.warnings, *image.warnings]
    if not 0 <= camera < len(rig.cameras):
        raise broken(calib[0], f"has {len(rig.cameras)} colour camera(s): no number {camera + 1}")
    notes += _size_doubts(color, rgb, rig.cameras[camera].lens.camera)
    target = Path(folder)
    files: list[Path] = []
    if undistort:
        lens = rig.cameras[camera].lens
        rgb = undistorted(rgb, lens)
        rig = _straightened(rig, camera)
        files.append(target / "color_undistorted.png")
        write_png(files[-1], rgb)
    if refine:
        rig, _, _ = refine_translation([(rgb, image.depth)], rig, camera=camera)
        notes += [note for note in rig.warnings if note not in notes]
        files.append(target / "calibration_refined.json")
        write_rig(files[-1], rig)
    metres = register_depth(image.depth, rig, (width, height), camera)
    if not np.isfinite(metres).any():
        raise broken(depth, f"has no point in the view of {color}; check R, T and the depth scale")
    agreement = edge_agreement(rgb, metres)
    files.append(target / "depth_registered.png")
    write_png(files[-1], to_millimetres(metres))
    files.append(target / "intrinsics.json")
    _write_intrinsics(files[-1], rig.cameras[camera].lens.scaled_to(width, height))
    if (metres > _FARTHEST).any():
        notes.append(f"depths beyond {_FARTHEST:.1f} m do not fit 16-bit millimetres: left out")
    return Registered(tuple(files), float(np.isfinite(metres).mean()), agreement, tuple(notes))


def to_millimetres(depth: NDArray[np.floating[Any]]) -> NDArray[np.uint16]:
    """Round metres to 16-bit millimetres; 0 for what is missing or does not fit.

    Examples
    --------
    >>> to_millimetres(np.array([[1.5, np.nan, 70.0]]))
    array([[1500,    0,    0]], dtype=uint16)
    """
    with np.errstate(invalid="ignore"):
        fits = (depth > 0) & (depth <= _FARTHEST)
    return np.rint(np.where(fits, depth, 0) * 1000.0).astype(np.uint16)


def _size_doubts(path: str | Path, rgb: NDArray[np.uint8], camera: Intrinsics) -> list[str]:
    height, width = rgb.shape[:2]
    if camera.width is None or camera.height is None:
        return []
    if abs(width * camera.height / (height * camera.width) - 1) > 0.02:
        raise broken(
            path,
            f"is {width} x {height}, the calibration is for {camera.width} x {camera.height}: "
            "another shape; give the picture that belongs to the calibration",
        )
    if (width, height) == (camera.width, camera.height):
        return []
    return [
        f"{path}: calibration for {camera.width} x {camera.height} scaled to {width} x {height}"
    ]


def _straightened(rig: Rig, camera: int) -> Rig:
    """Return the rig with one camera's distortion gone."""
    cameras = list(rig.cameras)
    cameras[camera] = replace(cameras[camera], lens=Lens(cameras[camera].lens.camera))
    return replace(rig, cameras=tuple(cameras))


def _write_intrinsics(path: Path, lens: Lens) -> None:
    camera = lens.camera
    content: dict[str, Any] = {
        "fx": camera.fx,
        "fy": camera.fy,
        "cx": camera.cx,
        "cy": camera.cy,
        "width": camera.width,
        "height": camera.height,
    }
    if not lens.is_straight:
        content |= {"dist": list(lens.distortion), "distortion_model": lens.model}
    with atomic_write(path) as temporary:
        temporary.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
