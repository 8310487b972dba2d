"""Real scenes that need no download."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics
from geohue.errors import GeohueError
from geohue.read.images.pictures import read_color
from geohue.scene import Scene
from geohue.simulate.scenes import WORLDS

if TYPE_CHECKING:
    from geohue.stereo.rig import StereoRig


def motorcycle() -> Scene:
    """Return the Middlebury 2014 motorcycle, from the stereo pair inside the scikit-image wheel.

    The left view with the ground-truth disparity as depth, ``Z = b f / (d + doffs)``, by the
    calibration published with it (quarter size).

    References
    ----------
    D. Scharstein et al., "High-resolution stereo datasets with subpixel-accurate ground truth",
    GCPR 2014.
    """
    left, _, disparity, rig = _motorcycle_pair()
    return Scene.from_rgbd(left, rig.depth(disparity), rig.left)


def motorcycle_stereo() -> Scene:
    """Return the motorcycle with the colours of both views (eq. 19)."""
    left, right, disparity, rig = _motorcycle_pair()
    return Scene.from_stereo(left, right, rig, disparity)


def motorcycle_matched() -> Scene:
    """Return the motorcycle from its two images alone: the disparity is matched."""
    left, right, _, rig = _motorcycle_pair()
    return Scene.from_stereo(left, right, rig)


def _motorcycle_pair() -> tuple[
    NDArray[np.uint8], NDArray[np.uint8], NDArray[np.float32], StereoRig
]:
    from geohue.stereo.rig import StereoRig

    left, right, disparity = _motorcycle_files()
    height, width = disparity.shape
    focal, cx, cy, doffs = 994.978, 311.193, 254.877, 31.086
    cameras = [Intrinsics(focal, focal, x, cy, width, height) for x in (cx, cx + doffs)]
    known = np.where(np.isfinite(disparity), disparity, np.nan).astype(np.float32)
    return left, right, known, StereoRig(cameras[0], cameras[1], baseline=0.193001)


def _motorcycle_files() -> tuple[NDArray[np.uint8], NDArray[np.uint8], NDArray[np.float32]]:
    """Read the two images and the disparity.

    From their files, because scikit-image imports a tenth of a second of readers for it.
    """
    package = find_spec("skimage")
    homes = [Path(home) for home in (package and package.submodule_search_locations) or []]
    for data in (home / "data" for home in homes):
        if (data / "motorcycle_disp.npz").is_file():
            with np.load(data / "motorcycle_disp.npz") as disparity:
                images = (read_color(data / f"motorcycle_{side}.png") for side in ("left", "right"))
                return *images, disparity["arr_0"]
    from skimage.data import stereo_motorcycle  # some packages fetch them when asked

    return stereo_motorcycle()  # type: ignore[no-any-return]


def _simulated(name: str) -> Scene:
    from geohue.simulate import scene

    return scene(name)[0]


SAMPLES: dict[str, Callable[[], Scene]] = {
    "motorcycle": motorcycle,
    "motorcycle-stereo": motorcycle_stereo,
    "motorcycle-matched": motorcycle_matched,
    **{name: partial(_simulated, name) for name in WORLDS},
}
"""The samples by name; those after the motorcycle are simulated (`geohue.simulate`)."""


def load_sample(name: str) -> Scene:
    """Load a scene that needs no download.

    Parameters
    ----------
    name : str
        One of `SAMPLES`.

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
