"""Real scenes that need no download."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from geohue.camera import Intrinsics
from geohue.errors import GeohueError
from geohue.scene import Scene


def motorcycle() -> Scene:
    """Return the Middlebury 2014 motorcycle, from the stereo pair inside the scikit-image wheel.

    The left view with the ground-truth disparity as depth, ``Z = b f / (d + doffs)``, by the
    calibration published with it (quarter size).

    References
    ----------
    D. Scharstein et al., "High-resolution stereo datasets with subpixel-accurate ground truth",
    GCPR 2014.
    """
    from skimage.data import stereo_motorcycle

    left, _, disparity = stereo_motorcycle()
    focal, baseline, doffs = 994.978, 0.193001, 31.086
    with np.errstate(invalid="ignore"):
        depth = baseline * focal / (disparity + doffs)
    depth[~np.isfinite(disparity)] = np.nan
    height, width = depth.shape
    camera = Intrinsics(focal, focal, 311.193, 254.877, width, height)
    return Scene.from_rgbd(left, depth, camera)


SAMPLES: dict[str, Callable[[], Scene]] = {"motorcycle": motorcycle}
"""The samples by name."""


def load_sample(name: str) -> Scene:
    """Load a scene that needs no download.

    Parameters
    ----------
    name : {"motorcycle"}

    Returns
    -------
    Scene

    Raises
    ------
    GeohueError
        For an unknown name.

    Examples
    --------
    >>> load_sample("motorcycle").shape
    (500, 741)
    """
    if name not in SAMPLES:
        raise GeohueError(f"sample {name!r}: choose one of {', '.join(SAMPLES)}")
    return SAMPLES[name]()
