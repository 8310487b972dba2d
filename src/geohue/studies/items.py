"""The scenes of a folder: frames of a data set, clouds, or pictures."""

from __future__ import annotations

import time
import unicodedata
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple, TypeVar

from geohue.camera import Intrinsics
from geohue.datasets.frames import Dataset, Frame, picture_in, sorted_files
from geohue.datasets.layouts import guess_layout, open_dataset
from geohue.errors import GeohueError
from geohue.read.clouds.cloud import CLOUD_READERS
from geohue.read.files import broken
from geohue.read.images.depth_units import depth_unit
from geohue.read.scenes.scenes import read_scene
from geohue.scene import Scene

Value = TypeVar("Value")

_PICTURES = ("*.png", "*.jpg", "*.jpeg", "*.JPG", "*.PNG", "*.ppm", "*.bmp", "*.tif", "*.tiff")
_COLORS = ("rgb", "color", "colour", "image")
_OTHERS = (".txt", ".csv", ".out", ".bin")  # clouds at times, but more often something else


@dataclass(frozen=True, slots=True)
class Opening:
    """How a data set is opened.

    `listed` is the moment of its listing (ns): what a worker has opened for an earlier one, when
    there were other frames perhaps, does not count for this one.
    """

    folder: Path
    layout: str | None = None
    intrinsics: Intrinsics | None = None
    depth_scale: float | str | None = None
    listed: int = 0

    def __call__(self) -> Dataset:
        """Open it."""
        return open_dataset(
            self.folder, self.layout, intrinsics=self.intrinsics, depth_scale=self.depth_scale
        )


class Files(NamedTuple):
    """The files of an RGB-D frame (`read_scene`)."""

    color: Path
    depth: Path
    intrinsics: Path | None = None


@dataclass(frozen=True, slots=True)
class Item:
    """One scene of a study, small enough to be sent to another machine.

    Attributes
    ----------
    name : str
        Unique in the study; where its results go.
    source : Path, Files, Frame or (Opening, int, str)
        A cloud or picture; the files of a frame; a frame of a data set whose parts are files; or a
        data set, the frame's place in it and what it is known by there.
    labels : Path or None
        Its true labels, 0 for none.
    """

    name: str
    source: Path | Files | Frame | tuple[Opening, int, str]
    labels: Path | None = None

    def read(self) -> Scene:
        """Read the scene.

        Raises
        ------
        GeohueError
            If a file cannot be read, or the data set has other frames than when it was listed.
        """
        if isinstance(self.source, Path):
            return read_scene(self.source)
        if isinstance(self.source, Files):
            return read_scene(*self.source)
        if isinstance(self.source, Frame):
            return self.source.scene()
        opening, i, mark = self.source
        data = _opened(opening)
        if i >= len(data) or _mark(data[i]) != mark:
            raise broken(opening.folder, "has changed since it was listed; go on with --resume")
        return data[i].scene()

    def ages(self) -> dict[Path, int]:
        """Return when each file was written last (ns; 0 for one that has gone)."""
        if isinstance(self.source, Path):
            parts: Sequence[object] = [self.source]
        elif isinstance(self.source, Frame):
            parts = [self.source.color, self.source.depth, self.source.second]
        else:
            parts = self.source
        files = [part for part in (*parts, self.labels) if isinstance(part, Path)]
        return {file: file.stat().st_mtime_ns if file.exists() else 0 for file in files}


@lru_cache(maxsize=2)
def _opened(opening: Opening) -> Dataset:
    return opening()


def _mark(frame: Frame) -> str:
    """Return what tells a frame from the others of its data set."""
    return str(frame.color) if isinstance(frame.color, Path) else frame.name


def find_items(
    folder: str | Path,
    layout: str | None = None,
    *,
    intrinsics: Intrinsics | None = None,
    depth_scale: float | str | None = None,
    pictures: bool = False,
    limit: int | None = None,
) -> tuple[list[Item], tuple[str, ...]]:
    """List the scenes of a folder.

    Parameters
    ----------
    folder : str or Path
        A data set or recording in a known layout (`open_dataset`) or, if it has none, a folder of
        clouds, a scene a file.
    layout : str, optional
        The layout, if it is not to be guessed.
    intrinsics : Intrinsics, optional
        The camera, instead of what the data set says.
    depth_scale : float or str, optional
        Metres per unit of the depth maps, likewise.
    pictures : bool
        Whether a folder that has neither is one of pictures, without geometry.
    limit : int, optional
        At most so many scenes, spread evenly over all.

    Returns
    -------
    items : list of Item
        In the order of the data set or, for files, of their names.
    notes : tuple of str
        Guesses that the user should know of.

    Raises
    ------
    GeohueError
        If there is nothing to segment, two scenes have one name or names that differ in case only,
        a name is no line of text, or a limit is below 1.
    """
    root = Path(folder).absolute()
    check_limit(limit)
    if depth_scale is not None:
        depth_unit(depth_scale)  # seen here, a mistake is not one a frame
    if not root.exists():
        raise broken(folder, "no such folder; check the name")
    if layout is not None or guess_layout(root):
        opening = Opening(root, layout, intrinsics, depth_scale, time.time_ns())
        data = opening()
        frames = [*data, *_without_depth(data)]
        items, notes = _frame_items(frames, opening), data.notes
    else:
        items, notes = _file_items(root, pictures), ()
    _check_names(root, items)
    return spread_evenly(items, limit), notes


def check_limit(limit: int | None) -> None:
    """Raise `GeohueError` unless so many scenes can be asked for."""
    if limit is not None and limit < 1:
        raise GeohueError(f"limit is {limit}: expected at least 1")


def spread_evenly(values: list[Value], limit: int | None) -> list[Value]:
    """Return at most so many values, spread evenly over all.

    Examples
    --------
    >>> spread_evenly([0, 1, 2, 3, 4], 2), spread_evenly([0, 1], None)
    ([0, 2], [0, 1])
    """
    if limit is None or limit >= len(values):
        return values
    return [values[i * len(values) // limit] for i in range(limit)]


def _frame_items(frames: Sequence[Frame], opening: Opening) -> list[Item]:
    """Name each frame; names that come twice become the paths of their pictures."""
    count = Counter(frame.name for frame in frames)
    items = []
    for i, frame in enumerate(frames):
        name = frame.name
        if count[name] > 1 and isinstance(frame.color, Path):
            name = frame.color.relative_to(opening.folder).with_suffix("").as_posix()
        parts = (frame.color, frame.depth, frame.second)
        whole = all(part is None or isinstance(part, Path) for part in parts)
        items.append(Item(name, frame if whole else (opening, i, _mark(frame)), frame.labels))
    return items


def _without_depth(data: Dataset) -> list[Frame]:
    """Return the pictures of a plain folder without a depth map, so that they can be reported."""
    if data.layout != "pairs":
        return []
    taken = {frame.color for frame in data}
    folders = dict.fromkeys(color.parent for color in taken if isinstance(color, Path))
    camera = data[0].intrinsics
    lone = []
    for folder in folders:
        if folder.name.lower() in _COLORS:
            found = sorted_files(folder, *_PICTURES)
            lone += [Frame(f.stem, f, None, camera) for f in found if f not in taken]
    for place in sorted({folder.parent for folder in folders if folder != data.path}):
        for part in sorted(p for p in place.iterdir() if p.is_dir() and p not in folders):
            color = next((f for stem in _COLORS if (f := picture_in(part, stem))), None)
            if color is not None:
                lone.append(Frame(part.name, color, None, camera))
    return lone


def _file_items(root: Path, pictures: bool) -> list[Item]:
    """List the clouds of a folder or else, if wanted, its pictures."""
    files = sorted_files(root, *(f"*{end}" for end in CLOUD_READERS if end not in _OTHERS))
    if pictures:
        files = files or sorted_files(root, *_PICTURES)
    if not files:
        raise broken(
            root,
            "has nothing to segment: neither the layout of a data set nor clouds (for pictures "
            "alone, give --cues color)",
        )
    count = Counter(file.stem for file in files)
    return [Item(f.stem if count[f.stem] == 1 else f.name, f) for f in files]


def _check_names(root: Path, items: Sequence[Item]) -> None:
    count = Counter(item.name for item in items)
    twice = [name for name in count if count[name] > 1]
    if twice:
        raise broken(root, f"has several frames with the name {twice[0]}; rename or split them")
    odd = [name for name in count if not _is_line(name)]
    if odd:
        raise broken(
            root, f"has a frame with the name {odd[0]!r}, which is no line of text; rename it"
        )
    first: dict[str, str] = {}
    for name in count:
        other = first.setdefault(_folded(name), name)
        if other != name:
            raise broken(
                root,
                f"has the frames {other} and {name}, whose results would share one folder on a "
                "system that ignores case (macOS, Windows); rename one of them",
            )


def _folded(name: str) -> str:
    """Return a name as a file system sees it that ignores case and composes accents."""
    return unicodedata.normalize("NFC", name).casefold()


def _is_line(name: str) -> bool:
    """Whether a name can stand in a table."""
    try:
        name.encode()
    except UnicodeEncodeError:
        return False
    return "\n" not in name and "\r" not in name
