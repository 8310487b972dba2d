"""What several tests share: the real data, and scenes with known parts."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from geohue import Scene


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """The folder of real data; tests that need it are skipped where it is absent."""
    named = os.environ.get("GEOHUE_DATA")
    folder = Path(named) if named else Path(__file__).parents[2] / "shared" / "data"
    if not folder.is_dir():
        pytest.skip(f"no real data at {folder}: set GEOHUE_DATA")
    return folder


@pytest.fixture(scope="session")
def three_boxes() -> tuple[Scene, NDArray[np.int32]]:
    """A frame with three parts that only both cues together tell apart.

    Two boxes of one colour at different depths, and a third of another colour beside the first
    at the same depth.
    """
    rng = np.random.default_rng(7)
    truth = np.zeros((60, 90), np.int32)
    truth[:, 30:60] = 1
    truth[:, 60:] = 2
    rgb = np.array([[200, 60, 50], [60, 160, 70], [60, 160, 70]])[truth]
    depth = np.array([1.0, 1.0, 1.8])[truth]
    noisy = np.clip(rgb + rng.normal(0, 4, rgb.shape), 0, 255).astype(np.uint8)
    return Scene.from_rgbd(noisy, depth + rng.normal(0, 0.004, depth.shape)), truth
