"""Solids with materials and labels, and what a pinhole camera sees of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics
from geohue.simulate.materials import Material
from geohue.simulate.shapes import Floats, Shape, Vector

AMBIENT = 0.55
"""Share of the light that comes from everywhere."""


@dataclass(frozen=True, slots=True)
class Solid:
    """A shape of one material that belongs to a segment; several may share one label."""

    shape: Shape
    material: Material
    label: int


@dataclass(frozen=True, slots=True)
class World:
    """Solids and where the viewer stands.

    Attributes
    ----------
    solids : tuple of Solid
    eye : tuple of float
        Position of the camera.
    pitch : float
        Degrees by which it looks down.
    light : tuple of float
        Direction towards the light.
    """

    solids: tuple[Solid, ...]
    eye: Vector = (0.0, 0.0, 0.0)
    pitch: float = 0.0
    light: Vector = (-0.4, -0.8, -0.45)

    @property
    def rotation(self) -> Floats:
        """Turns directions of the camera's frame into the world's."""
        c, s = np.cos(np.radians(self.pitch)), np.sin(np.radians(self.pitch))
        return np.array([[1, 0, 0], [0, c, s], [0, -s, c]])


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """What a camera sees, without any error.

    Attributes
    ----------
    colors : (H, W, 3) uint8
    depth : (H, W) float64
        Metres along the optical axis; infinity where there is nothing.
    labels : (H, W) int32
        Segments from 0; -1 where there is nothing.
    cosine : (H, W) float64
        Of the angle between the surface's normal and the ray.
    """

    colors: NDArray[np.uint8]
    depth: Floats
    labels: NDArray[np.int32]
    cosine: Floats


def trace(
    world: World, origin: Floats, directions: Floats
) -> tuple[Floats, Floats, NDArray[np.int64]]:
    """Follow rays to the first solid.

    Parameters
    ----------
    world : World
    origin : (3,) or (M, 3) float
    directions : (M, 3) float
        Of any length, in the world's frame.

    Returns
    -------
    t : (M,) float64
        Distance in units of the direction; infinity for a miss.
    normals : (M, 3) float64
    solid : (M,) int64
        Index of the solid, -1 for a miss.
    """
    t = np.full(len(directions), np.inf)
    normals = np.zeros(directions.shape)
    solid = np.full(len(directions), -1)
    for i, thing in enumerate(world.solids):
        distance, normal = thing.shape.hit(origin, directions)
        nearer = distance < t
        t = np.where(nearer, distance, t)
        normals = np.where(nearer[:, None], normal, normals)
        solid[nearer] = i
    return t, normals, solid


def rays(camera: Intrinsics, u: Floats, v: Floats, world: World) -> Floats:
    """Return the ray of each pixel, of length 1 along the optical axis, in the world's frame."""
    x, y = (u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy
    return np.asarray(np.stack([x, y, np.ones_like(x)], axis=-1).reshape(-1, 3) @ world.rotation.T)


def pixel_grid(camera: Intrinsics) -> tuple[Floats, Floats]:
    """Return columns and rows of the pixel centres, (H, W) each."""
    assert camera.width is not None
    assert camera.height is not None
    return np.meshgrid(np.arange(camera.width) * 1.0, np.arange(camera.height) * 1.0)


def eye_of(world: World, shift: float = 0.0) -> Floats:
    """Return the position of a camera `shift` metres to the right of the viewer."""
    return np.array(world.eye, np.float64) + shift * world.rotation[:, 0]


def render(world: World, camera: Intrinsics, shift: float = 0.0, samples: int = 2) -> View:
    """Render what a camera sees.

    Parameters
    ----------
    world : World
    camera : Intrinsics
        With its size.
    shift : float
        Metres to the right of the viewer.
    samples : int
        Colours are the mean of so many times so many rays a pixel; depth and labels are those of
        the ray through its centre.

    Returns
    -------
    View
    """
    u, v = pixel_grid(camera)
    eye = eye_of(world, shift)
    directions = rays(camera, u, v, world)
    t, normals, solid = trace(world, eye, directions)
    labels = np.array([s.label for s in world.solids] + [-1], np.int32)[solid]
    length = np.linalg.norm(directions, axis=1)
    cosine = np.abs(np.einsum("ij,ij->i", normals, directions)) / length
    colors = np.zeros((u.size, 3))
    offsets = (np.arange(samples) + 0.5) / samples - 0.5
    for dv in offsets:
        for du in offsets:
            colors += _shaded(world, eye, rays(camera, u + du, v + dv, world))
    mean = np.clip(np.rint(colors / samples**2), 0, 255).astype(np.uint8)
    shape = u.shape
    return View(
        mean.reshape(*shape, 3), t.reshape(shape), labels.reshape(shape), cosine.reshape(shape)
    )


def _shaded(world: World, eye: Floats, directions: Floats) -> Floats:
    """Colours along rays: material under an even and a directed light, without shadows."""
    t, normals, solid = trace(world, eye, directions)
    points = eye + directions * np.where(np.isfinite(t), t, 0)[:, None]
    colors = np.zeros(points.shape)
    for i, thing in enumerate(world.solids):
        mine = solid == i
        if mine.any():
            colors[mine] = thing.material.colors(points[mine])
    light = np.array(world.light) / np.linalg.norm(world.light)
    shade = AMBIENT + (1 - AMBIENT) * np.maximum(normals @ light, 0)
    return np.asarray(colors * shade[:, None])
