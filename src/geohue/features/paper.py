"""The cues of the paper: colour, the colours of a second view, and geometry."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.features.color import lab_of
from geohue.features.cue import Cue
from geohue.features.normalize import SAME_COLOR, SAME_PLACE
from geohue.features.raw import Raw


def _second_lab(raw: Raw) -> NDArray[np.float32] | None:
    second = raw.scene.second_colors
    return None if second is None else lab_of(second)


COLOR = Cue("color", "color", lambda raw: raw.lab, constant=SAME_COLOR)
"""L, a, b (eq. 1, 4)."""

SECOND_VIEW = Cue("second view", "color", _second_lab)
"""L, a, b of the same points as another camera sees them, by their own deviation (eq. 19)."""

GEOMETRY = Cue("geometry", "geometry", lambda raw: raw.scene.points, constant=SAME_PLACE)
"""x, y, z (eq. 3)."""
