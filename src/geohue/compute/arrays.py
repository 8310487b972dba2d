"""Names for the kinds of arrays that several rooms pass on."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.floating[Any]]
"""Real numbers in single or double precision."""
