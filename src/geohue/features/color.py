"""Colour as a cue: CIELab of the scene, and of its second view (eq. 1, 4, 19)."""

from __future__ import annotations

from threading import Thread

import numpy as np
from numpy.typing import NDArray


def lab_of(colors: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Convert sRGB to CIELab, D65 (eq. 1).

    OpenCV converts, much faster than scikit-image and within 0.5 Lab units of it.

    Parameters
    ----------
    colors : (..., 3) uint8
        sRGB.

    Returns
    -------
    (..., 3) float32
        L in 0..100; a and b within about -128..127.

    Examples
    --------
    >>> lab_of(np.array([[255, 255, 255]], np.uint8)).round().tolist()
    [[100.0, 0.0, 0.0]]
    """
    import cv2

    if colors.size == 0:
        return np.zeros(colors.shape, np.float32)
    unit = colors.astype(np.float32) / np.float32(255)
    # One long row: OpenCV would hand the rows to threads, which wait for each other on a busy
    # machine longer than they save.
    lab = np.asarray(cv2.cvtColor(unit.reshape(1, -1, 3), cv2.COLOR_RGB2Lab), np.float32)
    return lab.reshape(colors.shape)


def make_ready() -> None:
    """Let OpenCV make its tables in a thread: 80 ms of the first call, without Python's lock."""
    import cv2

    pixel = np.zeros((1, 1, 3), np.float32)
    Thread(target=cv2.cvtColor, args=(pixel, cv2.COLOR_RGB2Lab), daemon=True).start()
