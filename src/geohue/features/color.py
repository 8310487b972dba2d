"""Colour as a cue: CIELab of the scene, and of its second view (eq. 1, 4, 19)."""

from __future__ import annotations

from threading import Thread

import numpy as np
from numpy.typing import NDArray

_ROW = 65_536  # pixels whose steps stay in the cache


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
    flat = np.ascontiguousarray(colors).reshape(1, -1, 3)
    lab = np.empty(flat.shape, np.float32)
    # Long rows: OpenCV would hand several to threads, which wait for each other on a busy machine
    # longer than they save.
    for first in range(0, flat.shape[1], _ROW):
        unit = flat[:, first : first + _ROW].astype(np.float32)
        unit /= np.float32(255)
        lab[:, first : first + _ROW] = cv2.cvtColor(unit, cv2.COLOR_RGB2Lab)
    return lab.reshape(colors.shape)


def make_ready() -> None:
    """Let OpenCV make its tables in a thread: 80 ms of the first call, without Python's lock."""
    import cv2

    pixel = np.zeros((1, 1, 3), np.float32)
    Thread(target=cv2.cvtColor, args=(pixel, cv2.COLOR_RGB2Lab), daemon=True).start()
