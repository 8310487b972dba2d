"""Checkerboards: rendered ones with known cameras, and OpenCV's stereo set."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from geohue import GeohueError, Intrinsics
from geohue.read import read_color
from geohue.read.cameras.rig import read_rig
from geohue.results.rig import write_rig
from geohue.sensors import Lens, PosedCamera
from geohue.sensors.calibration import calibrate_rig
from geohue.stereo.calibrate import find_corners
from sensors.rigs import rotation

OPENCV: Any = cv2
PATTERN, SQUARE = (7, 5), 0.03
FIRST = Intrinsics(300.0, 300.0, 160.0, 118.0, 320, 240)
SECOND = PosedCamera(
    Lens(Intrinsics(330.0, 331.0, 158.0, 122.0, 320, 240)), rotation(1, 3), np.array([-0.05, 0, 0])
)


def board_picture() -> NDArray[np.uint8]:
    """A board with 40 px squares and a white border of one square."""
    squares = np.indices((PATTERN[1] + 1, PATTERN[0] + 1)).sum(axis=0) % 2
    picture = np.kron(squares * 255, np.ones((40, 40))).astype(np.uint8)
    return np.pad(255 - picture, 40, constant_values=255)


def seen(camera: PosedCamera, R: NDArray[np.float64], t: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Render the board in a pose, four times as fine as the picture."""
    corners = np.array([[-2, -2], [PATTERN[0] + 1, -2], [PATTERN[0] + 1, 6], [-2, 6]], float)
    flat = np.hstack([corners * SQUARE, np.zeros((4, 1))]) @ R.T + t
    pixels = camera.lens.project(camera.transform(flat))
    wide, high = (PATTERN[0] + 3) * 40 - 0.5, (PATTERN[1] + 3) * 40 - 0.5
    source = np.array([[-0.5, -0.5], [wide, -0.5], [wide, high], [-0.5, high]], np.float32)
    target = (pixels + 0.5).astype(np.float32) * 4 - 0.5
    H = OPENCV.getPerspectiveTransform(source, target.astype(np.float32))
    fine = OPENCV.warpPerspective(board_picture(), H, (1280, 960), borderValue=128)
    return np.asarray(OPENCV.resize(fine, (320, 240), interpolation=cv2.INTER_AREA), np.uint8)


def poses() -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    tilts = [(0, 0, 0), (25, 0, 5), (-25, 5, 0), (0, 25, 10), (5, -25, 0), (20, 20, -10)]
    tilts += [(-20, 15, 5), (15, -20, 10)]
    return [
        (
            rotation(0, a) @ rotation(1, b) @ rotation(2, c),
            np.array([-0.1 + 0.01 * i, -0.07, 0.42 + 0.02 * i]),
        )
        for i, (a, b, c) in enumerate(tilts)
    ]


def test_finds_the_cameras_that_rendered_the_boards(tmp_path: Path) -> None:
    first = PosedCamera(Lens(FIRST))
    pairs = [(seen(first, *pose), seen(SECOND, *pose)) for pose in poses()]
    found = calibrate_rig([a for a, _ in pairs], [b for _, b in pairs], PATTERN, SQUARE)
    assert len(found.used) >= 6
    assert max(found.rms) < 0.2
    assert found.rig.depth_lens.camera.fx == pytest.approx(300, rel=0.01)
    camera = found.rig.cameras[0]
    assert camera.lens.camera.fx == pytest.approx(330, rel=0.01)
    assert camera.translation == pytest.approx(SECOND.translation, abs=0.002)
    assert camera.rotation == pytest.approx(SECOND.rotation, abs=0.01)
    write_rig(tmp_path / "rig.json", found.rig)
    again = read_rig(tmp_path / "rig.json")
    assert again.depth == found.rig.depth
    assert again.cameras[0].rotation == pytest.approx(camera.rotation)


def test_opencvs_stereo_set(data_dir: Path) -> None:
    folder = data_dir / "opencv_samples"
    numbers = [i for i in range(1, 15) if i != 10]
    sides = [
        [read_color(folder / f"{side}{i:02d}.jpg") for i in numbers] for side in ("left", "right")
    ]
    found = calibrate_rig(sides[0], sides[1], (9, 6), 1.0)
    assert len(found.used) == 13
    assert max(found.rms) < 0.25
    # intrinsics.yml and OpenCV's documentation: f = 535 px, 3.3 squares between the cameras
    assert found.rig.depth_lens.camera.fx == pytest.approx(534.8, rel=0.005)
    assert found.rig.cameras[0].translation[0] == pytest.approx(-3.33, abs=0.02)


def test_refuses_too_little() -> None:
    blank = np.zeros((60, 80), np.uint8)
    assert find_corners(blank, PATTERN) is None
    with pytest.raises(GeohueError, match="0 of 3 pairs"):
        calibrate_rig([blank] * 3, [blank] * 3, PATTERN, SQUARE)
    with pytest.raises(GeohueError, match="pairs are needed"):
        calibrate_rig([blank], [blank] * 3, PATTERN, SQUARE)
    with pytest.raises(GeohueError, match="no checkerboard"):
        calibrate_rig([blank], [blank], (1, 5), SQUARE)
