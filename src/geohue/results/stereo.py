"""What is written of a stereo pair: disparity, rectified views, and labels of the raw image."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geohue.results.png import write_png
from geohue.stereo.pair import StereoPair

_LARGEST = np.iinfo(np.uint16).max
_STEPS = 256  # of a pixel: KITTI's unit


def write_pair(folder: Path, pair: StereoPair, labels: NDArray[np.int32]) -> list[str]:
    """Write a pair that was rectified here, and the labels in the raw left image.

    Parameters
    ----------
    folder : Path
        Where to.
    pair : StereoPair
        The pair.
    labels : (H, W) int32
        Of the rectified left image, -1 = none.

    Returns
    -------
    list of str
        ``disparity.png`` (16 bit, 1/256 px, 0 = none, values that do not fit left out); if the
        pair was rectified here also ``rectified_left.png``, ``rectified_right.png``,
        ``labels_original.png`` (16 bit, 0 = none) in the pixels of the left image as it was given,
        and ``rectification.npz``: ``x`` and ``y`` of each of those pixels in the rectified image.
    """
    names = ["disparity.png"]
    write_png(folder / names[0], to_steps(pair.disparity))
    if pair.unrectified is None:
        return names
    images: dict[str, NDArray[np.uint8] | NDArray[np.uint16]] = {
        "rectified_left": pair.left,
        "rectified_right": pair.right,
        "labels_original": (pair.to_original(labels, -1) + 1).astype(np.uint16),
    }
    for name, image in images.items():
        names.append(f"{name}.png")
        write_png(folder / names[-1], image)
    names.append("rectification.npz")
    x, y = (pair.unrectified[..., i] for i in (0, 1))
    np.savez_compressed(folder / names[-1], x=x, y=y)
    return names


def to_steps(disparity: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Round pixels to 1/256; 0 for what is missing, not positive or too large.

    Examples
    --------
    >>> to_steps(np.array([[1.5, np.nan, -2.0, 300.0]], np.float32)).tolist()
    [[384, 0, 0, 0]]
    """
    with np.errstate(invalid="ignore"):
        steps = np.rint(disparity * np.float32(_STEPS))
        fits = (steps >= 1) & (steps <= _LARGEST)
    return np.where(fits, steps, 0).astype(np.uint16)
