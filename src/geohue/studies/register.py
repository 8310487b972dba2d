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
from geohue.sensors.scaling import same_shape

_CHANCE = 1.2  # agreement of edges up to which nothing speaks for an alignment; 1 is chance
_ASIDE = 0.3  # relative distance of a camera's axis from the middle of its image
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
    notes += _size_doubts(color, rgb.shape, rig.cameras[camera].lens.camera)
    if rig.depth is not None:
        notes += _depth_doubts(depth, image.depth.shape, rgb.shape, rig.depth.camera)
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
    notes += _alignment_doubts(agreement)
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


def _size_doubts(path: str | Path, shape: tuple[int, ...], camera: Intrinsics) -> list[str]:
    """Compare the size of a picture with that of its calibration."""
    if camera.width is None or camera.height is None:
        return []
    size, known = f"{shape[1]} x {shape[0]}", f"{camera.width} x {camera.height}"
    if not same_shape(shape, (camera.height, camera.width)):
        raise broken(
            path,
            f"is {size}, the calibration is for {known}: another shape; give the picture that "
            "belongs to the calibration",
        )
    return [] if size == known else [f"{path}: calibration for {known} scaled to {size}"]


def _depth_doubts(
    path: str | Path, shape: tuple[int, ...], color: tuple[int, ...], camera: Intrinsics
) -> list[str]:
    """Look whether a depth map is one of the rig's depth camera, by its size."""
    if camera.width is None or camera.height is None:
        aside = max(abs(2 * camera.cx / shape[1] - 1), abs(2 * camera.cy / shape[0] - 1))
        if aside <= _ASIDE:
            return []
        axis = f"({camera.cx:.0f}, {camera.cy:.0f})"
        return [
            f"{path}: the depth camera's axis at {axis} is far from the middle of "
            f"{shape[1]} x {shape[0]}: is the calibration for another size?"
        ]
    if shape[:2] == color[:2] != (camera.height, camera.width):
        raise broken(
            path,
            f"has the size of the picture, {shape[1]} x {shape[0]}, and not that of the depth "
            f"camera, {camera.width} x {camera.height}: is it registered already? Then give it to "
            "'geohue segment' as it is",
        )
    return _size_doubts(path, shape, camera)


def _alignment_doubts(agreement: float) -> list[str]:
    """Return a warning where edges of depth and colour meet no more often than by chance."""
    if math.isnan(agreement):
        return ["the depth has no edge of an object: how well it lies cannot be measured"]
    if agreement > _CHANCE:
        return []
    return [
        f"edges of depth and colour agree {agreement:.2f} times as well as by chance, which is no "
        "alignment: check R and T (depth to colour, T in metres), the camera and the depth scale"
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
