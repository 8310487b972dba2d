"""A stretch of the points of a cloud on disk."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Chunk = tuple[NDArray[np.float64], NDArray[np.uint8]]
"""Coordinates (m, 3) as in the file, NaN where missing, and sRGB (m, 3)."""


class Chunks(Protocol):
    """A cloud on disk, of which any stretch of points can be read.

    It holds no more than an open file and pickles as its path and what its header says, so that
    other processes read from it too.
    """

    @property
    def path(self) -> Path:
        """The file."""

    @property
    def n_points(self) -> int:
        """Points in the file."""

    @property
    def has_colors(self) -> bool:
        """Whether the file has colours; `read` gives black where it has none."""

    @property
    def is_double(self) -> bool:
        """Whether the coordinates need more than float32."""

    def read(self, start: int, stop: int) -> Chunk:
        """Read the points from `start` to `stop` (exclusive)."""

    def close(self) -> None:
        """Let go of the file; the next `read` opens it again."""
