"""Points as plain text: XYZ, TXT, CSV, ASC and PTS, with or without names for the columns."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.read.cameras.text import NUMBER
from geohue.read.clouds.cloud import CloudData, build_cloud, find_columns
from geohue.read.clouds.table import read_table, text_lines
from geohue.read.files import broken, read_bytes

_COMMENTS = ("#", "//", "%")
_ALIASES = {
    "r": "red",
    "g": "green",
    "b": "blue",
    "rf": "red",
    "gf": "green",
    "bf": "blue",
    "classification": "label",
    "class": "label",
    "segment": "label",
    "segment_id": "label",
}
_MOST_COLUMNS = 256


def read_xyz(path: str | Path) -> CloudData:
    """Read points from a text file, a row each.

    Parameters
    ----------
    path : path-like
        Numbers parted by blanks, tabs, commas or semicolons. A first row (or a comment before the
        numbers) may name the columns; a first row with one whole number is their count (PTS).
        Without names: x y z; x y z R G B; x y z intensity R G B; x y z R G B label; either of the
        first two with normals.

    Returns
    -------
    CloudData

    Raises
    ------
    GeohueError
        If the file is missing, or its rows are no numbers, differ in length or cannot be told.
    """
    data = read_bytes(path)
    if b"\0" in data[:4096]:
        raise broken(path, "is not text; a point cloud as text has a row of numbers a point")
    if b";" in data[:4096]:  # columns parted so may have decimal commas
        data = data.replace(b",", b".").replace(b";", b" ")
    elif b"," in data[:4096]:
        data = data.replace(b",", b" ")
    lines, names, announced = _head(text_lines(data), path)
    first = next(lines, None)
    if first is None:
        raise broken(path, "has no points")
    width = len(first.split())
    if not 3 <= width <= _MOST_COLUMNS:
        raise broken(path, f"has {width} number(s) in its first row; x y z are needed at least")
    rows = list(_without_comments(lines))
    count = len(rows) + 1
    if announced is not None and count < announced:
        raise broken(path, f"is cut short: {count} of {announced} rows; copy or export it again")
    table = read_table(iter([first, *rows]), count, range(width), width, path)
    named = names is not None and len(names) == width
    columns = names if named and names is not None else _guess(table, announced is not None)
    return build_cloud(_columns(table, columns), (count,), path)


def _head(
    lines: Iterator[str], path: str | Path
) -> tuple[Iterator[str], list[str] | None, int | None]:
    """Take comments, names and a count off; returns the rows that follow."""
    names: list[str] | None = None
    for line in islice(lines, 10_000):
        words = line.strip().lstrip("".join(_COMMENTS)).replace('"', " ").split()
        if not words:
            continue
        if line.strip().startswith(_COMMENTS):
            names = _names(words) or names
        elif all(_is_number(word) for word in words):
            if len(words) == 1 and re.fullmatch(r"\d{1,12}", words[0]):
                return _without_comments(lines), names, int(words[0])
            return _again(line, lines), names, None
        else:
            names = _names(words)
            if names is None:
                raise broken(path, f"has a row that is no point: {line.strip()[:40]!r}")
    return lines, names, None


def _again(line: str, rest: Iterator[str]) -> Iterator[str]:
    yield line
    yield from _without_comments(rest)


def _without_comments(lines: Iterator[str]) -> Iterator[str]:
    return (line for line in lines if not line.lstrip().startswith(_COMMENTS))


def _is_number(word: str) -> bool:
    return bool(re.fullmatch(NUMBER, word)) or word.lower() in ("nan", "-nan", "inf", "-inf")


def _names(words: Sequence[str]) -> list[str] | None:
    """Return column names if the words name x, y and z."""
    lower = [re.sub(r"\W", "", word.lower()) for word in words]
    names = [_ALIASES.get(name, name) for name in lower]
    return names if "points" in find_columns(dict.fromkeys(names)) else None


def _guess(table: NDArray[np.float64], intensity: bool) -> list[str]:
    """Name the columns of a table by how many there are and what they hold.

    Files with a count at their head (PTS) have the intensity before the colours.
    """
    width = table.shape[1]
    names = [f"column{i}" for i in range(width)]
    names[:3] = ["x", "y", "z"]
    rgb, normals = ["red", "green", "blue"], ["nx", "ny", "nz"]
    if width == 3 or width == 4:
        return names
    order = (4, 3, 6) if intensity else (3, 4, 6)
    starts = [i for i in order if i + 3 <= width and _are_colors(table[:, i : i + 3])]
    if not starts:
        if width >= 6 and _are_normals(table[:, 3:6]):
            names[3:6] = normals
        return names
    start = starts[0]
    names[start : start + 3] = rgb
    if start == 3 and width >= 9 and _are_normals(table[:, 6:9]):
        names[6:9] = normals
    elif start == 3 and width == 7 and _is_whole(table[:, 6]):
        names[6] = "label"
    elif start == 6 and _are_normals(table[:, 3:6]):
        names[3:6] = normals
    return names


def _are_colors(values: NDArray[np.float64]) -> bool:
    """Whether three columns are whole numbers within 0..65535, or fractions that are no normals."""
    low, high = values.min(), values.max()
    if not (low >= 0 and high <= 65535):
        return False
    return _is_whole(values) or (high <= 1 and not _are_normals(values))


def _are_normals(values: NDArray[np.float64]) -> bool:
    lengths = np.linalg.norm(values, axis=1)
    return bool(np.isfinite(lengths).any() and np.nanmedian(np.abs(lengths - 1)) < 0.02)


def _is_whole(values: NDArray[np.float64]) -> bool:
    return bool(np.isfinite(values).all() and (values == np.rint(values)).all())


def _columns(table: NDArray[np.float64], names: Sequence[str]) -> dict[str, NDArray[Any]]:
    """Give each column its name; whole colours up to 255 count as bytes, also if all are 0 or 1."""
    columns: dict[str, NDArray[Any]] = {name: table[:, i] for i, name in enumerate(names)}
    found = find_columns(columns).get("colors", ())
    whole = bool(found) and all(_is_whole(columns[name]) for name in found)
    for name in found if whole else ():
        columns[name] = np.clip(columns[name], 0, 65535).astype(np.uint16)
    return columns
