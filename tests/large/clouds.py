"""Clouds with known parts."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

N = 12_000
"""Points of the cloud of the tests."""


def three_blobs(
    n_points: int, seed: int = 0
) -> tuple[NDArray[np.float32], NDArray[np.uint8], NDArray[np.int32]]:
    """Three balls of different size, place and colour, their points in random order."""
    rng = np.random.default_rng(seed)
    truth = rng.choice(3, n_points, p=[0.5, 0.3, 0.2]).astype(np.int32)
    centers = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 1]])[truth]
    paints = np.array([[200, 60, 50], [60, 160, 70], [70, 80, 190]])[truth]
    xyz = (centers + rng.normal(0, 0.3, (n_points, 3))).astype(np.float32)
    rgb = np.clip(paints + rng.normal(0, 6, (n_points, 3)), 0, 255).astype(np.uint8)
    return xyz, rgb, truth


def table(xyz: NDArray[np.float32], rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Rows x, y, z, red, green, blue."""
    return np.hstack([xyz, rgb.astype(np.float32)])


def labels_of(out: Path) -> NDArray[np.int32]:
    """Return the labels that a run has written."""
    return np.asarray(np.load(out / "labels.npy"))


def outcome_of(out: Path) -> dict[str, Any]:
    """What a run found, without the time that it took."""
    content: dict[str, Any] = json.loads((out / "result.json").read_text())
    del content["timings_s"]
    return content
