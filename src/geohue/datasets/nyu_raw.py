"""NYU Depth v2, raw: r-*.ppm and d-*.pgm of the Kinect, not registered, not synchronised."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from geohue.camera import Intrinsics
from geohue.datasets.frames import Dataset, Frame, sorted_files
from geohue.sensors.lens import Lens
from geohue.sensors.rig import PosedCamera, Rig

_TIME = re.compile(r"^[rd]-(\d+(?:\.\d+)?)-")


def nyu_rig() -> Rig:
    """Return the calibration published with the data set's toolbox.

    The pictures are mirrored as recorded; such that ``X_color = R X_depth + T`` holds for them, T
    has the toolbox's values with the other sign (checked by the agreement of the edges).
    """
    depth = Lens(
        Intrinsics(
            582.62448167737955, 582.69103270988637, 313.04475870804731, 238.44389626620386
        ).scaled_to(640, 480),
        (-0.0998972365, 0.3906532460, 0.0019290593, -0.0019422022, -0.5103172505),
    )
    color = Lens(
        Intrinsics(518.85790117450188, 519.46961112127485, 325.58244941119034, 253.73616633400465),
        (0.2079661532, -0.5861382516, 0.0007223136, 0.0010479627, 0.4985698668),
    )
    R = np.array(
        [
            [0.99997798940829, -0.00503599194808, -0.00431966249231],
            [0.00505184193862, 0.99998051861144, 0.00366623657485],
            [0.00430111520141, -0.00368797813095, 0.99998394948386],
        ]
    )
    T = -np.array([0.02503187505914, 0.00066238747008, -0.00029342312936])
    return Rig((PosedCamera(color, R, T),), depth)


def matches(folder: Path) -> bool:
    """Whether there are d-*.pgm and r-*.ppm."""
    return all(next(folder.glob(p), None) is not None for p in ("d-*.pgm", "r-*.ppm"))


def load(folder: Path) -> Dataset:
    """Pair each depth map with the picture nearest in time."""
    colors = sorted_files(folder, "r-*.ppm")
    times = np.array([_time(file) for file in colors])
    rig = nyu_rig()
    frames = []
    for depth in sorted_files(folder, "d-*.pgm"):
        nearest = colors[int(np.argmin(np.abs(times - _time(depth))))]
        frames.append(Frame(depth.stem, nearest, depth, depth_scale="nyu-raw", rig=rig))
    return Dataset("nyu_raw", folder, frames, ("pictures are mirrored, as recorded",))


def _time(file: Path) -> float:
    found = _TIME.match(file.name)
    return float(found.group(1)) if found else 0.0
