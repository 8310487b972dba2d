"""The layouts by name, and which of them a folder or file has."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

from geohue.camera import Intrinsics
from geohue.datasets.frames import Dataset
from geohue.errors import GeohueError
from geohue.read.files import broken, reason
from geohue.stereo.rig import StereoRig

LAYOUTS = (
    "tum",
    "bop",
    "scannet",
    "sevenscenes",
    "sunrgbd",
    "nyu_raw",
    "nyu_labelled",
    "kitti",
    "middlebury",
    "ros",
    "stray",
    "record3d",
    "arkit",
    "rig",
    "open3d",
    "pairs",
    "stereo",
)
"""Names of the layouts, the most particular first: each is a module with `matches` and `load`."""

_ALIASES = {
    "redwood": "open3d",
    "7scenes": "sevenscenes",
    "7-scenes": "sevenscenes",
    "sun": "sunrgbd",
    "nyu": "nyu_labelled",
    "nyu-raw": "nyu_raw",
    "nyu-labelled": "nyu_labelled",
    "mcap": "ros",
    "bag": "ros",
    "realsense": "ros",
    "stray-scanner": "stray",
    "polycam": "arkit",
    "arkitscenes": "arkit",
}


def open_dataset(
    path: str | Path,
    layout: str | None = None,
    *,
    intrinsics: Intrinsics | None = None,
    depth_scale: float | str | None = None,
    rig: StereoRig | None = None,
) -> Dataset:
    """Open a data set or recording.

    Parameters
    ----------
    path : path-like
        Its folder, or its file (.bag, .mcap, .db3, .mat).
    layout : str, optional
        One of `LAYOUTS`; by default guessed from what lies in the folder.

    intrinsics : Intrinsics, optional
        The camera, instead of what the data set says or its layout assumes.
    depth_scale : float or str, optional
        Metres per unit or a name (`geohue.read.read_depth`), likewise.
    rig : StereoRig, optional
        The calibration of stereo pairs, likewise.

    Returns
    -------
    Dataset
        A sequence of `Frame`; nothing but lists and cameras has been read.

    Raises
    ------
    GeohueError
        If the folder is missing, has none of the layouts, or its lists are damaged.

    Examples
    --------
    >>> open_dataset("not there")
    Traceback (most recent call last):
    geohue.errors.GeohueError: not there: no such file or folder; check the name
    """
    folder = Path(path)
    if not _exists(folder):
        raise broken(path, "no such file or folder; check the name")
    name = guess_layout(folder) if layout is None else _ALIASES.get(layout.lower(), layout.lower())
    if name is None:
        raise broken(
            path, f"has none of the known layouts ({', '.join(LAYOUTS)}); name it, or give files"
        )
    if name not in LAYOUTS:
        raise GeohueError(f"layout {layout!r}: choose one of {', '.join(LAYOUTS)}")
    try:
        data: Dataset = _module(name).load(folder)
    except OSError as error:
        raise broken(path, f"cannot be read ({reason(error)}); check its permissions") from error
    except GeohueError as error:
        if str(path) in str(error):
            raise
        raise broken(path, str(error)) from error
    if rig is not None and data[0].right is None:
        raise broken(path, f"has no stereo pairs (layout {data.layout}), which rig=... is for")
    given = {"intrinsics": intrinsics, "depth_scale": depth_scale, "stereo": rig}
    changes: dict[str, Any] = {key: value for key, value in given.items() if value is not None}
    if changes:
        frames = [replace(frame, **changes) for frame in data]
        notes = data.notes if rig is None else ()
        data = Dataset(data.layout, data.path, frames, notes, data.registered)
    return data


def guess_layout(folder: Path) -> str | None:
    """Return the name of the first layout that a folder or file has, None if it has none."""
    if folder.suffix.lower() == ".mkv":
        raise broken(
            folder,
            "is an Azure Kinect recording, which only the device's own library reads; export its "
            "frames first (Open3D's azure_kinect_mkv_reader)",
        )
    return next((name for name in LAYOUTS if _matches(name, folder)), None)


def _matches(name: str, folder: Path) -> bool:
    try:
        matches: Callable[[Path], bool] = _module(name).matches
        return matches(folder)
    except OSError:
        return False


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):
        return False


def _module(name: str) -> Any:
    return import_module(f"geohue.datasets.{name}")
