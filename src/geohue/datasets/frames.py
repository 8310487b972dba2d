"""What every data set becomes: frames with colour, depth or range points, camera and pose."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics
from geohue.errors import GeohueError
from geohue.read.files import broken
from geohue.read.images.depth_units import DepthUnit
from geohue.scene import Scene
from geohue.sensors.rig import Rig
from geohue.stereo.rig import StereoRig

_TWICE = 2.5  # times the width of a depth map

Color = Path | Callable[[], NDArray[np.uint8]]
Depth = Path | Callable[[], NDArray[np.float32]]


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """One moment of a recording; its files are read when asked for.

    Attributes
    ----------
    name : str
        Unique in its data set.
    color : Path or callable
        The picture, or what returns it.
    depth : Path, callable or None
        The depth map or, for a scanner, its points; or what returns it (metres).
    intrinsics : Intrinsics or None
        Of the colour camera; of the depth camera where `rig` is set.
    depth_scale : float, str, DepthUnit or None
        Unit of the depth file, as `geohue.read.read_depth` takes it.
    T_world_camera : (4, 4) float64 or None
        Pose of the camera, camera to world.
    rig : Rig or None
        Set where depth and colour are not registered.
    second : Path, callable or None
        The picture of the rig's second camera.
    labels : Path or None
        Reference labels of the frame.
    confidence : Path, callable or None
        How sure the sensor is of each pixel of the depth map (`Scene.from_rgbd`).
    right : Path, callable or None
        The right picture of a stereo pair, `color` being the left one; there is no `depth` then.
    stereo : StereoRig or None
        The calibration of the pair, where it is known.
    """

    name: str
    color: Color
    depth: Depth | None
    intrinsics: Intrinsics | None = None
    depth_scale: float | str | DepthUnit | None = None
    T_world_camera: NDArray[np.float64] | None = None
    rig: Rig | None = None
    second: Color | None = None
    labels: Path | None = None
    confidence: Path | Callable[[], NDArray[Any]] | None = None
    right: Color | None = None
    stereo: StereoRig | None = None

    def read_color(self) -> NDArray[np.uint8]:
        """Return the picture, (H, W, 3) uint8."""
        return _picture(self.color)

    def read_depth(self) -> NDArray[np.float32]:
        """Return the depth map (H, W) in metres, NaN where missing, or (N, 3) range points."""
        if self.depth is None:
            raise GeohueError(f"{self.name}: the frame has no depth")
        if not isinstance(self.depth, Path):
            return self.depth()
        if self.rig is not None and self.rig.depth is None:
            from geohue.read.clouds.cloud import read_cloud

            return read_cloud(self.depth).points
        from geohue.read.images.pictures import read_depth

        return read_depth(self.depth, self.depth_scale).depth

    def scene(self, **trust: Any) -> Scene:
        """Read the frame as a scene; unregistered depth is registered, range points coloured.

        Parameters
        ----------
        **trust
            Which depth is used, as the arguments of `Scene.from_rgbd` by name (least, min_depth,
            ...), for a frame with registered depth.
        """
        given = {name: value for name, value in trust.items() if value is not None}
        if given and (self.depth is None or self.rig is not None):
            what = "a frame without registered depth"
            raise GeohueError(f"{self.name}: is {what}: leave out {', '.join(given)}")
        if self.right is not None:
            return Scene.from_stereo(self.read_color(), _picture(self.right), self.stereo)
        if self.depth is None:
            return Scene.from_image(self.read_color())
        if self.rig is not None and (self.rig.depth is None or self.second is not None):
            pictures = [_picture(c) for c in (self.color, self.second) if c is not None]
            return Scene.from_range_and_cameras(self.read_depth(), pictures, self.rig)
        if self.rig is not None:
            from geohue.scene.registered import registered_scene

            return registered_scene(self.read_color(), self.read_depth(), self.rig)
        return self._registered(given)

    def _registered(self, trust: dict[str, Any]) -> Scene:
        """Return the scene of a picture and its depth map, the picture at most twice as large."""
        colors, depth = self.read_color(), self.read_depth()
        sure = self.confidence() if callable(self.confidence) else self.confidence
        fitted = _fitted(colors, depth)
        wishes = {"confidence": sure} | trust
        scene = Scene.from_rgbd(fitted, depth, self.intrinsics, **wishes)
        if colors.shape == fitted.shape:
            return scene
        return replace(
            scene, warnings=(*scene.warnings, "the picture was resized to its depth map's size")
        )


class Dataset(Sequence[Frame]):
    """The frames of a recording or data set.

    Parameters
    ----------
    layout : str
        Name of the layout it was read by.
    path : Path
        Where it lies.
    frames : sequence of Frame
    notes : tuple of str
        Guesses that the user should know of.
    registered : bool or None
        Whether depth lies in the view of the pictures; None where the layout does not say.
    """

    def __init__(
        self,
        layout: str,
        path: Path,
        frames: Sequence[Frame],
        notes: tuple[str, ...] = (),
        registered: bool | None = True,
    ) -> None:
        if not frames:
            raise broken(path, f"has no frames in the layout {layout!r}; check the folder")
        self.layout, self.path, self.frames, self.notes = layout, path, frames, notes
        self.registered = registered

    @overload
    def __getitem__(self, index: int) -> Frame: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Frame]: ...
    def __getitem__(self, index: int | slice) -> Frame | Sequence[Frame]:
        return self.frames[index]

    def __len__(self) -> int:
        return len(self.frames)

    def __iter__(self) -> Iterator[Frame]:
        return iter(self.frames)

    def describe(self) -> dict[str, Any]:
        """Return what there is to know without reading the pictures, ready for JSON."""
        first = self.frames[0]
        camera, rig = first.intrinsics, first.rig
        if camera is None and rig is not None:
            camera = rig.cameras[0].lens.camera
        return {
            "kind": "data set",
            "layout": self.layout,
            "n_frames": len(self),
            "first": first.name,
            "last": self.frames[-1].name,
            "color": _where(first.color, self.path),
            "depth": _where(first.depth, self.path),
            "depth_scale": _unit_text(first.depth_scale),
            "fx_fy_cx_cy": None if camera is None else [camera.fx, camera.fy, camera.cx, camera.cy],
            "registered": False if rig is not None else self.registered,
            "second_camera": first.second is not None,
            "poses": sum(frame.T_world_camera is not None for frame in self.frames),
            "labels": sum(frame.labels is not None for frame in self.frames),
        }


def inside(folder: Path, name: str) -> Path:
    """Return a file that a list in a data set names; GeohueError if it leads out of the folder.

    Examples
    --------
    >>> inside(Path("set"), "rgb/1.png").as_posix()
    'set/rgb/1.png'
    >>> inside(Path("set"), "../secret")
    Traceback (most recent call last):
    geohue.errors.GeohueError: set: names the file '../secret' outside of the folder; correct it
    """
    parts = Path(name).parts
    if Path(name).is_absolute() or ".." in parts or "\0" in name or not parts:
        raise broken(folder, f"names the file {name[:60]!r} outside of the folder; correct it")
    return folder / name


def read_pose(path: Path) -> NDArray[np.float64] | None:
    """Read a 4 x 4 matrix from a text file; None if it is absent, not finite or no such matrix."""
    from geohue.read.files import read_bytes

    if not path.is_file():
        return None
    words = read_bytes(path, 1 << 16).decode("latin-1").replace(",", " ").split()
    try:
        numbers = np.array([float(word) for word in words[:16]])
    except ValueError:
        return None
    usable = len(numbers) == 16 and np.isfinite(numbers).all()
    return numbers.reshape(4, 4) if usable else None


def pose_from_quaternion(values: Sequence[float]) -> NDArray[np.float64]:
    """Return the 4 x 4 pose of tx, ty, tz, qx, qy, qz, qw."""
    from geohue.read.cameras.rig import rotation_from_quaternion

    pose = np.eye(4)
    pose[:3, :3] = rotation_from_quaternion(values[3:7])
    pose[:3, 3] = values[:3]
    return pose


def read_rows(path: Path, width: int) -> list[list[str]]:
    """Read the rows of a text file that have at least `width` words, comments left out."""
    from geohue.read.files import read_bytes

    text = read_bytes(path, 1 << 28).decode("utf-8", "replace")
    rows = (line.split() for line in text.splitlines() if not line.lstrip().startswith("#"))
    return [row for row in rows if len(row) >= width]


def numbers(words: Sequence[str], path: Path) -> list[float]:
    """Turn words into numbers, or name the file that has something else."""
    try:
        return [float(word) for word in words]
    except ValueError as error:
        raise broken(path, f"has a row that is no numbers: {' '.join(words)[:60]!r}") from error


def picture_in(folder: Path, stem: str) -> Path | None:
    """Return the picture of that name with whichever ending it has."""
    endings = (".png", ".jpg", ".jpeg", ".ppm", ".JPG", ".PNG", ".bmp", ".tif", ".tiff")
    return next((f for e in endings if (f := folder / f"{stem}{e}").is_file()), None)


def sorted_files(folder: Path, *patterns: str) -> list[Path]:
    """Return the files of a folder that match, numbers in their names in order of size."""
    import re

    found = [file for pattern in patterns for file in folder.glob(pattern) if file.is_file()]

    def key(file: Path) -> list[tuple[int, int | str]]:
        parts = re.split(r"(\d+)", file.name)
        return [(0, int(p)) if p.isdigit() and len(p) < 40 else (1, p) for p in parts]

    return sorted(set(found), key=key)


def _picture(color: Color) -> NDArray[np.uint8]:
    if not isinstance(color, Path):
        return color()
    from geohue.read.images.pictures import read_color

    return read_color(color)


def _fitted(colors: NDArray[np.uint8], depth: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Resize a picture of about twice the size of its depth map, both being of one view.

    A larger one keeps its detail, and the depth map is scaled instead (`Scene.from_rgbd`).
    """
    height, width = depth.shape
    if colors.shape[:2] == (height, width) or colors.shape[1] > _TWICE * width:
        return colors
    if abs(colors.shape[1] * height / (colors.shape[0] * width) - 1) > 0.03:
        raise GeohueError(
            f"picture {colors.shape[1]} x {colors.shape[0]} and depth {width} x {height} differ in "
            "shape; register the depth to the picture first"
        )
    import cv2

    return np.asarray(cv2.resize(colors, (width, height), interpolation=cv2.INTER_AREA), np.uint8)


def _where(source: object, folder: Path) -> str | None:
    if source is None:
        return None
    if not isinstance(source, Path):
        return "computed"
    return str(source.relative_to(folder)) if source.is_relative_to(folder) else str(source)


def _unit_text(unit: float | str | DepthUnit | None) -> float | str | None:
    return unit.scale if isinstance(unit, DepthUnit) else unit
