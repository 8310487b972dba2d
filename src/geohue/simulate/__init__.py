"""Made-up scenes with exact segments, seen through models of real depth sensors (Sec. VII).

>>> from geohue.simulate import scene
>>> frame, truth = scene("balls")
>>> frame.shape == truth.shape, int(truth.max()) + 1
(True, 6)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics
from geohue.errors import GeohueError
from geohue.scene import Scene
from geohue.simulate.scenes import WORLDS
from geohue.simulate.sensors import SENSORS, Stereo, StructuredLight, TimeOfFlight, measured
from geohue.simulate.world import Solid, View, World, render

CAMERA = Intrinsics(262.5, 262.5, 159.5, 119.5, 320, 240)
"""The colour camera of the scenes: a Kinect's at half size."""

__all__ = [
    "CAMERA",
    "SENSORS",
    "WORLDS",
    "Solid",
    "Stereo",
    "StructuredLight",
    "TimeOfFlight",
    "View",
    "World",
    "measured",
    "render",
    "scene",
]


def scene(
    name: str, sensor: str | None = None, camera: Intrinsics = CAMERA, seed: int = 0
) -> tuple[Scene, NDArray[np.int32]]:
    """Make a scene and its true segments.

    Parameters
    ----------
    name : {"boxes", "balls", "posters", "shelf", "corner"}
    sensor : {"tof", "kinect", "stereo"}, optional
        What measures the depth; exact depth if not given.
    camera : Intrinsics
        The colour camera, with its size.
    seed : int
        The source of chance of the noise.

    Returns
    -------
    scene : Scene
        With a little noise on the colours.
    truth : (H, W) int32
        Segments from 0: the ground, the wall, the things.

    Raises
    ------
    GeohueError
        For an unknown name, or a camera without a size.
    """
    if name not in WORLDS:
        raise GeohueError(f"scene {name!r}: choose one of {', '.join(WORLDS)}")
    if sensor is not None and sensor not in SENSORS:
        raise GeohueError(f"sensor {sensor!r}: choose one of {', '.join(SENSORS)}")
    if camera.width is None or camera.height is None:
        raise GeohueError("the camera has no size: give its width and height")
    world = WORLDS[name]()
    device = None if sensor is None else SENSORS[sensor]()
    return measured(world, device, camera, seed), render(world, camera, samples=1).labels
