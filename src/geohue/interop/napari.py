"""A reader of result folders for napari, which is not imported: it takes plain layer data."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import numpy as np

Layer = tuple[Any, dict[str, Any], str]


def get_reader(path: str | list[str]) -> Callable[[str | list[str]], list[Layer]] | None:
    """Return the reader of a folder that ``geohue segment -o`` wrote, None for anything else."""
    if isinstance(path, list) or not (Path(path) / "labels.png").is_file():
        return None
    return read_folder


def read_folder(path: str | list[str]) -> list[Layer]:
    """Return the labels, and the borders and levels where they are there, as layers of napari.

    Parameters
    ----------
    path : str
        The folder.

    Returns
    -------
    list of (array, dict, str)
        Labels 0 = none, segments from 1, as in ``labels.png``; ``borders`` as an image, and three
        levels of detail, hidden.
    """
    from geohue.read import read_levels
    from geohue.read.images.pictures import read_labels

    folder = Path(path if isinstance(path, str) else path[0])
    layers: list[Layer] = [(read_labels(folder / "labels.png"), {"name": "segments"}, "labels")]
    if (folder / "levels.npz").is_file():
        levels = read_levels(folder / "levels.npz")
        details: tuple[Literal["fine", "coarse"], ...] = ("fine", "coarse")
        for detail in details:
            found = levels.at(detail) + 1
            layers.append((found.astype(np.int32), {"name": detail, "visible": False}, "labels"))
    return layers
