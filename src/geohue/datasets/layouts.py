"""The layouts by name, and which of them a folder or file has."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any

from geohue.camera import Intrinsics
from geohue.datasets.frames import Dataset
from geohue.errors import GeohueError
from geohue.plugins import Registry
from geohue.read.files import broken, reason


@dataclass(frozen=True, slots=True)
class Layout:
    """How frames lie in the folders of a data set.

    Attributes
    ----------
    matches : callable
        From a folder or file to whether it has the layout.
    load : callable
        From it to a `Dataset`: a list of frames, of which no picture has been read.
    """

    matches: Callable[[Path], bool]
    load: Callable[[Path], Dataset]


_NAMES = (
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
    "rig",
    "open3d",
    "pairs",
)


def _own(name: str) -> Layout:
    """Return one of ours, whose module is imported when it is used."""
    return Layout(lambda path: _module(name).matches(path), lambda path: _module(name).load(path))


LAYOUTS: Registry[Layout] = Registry(
    "layouts",
    {name: _own(name) for name in _NAMES},
    lambda value: isinstance(value, Layout),
    "a Layout",
)
"""The layouts by name, the most particular of ours first, those of plugins after them."""


def register_layout(name: str, layout: Layout) -> Layout:
    """Let data sets of another layout be read wherever a data set can be given.

    Parameters
    ----------
    name : str
        A new name, in lower case.
    layout : Layout
        Where no layout is named it is asked before those of geohue.

    Returns
    -------
    Layout
        The layout itself.

    Raises
    ------
    GeohueError
        For a name that is taken.

    Examples
    --------
    >>> from geohue.datasets import Frame
    >>> def load(folder):
    ...     files = sorted(folder.glob("*.color"))
    ...     return Dataset("mine", folder, [Frame(file.stem, file, None) for file in files])
    >>> layout = register_layout("mine", Layout(lambda path: path.suffix == ".mine", load))
    >>> folder = getfixture("tmp_path") / "set.mine"
    >>> folder.mkdir(); (folder / "a.color").touch()
    >>> guess_layout(folder), len(open_dataset(folder))
    ('mine', 1)
    >>> LAYOUTS.remove("mine")
    """
    LAYOUTS.add(name, layout)
    return layout


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
}


def open_dataset(
    path: str | Path,
    layout: str | None = None,
    *,
    intrinsics: Intrinsics | None = None,
    depth_scale: float | str | None = None,
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
        data = LAYOUTS[name].load(folder)
    except OSError as error:
        raise broken(path, f"cannot be read ({reason(error)}); check its permissions") from error
    except GeohueError as error:
        if str(path) in str(error):
            raise
        raise broken(path, str(error)) from error
    given = {"intrinsics": intrinsics, "depth_scale": depth_scale}
    changes: dict[str, Any] = {key: value for key, value in given.items() if value is not None}
    if changes:
        frames = [replace(frame, **changes) for frame in data]
        data = Dataset(data.layout, data.path, frames, data.notes)
    return data


def guess_layout(folder: Path) -> str | None:
    """Return the name of the first layout that a folder or file has, None if it has none."""
    if folder.suffix.lower() == ".mkv":
        raise broken(
            folder,
            "is an Azure Kinect recording, which only the device's own library reads; export its "
            "frames first (Open3D's azure_kinect_mkv_reader)",
        )
    order = (*LAYOUTS.foreign(), *LAYOUTS.own)
    return next((name for name in order if _matches(name, folder)), None)


def _matches(name: str, folder: Path) -> bool:
    try:
        return LAYOUTS[name].matches(folder)
    except OSError:
        return False


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):
        return False


def _module(name: str) -> Any:
    return import_module(f"geohue.datasets.{name}")
