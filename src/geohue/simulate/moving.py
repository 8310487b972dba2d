"""A room filmed by a moving camera, with exact segments, poses and motion of every pixel.

One ball rolls through the picture, one cylinder enters it, and one ball passes behind a cupboard
that hides it for ten frames.

>>> frames = list(moving_scene(2, Intrinsics(66.0, 66.0, 39.5, 29.5, 80, 60)))
>>> frames[0].truth.shape, bool(np.array_equal(frames[0].pose, frames[1].pose))
((60, 80), False)
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics
from geohue.errors import GeohueError
from geohue.scene import Scene
from geohue.simulate.materials import Material
from geohue.simulate.scenes import BLUE, CARDBOARD, CARPET, GREEN, RED, WALL, YELLOW
from geohue.simulate.sensors import SENSORS, measured
from geohue.simulate.shapes import Box, Cylinder, Floats, Plane, Shape, Sphere, Vector
from geohue.simulate.world import Solid, World, render

MOVING, ENTERING, HIDDEN = 4, 5, 6
"""The labels of the ball that rolls, of the cylinder that enters, and of the ball that hides."""

LENGTH = 90
"""Frames after which the sequence begins anew."""

_ENTERS, _ARRIVES = 20, 50
_HIDES = 40  # the hidden ball is straight behind the cupboard
_SPEED = 0.0155  # metres a frame of the hidden ball


@dataclass(frozen=True, slots=True, eq=False)
class MovingFrame:
    """One frame of the simulated sequence.

    Attributes
    ----------
    scene : Scene
        What the camera and the depth sensor see.
    truth : (H, W) int32
        0 the ground, 1 the wall, 2 a box, 3 the cupboard, then `MOVING`, `ENTERING` and `HIDDEN`.
    pose : (4, 4) float64
        Camera to world.
    places : (7, 3) float64
        How far the thing of each label has moved from its place in the first frame, metres.
    """

    scene: Scene
    truth: NDArray[np.int32]
    pose: Floats
    places: Floats


def moving_world(frame: float) -> tuple[World, Floats]:
    """Return the room at some moment, and how far each thing has moved.

    Parameters
    ----------
    frame : float
        From 0; the things stand in other places, the camera sways.

    Returns
    -------
    world : World
    places : (7, 3) float64
        As in `MovingFrame`.
    """
    at, start = _centers(frame), _centers(0)
    things: list[tuple[Shape, Material]] = [
        (Box((-0.42, -0.14, 1.05), (0.22, 0.28, 0.2), 25), RED),
        (Box((0.12, -0.3, 1.3), (0.26, 0.6, 0.14), 0), CARDBOARD),
        (Sphere(at[MOVING], 0.13), YELLOW),
        (Cylinder(at[ENTERING], 0.09, 0.3), GREEN),
        (Sphere(at[HIDDEN], 0.1), BLUE),
    ]
    solids = [
        Solid(Plane((0, 0, 0), (0, -1, 0)), CARPET, 0),
        Solid(Plane((0, 0, 1.9), (0, 0, -1)), WALL, 1),
        *(Solid(shape, material, 2 + i) for i, (shape, material) in enumerate(things)),
    ]
    sway = 2 * np.pi * frame / LENGTH
    eye = (0.08 * float(np.sin(sway)), -0.75 + 0.03 * float(np.sin(2 * sway)), 0.0)
    places = np.zeros((7, 3))
    for label in at:
        places[label] = np.subtract(at[label], start[label])
    return World(tuple(solids), eye=eye, pitch=20.0 + float(np.sin(sway))), places


def moving_scene(
    n_frames: int = LENGTH,
    camera: Intrinsics | None = None,
    sensor: str | None = None,
    seed: int = 0,
    start: int = 0,
) -> Iterator[MovingFrame]:
    """Film the room.

    Parameters
    ----------
    n_frames : int
        How many frames, at 30 a second.
    camera : Intrinsics, optional
        The colour camera, with its size; by default 320 x 240 pixels.
    sensor : {"tof", "kinect", "stereo"}, optional
        What measures the depth; exact depth if not given.
    seed : int
        The source of chance of the noise.
    start : int
        The first frame.

    Yields
    ------
    MovingFrame

    Raises
    ------
    GeohueError
        For an unknown sensor or a camera without a size.
    """
    camera = camera or Intrinsics(262.5, 262.5, 159.5, 119.5, 320, 240)
    if sensor is not None and sensor not in SENSORS:
        raise GeohueError(f"sensor {sensor!r}: choose one of {', '.join(SENSORS)}")
    if camera.width is None or camera.height is None:
        raise GeohueError("the camera has no size: give its width and height")
    device = None if sensor is None else SENSORS[sensor]()
    for frame in range(start, start + n_frames):
        world, places = moving_world(frame)
        scene = measured(world, device, camera, seed + 1000 * frame)
        truth = render(world, camera, samples=1).labels
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = world.rotation, world.eye
        yield MovingFrame(scene, truth, pose, places)


def _centers(frame: float) -> dict[int, Vector]:
    """Where the three things are that move."""
    roll = frame % LENGTH
    share = float(np.clip((frame - _ENTERS) / (_ARRIVES - _ENTERS), 0, 1))
    return {
        MOVING: (-0.55 + 0.011 * roll, -0.13, 0.82),
        ENTERING: (1.2 - 0.62 * share, 0.0, 1.05),
        HIDDEN: (0.17 + _SPEED * (roll - _HIDES), -0.33, 1.6),
    }
