"""Small folders of frames without labels, and jobs that other processes can import."""

from __future__ import annotations

import json
import os
import time
from pathlib import Path

import numpy as np

from geohue.results.png import write_png

HEIGHT, WIDTH = 36, 48
TAKES_S = 0.3  # a job that takes a moment


def write_frames(folder: Path, count: int = 3) -> Path:
    """Write frames of two coloured halves at two depths, each frame with its own border."""
    rng = np.random.default_rng(5)
    for i in range(count):
        part = np.zeros((HEIGHT, WIDTH), np.uint16)
        part[:, WIDTH // 2 + 3 * i :] = 1
        colors = np.array([[200, 60, 50], [50, 90, 200]])[part] + rng.normal(0, 5, (*part.shape, 3))
        write_png(folder / f"{i:04d}" / "rgb.png", np.clip(colors, 0, 255).astype(np.uint8))
        write_png(folder / f"{i:04d}" / "depth.png", (1000 * (1 + part)).astype(np.uint16))
        camera = {"fx": 40.0, "fy": 40.0, "cx": WIDTH / 2, "cy": HEIGHT / 2, "depth_scale": 1000}
        (folder / f"{i:04d}" / "intrinsics.json").write_text(json.dumps(camera))
    return folder


def note_and_square(job: tuple[int, str]) -> int:
    """Leave a file that tells the number and the process, take a moment, return the square."""
    number, folder = job
    (Path(folder) / f"{number}-{os.getpid()}").touch()
    time.sleep(TAKES_S)
    return number * number


def answer_of_another_version(version: str, payload: bytes) -> tuple[str, None, None]:  # noqa: ARG001
    """What a worker of geohue 0.0 says."""
    return "0.0", None, None
