"""A checkerboard in eight poses, as two cameras that are known see it."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from geohue import Intrinsics
from geohue.sensors import Lens, PosedCamera
from sensors.rigs import rotation

OPENCV: Any = cv2
PATTERN, SQUARE = (7, 5), 0.03
FIRST = PosedCamera(Lens(Intrinsics(300.0, 300.0, 160.0, 118.0, 320, 240)))
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
