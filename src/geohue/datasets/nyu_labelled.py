"""NYU Depth v2, labelled: the file nyu_depth_v2_labeled.mat (HDF5, needs h5py)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics
from geohue.datasets.frames import Dataset, Frame
from geohue.read.extras import optional
from geohue.read.files import broken, reason

_CAMERA = Intrinsics(518.857901, 519.469611, 325.582449, 253.736166, 640, 480)
_HDF5 = b"\x89HDF\r\n\x1a\n"


def matches(folder: Path) -> bool:
    """Whether it is a MATLAB file of version 7.3, or a folder with the one of the data set."""
    file = _file(folder)
    if file.suffix.lower() != ".mat" or not file.is_file():
        return False
    with file.open("rb") as start:
        return _HDF5 in start.read(1024)


def load(folder: Path) -> Dataset:
    """List the frames; pictures and depth are read one at a time."""
    file = _file(folder)
    h5py = optional("h5py", "datasets", file)
    try:
        with h5py.File(file, "r") as content:
            count = content["images"].shape[0]
            usable = content["images"].ndim == 4 and content["depths"].shape[0] == count
    except Exception as error:  # h5py raises many kinds for a damaged file
        raise broken(file, f"is damaged or another .mat file ({reason(error)})") from error
    if not usable:
        raise broken(file, "has no images and depths of the same number; download it again")
    frames = [
        Frame(f"{i + 1:04d}", _reader(file, "images", i), _depth(file, i), _CAMERA)
        for i in range(count)
    ]
    return Dataset("nyu_labelled", folder, frames, ("the depth has its holes filled",))


def _file(folder: Path) -> Path:
    return folder / "nyu_depth_v2_labeled.mat" if folder.is_dir() else folder


def _slice(file: Path, name: str, i: int) -> NDArray[Any]:
    h5py: Any = optional("h5py", "datasets", file)
    try:
        with h5py.File(file, "r") as content:
            return np.asarray(content[name][i])
    except Exception as error:
        raise broken(file, f"is damaged ({reason(error)}); download it again") from error


def _reader(file: Path, name: str, i: int) -> Callable[[], NDArray[np.uint8]]:
    """MATLAB's columns come first: (3, W, H) becomes (H, W, 3)."""
    return lambda: np.ascontiguousarray(_slice(file, name, i).transpose(2, 1, 0).astype(np.uint8))


def _depth(file: Path, i: int) -> Callable[[], NDArray[np.float32]]:
    return lambda: np.ascontiguousarray(_slice(file, "depths", i).T.astype(np.float32))
