"""Vectors that stay where they are: on disk, or behind anything that has rows."""

from __future__ import annotations

from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.compute.parallel import BLOCK
from geohue.errors import GeohueError

READ = 4 * BLOCK
"""Rows of a read are a multiple of this, so that no block lies in two reads."""

_KEPT = 2


class Streamed:
    """Rows read in large pieces and handed out in small ones; the last two pieces are kept.

    Parameters
    ----------
    source : object
        Has ``shape`` (N, D), ``dtype`` and rows by slice: a memory map, an HDF5 data set, ...
    chunk_rows : int
        Rows of a piece, rounded up to a multiple of `READ`.

    Raises
    ------
    GeohueError
        If it is no table of real numbers; later, if a number read is not finite.

    Examples
    --------
    >>> rows = Streamed(np.arange(6.0).reshape(3, 2), chunk_rows=1)
    >>> len(rows), rows[1:3].tolist()
    (3, [[2.0, 3.0], [4.0, 5.0]])
    """

    def __init__(self, source: Any, chunk_rows: int) -> None:
        shape: tuple[int, ...] = tuple(getattr(source, "shape", ()))
        dtype = getattr(source, "dtype", None)
        if len(shape) != 2 or 0 in shape or dtype is None:
            raise GeohueError(f"X has shape {shape}: expected (N, D), such as a memory map")
        if np.dtype(dtype).kind not in "fiu":
            raise GeohueError(f"X has type {dtype}: expected real numbers")
        if chunk_rows < 1:
            raise GeohueError(f"chunk_rows is {chunk_rows}: expected at least 1")
        self._source, self._step = source, -(-int(chunk_rows) // READ) * READ
        self._pieces: dict[int, NDArray[Any]] = {}
        self._lock = Lock()
        self.shape, self.dtype = shape, np.dtype(dtype)

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, rows: slice) -> NDArray[Any]:
        """Return rows that lie in one piece."""
        number = rows.start // self._step
        with self._lock:
            if number not in self._pieces:
                while len(self._pieces) >= _KEPT:
                    del self._pieces[min(self._pieces)]
                self._pieces[number] = self._read(number * self._step)
            piece = self._pieces[number]
        first = number * self._step
        return piece[rows.start - first : rows.stop - first]

    def _read(self, first: int) -> NDArray[Any]:
        piece = np.array(self._source[first : first + self._step])
        finite = np.isfinite(piece).all(axis=1)
        if not finite.all():
            row = first + int(finite.argmin())
            raise GeohueError(f"row {row} of X has NaN or infinity: leave such rows out")
        return piece
