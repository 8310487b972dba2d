"""Small frames on disk."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from geohue.results.png import write_png


def write_frames(folder: Path, count: int = 3, height: int = 36, width: int = 48) -> Path:
    """Write frames of two coloured halves at two depths, each frame with its own border."""
    rng = np.random.default_rng(5)
    for i in range(count):
        truth = np.ones((height, width), np.uint16)
        truth[:, width // 2 + 3 * i :] = 2
        truth[:2] = 0
        colors = np.array([[0, 0, 0], [200, 60, 50], [50, 90, 200]])[np.maximum(truth, 1)]
        noisy = np.clip(colors + rng.normal(0, 5, colors.shape), 0, 255).astype(np.uint8)
        part = folder / f"{i:04d}"
        write_png(part / "rgb.png", noisy)
        write_png(part / "depth.png", (1000 * np.maximum(truth, 1)).astype(np.uint16))
        write_png(part / "labels.png", truth)
        camera = {"fx": 40.0, "fy": 40.0, "cx": width / 2, "cy": height / 2, "depth_scale": 1000}
        (part / "intrinsics.json").write_text(json.dumps(camera))
    return folder


@pytest.fixture(scope="session")
def make_frames() -> Callable[..., Path]:
    """`write_frames`, which makes a folder of labelled frames."""
    return write_frames
