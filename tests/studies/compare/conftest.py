"""Comparisons that several tests look at."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from geohue import Scene
from geohue.studies.compare import Comparison, compare
from geohue.studies.compare import run as module
from studies.compare import _faults

FAULTY = ("nncsc", "kmeans", "meanshift", "felzenszwalb", "edison")


@pytest.fixture(scope="session")
def faulty(three_boxes: tuple[Scene, NDArray[np.int32]]) -> Comparison:
    """A comparison in which one method raises, one is killed and one never ends."""
    scene, truth = three_boxes
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "run_cell", _faults.faulty_cell)
        return compare(
            scene, FAULTY, ("fusion", "color"), 3, truth=truth + 1, processes=2, timeout=12
        )
