"""Names for the kinds of arrays that several rooms pass on."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.floating[Any]]
"""Real numbers in single or double precision."""


class Rows(Protocol):
    """Points that are asked for block by block: an array, or what reads them from elsewhere."""

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of the blocks: float32 or float64."""

    def __len__(self) -> int: ...

    def __getitem__(self, rows: slice, /) -> Floats: ...
