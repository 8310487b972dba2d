"""What three kinds of depth sensor make of a scene: their errors, each from the literature.

Every sensor gives depth on the pixels of one colour camera, NaN where it has none, so that the
results can be compared pixel by pixel (Sec. VII).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from geohue.camera import Intrinsics
from geohue.scene import Scene
from geohue.simulate.shapes import Floats
from geohue.simulate.world import View, World, eye_of, pixel_grid, rays, render, trace

LIGHT_SPEED = 299_792_458.0


@dataclass(frozen=True, slots=True)
class TimeOfFlight:
    """A continuous-wave time-of-flight camera beside the colour camera (MESA SR4000).

    Each pixel gathers light from all it sees: it measures the phase of the sum of the waves, so
    that a pixel on an edge reports a depth between the two surfaces, a flying pixel (Keller and
    Kolb 2009). The noise of the phase grows as the light fades, with the square of the distance
    (Lange and Seitz 2001, eq. for the shot-noise limit). The low-resolution map is brought to the
    colour camera by linear interpolation, as the paper's trinocular setup does; both cameras
    stand in one place here, so that nothing is occluded.

    Attributes
    ----------
    columns : int
        Width of the sensor; 176 for the SR4000.
    frequency : float
        Modulation in Hz: distances repeat every ``c / (2 frequency)``, 5 m for 30 MHz.
    noise : float
        Standard deviation of the distance of a white surface facing the camera at 1 m, metres.
    samples : int
        Rays a pixel, across and down.

    References
    ----------
    R. Lange, P. Seitz, "Solid-state time-of-flight range camera", IEEE J. Quantum Electronics
    37(3), 2001. M. Keller, A. Kolb, "Real-time simulation of time-of-flight sensors", Simulation
    Modelling Practice and Theory 17(5), 2009.
    """

    columns: int = 176
    frequency: float = 30e6
    noise: float = 0.004
    samples: int = 5

    def depth(self, world: World, camera: Intrinsics, rng: np.random.Generator) -> Floats:
        """Measure the depth of each pixel of the colour camera, (H, W)."""
        assert camera.width is not None
        assert camera.height is not None
        rows = round(self.columns * camera.height / camera.width)
        small = camera.scaled_to(self.columns, rows)
        u, v = pixel_grid(small)
        eye = eye_of(world)
        wave = np.zeros(u.size, np.complex128)
        per_metre = 4 * np.pi * self.frequency / LIGHT_SPEED
        for dv in (np.arange(self.samples) + 0.5) / self.samples - 0.5:
            for du in (np.arange(self.samples) + 0.5) / self.samples - 0.5:
                directions = rays(small, u + du, v + dv, world)
                t, normals, _ = trace(world, eye, directions)
                length = np.linalg.norm(directions, axis=1)
                facing = np.abs(np.einsum("ij,ij->i", normals, directions)) / length
                seen = np.isfinite(t)
                distance = np.where(seen, t, 1.0) * length
                wave += np.where(seen, facing, 0) / distance**2 * np.exp(1j * per_metre * distance)
        strength = np.abs(wave) / self.samples**2
        distance = np.angle(wave) % (2 * np.pi) / per_metre
        with np.errstate(divide="ignore", invalid="ignore"):
            distance = distance + rng.normal(size=u.size) * self.noise / strength
        along = np.linalg.norm(rays(small, u, v, world), axis=1)
        low = np.where(strength > 0, distance / along, np.nan).reshape(u.shape)
        return _enlarged(low, camera)


@dataclass(frozen=True, slots=True)
class StructuredLight:
    """A projector of a dot pattern and an infrared camera beside it (Microsoft Kinect).

    The camera finds the shift of the pattern, the disparity ``f b / Z``, in steps of 1/8 pixel:
    steps of depth grow with the square of the distance, to 7 cm at 5 m (Khoshelham and Elberink
    2012). What the projector does not reach has no depth: a shadow on one side of near things.
    The correlation window moves edges by about half a pixel at random (lateral noise; Nguyen,
    Izadi and Lovell 2012), and slanted surfaces near 90 degrees return nothing. The factory
    calibration leaves the depth map a few pixels off the colours.

    Attributes
    ----------
    baseline : float
        From the projector to the camera, metres.
    focal : float
        Of the infrared camera at 640 columns, pixels.
    noise : float
        Standard deviation of the disparity, pixels.
    lateral : float
        Standard deviation of the place a disparity is taken from, pixels of the colour camera
        at 640 columns.
    offset : tuple of float
        Misregistration to the right and down, pixels of the colour camera at 640 columns.
    grazing : float
        Degrees between ray and normal beyond which nothing returns.

    References
    ----------
    K. Khoshelham, S. Oude Elberink, "Accuracy and resolution of Kinect depth data for indoor
    mapping applications", Sensors 12(2), 2012. C. Nguyen, S. Izadi, D. Lovell, "Modeling Kinect
    sensor noise for improved 3D reconstruction and tracking", 3DIMPVT 2012.
    """

    baseline: float = 0.075
    focal: float = 580.0
    noise: float = 0.08
    lateral: float = 0.8
    offset: tuple[float, float] = (3.0, 1.0)
    grazing: float = 82.0

    def depth(self, world: World, camera: Intrinsics, rng: np.random.Generator) -> Floats:
        """Measure the depth of each pixel of the colour camera, (H, W)."""
        assert camera.width is not None
        scale = camera.width / 640
        u, v = pixel_grid(camera)
        jitter = rng.normal(0, self.lateral * scale, (2, *u.shape))
        u = u + jitter[0] - self.offset[0] * scale
        v = v + jitter[1] - self.offset[1] * scale
        directions = rays(camera, u, v, world)
        eye = eye_of(world)
        t, normals, _ = trace(world, eye, directions)
        seen = np.isfinite(t) & self._lit(
            world, eye + directions * np.where(np.isfinite(t), t, 1.0)[:, None]
        )
        length = np.linalg.norm(directions, axis=1)
        facing = np.abs(np.einsum("ij,ij->i", normals, directions)) / length
        seen &= facing > np.cos(np.radians(self.grazing))
        disparity = self.focal * self.baseline / np.where(seen, t, 1.0)
        disparity = disparity + rng.normal(0, self.noise, t.size)
        steps = np.maximum(np.rint(8 * disparity), 1)
        depth = self.focal * self.baseline * 8 / steps
        return np.where(seen, depth, np.nan).reshape(u.shape)

    def _lit(self, world: World, points: Floats) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
        """Whether the projector's light reaches each point."""
        source = eye_of(world, self.baseline)
        t, _, _ = trace(world, source, points - source)
        return t > 1 - 1e-4


@dataclass(frozen=True, slots=True)
class Stereo:
    """Two colour cameras and the semi-global matcher of `geohue.stereo` (Hirschmueller 2008).

    Nothing is modelled but the cameras' noise: gaps and errors are the matcher's own, on what the
    other view does not see and where the texture is too weak to be matched.

    Attributes
    ----------
    baseline : float
        Metres.
    noise : float
        Standard deviation of the noise of both images, grey values.
    """

    baseline: float = 0.08
    noise: float = 3.0

    def depth(self, world: World, camera: Intrinsics, rng: np.random.Generator) -> Floats:
        """Measure the depth of each pixel of the left camera, (H, W)."""
        from geohue.stereo.matching import match

        left, right = (
            noisy(render(world, camera, shift), self.noise, rng).colors
            for shift in (0.0, self.baseline)
        )
        disparity = match(left, right).left.astype(np.float64)
        with np.errstate(divide="ignore", invalid="ignore"):
            depth = camera.fx * self.baseline / disparity
        return np.where(disparity > 0, depth, np.nan)


Sensor = TimeOfFlight | StructuredLight | Stereo

SENSORS: dict[str, Callable[[], Sensor]] = {
    "tof": TimeOfFlight,
    "kinect": StructuredLight,
    "stereo": Stereo,
}
"""The sensors by name, in the order of Table I."""


def noisy(view: View, deviation: float, rng: np.random.Generator) -> View:
    """Add the noise of a colour camera."""
    colors = view.colors + rng.normal(0, deviation, view.colors.shape)
    mended = np.clip(np.rint(colors), 0, 255).astype(np.uint8)
    return View(mended, view.depth, view.labels, view.cosine)


def measured(
    world: World, sensor: Sensor | None, camera: Intrinsics, seed: int = 0, noise: float = 3.0
) -> Scene:
    """See a world through a sensor.

    Parameters
    ----------
    world : World
    sensor : Sensor or None
        None: exact depth.
    camera : Intrinsics
        The colour camera, with its size.
    seed : int
        The source of chance.
    noise : float
        Of the colours, grey values.

    Returns
    -------
    Scene
    """
    rng = np.random.default_rng(seed)
    view = noisy(render(world, camera), noise, rng)
    depth = view.depth if sensor is None else sensor.depth(world, camera, rng)
    return Scene.from_rgbd(view.colors, depth, camera)


def _enlarged(low: Floats, camera: Intrinsics) -> Floats:
    """Interpolate a map of another size linearly at the pixels of a camera."""
    from scipy.ndimage import map_coordinates

    u, v = pixel_grid(camera)
    column = (u + 0.5) * low.shape[1] / u.shape[1] - 0.5
    row = (v + 0.5) * low.shape[0] / u.shape[0] - 0.5
    return np.asarray(map_coordinates(low, [row, column], order=1, mode="nearest"))
