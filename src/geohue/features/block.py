"""The normalised values of one cue."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Side = Literal["color", "geometry"]
"""What the weight lambda balances: the cues of geometry are multiplied by it, others are not."""


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """The part of the vectors that one cue makes.

    Attributes
    ----------
    name : str
        Of the cue.
    side : {"color", "geometry"}
        Whether lambda multiplies it.
    values : (M, C) float32
        Normalised; zeros if the cue is not used or does not vary.
    share : float
        Its size beside the other blocks of its side; 1 for the paper's.
    used : bool
        Whether a cue stands behind it.
    """

    name: str
    side: Side
    values: NDArray[np.float32]
    share: float = 1.0
    used: bool = True
