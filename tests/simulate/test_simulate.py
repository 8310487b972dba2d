"""The simulator's laws: exact depth, exact labels, and each sensor's errors where they belong."""

from __future__ import annotations

import numpy as np
import pytest

from geohue.camera import Intrinsics
from geohue.errors import GeohueError
from geohue.measures import evaluate
from geohue.segmentation.driver import segment
from geohue.simulate import CAMERA, SENSORS, WORLDS, World, measured, render, scene
from geohue.simulate.materials import Material, grain
from geohue.simulate.sensors import Stereo, StructuredLight, TimeOfFlight
from geohue.simulate.shapes import Box, Cylinder, Plane, Sphere
from geohue.simulate.world import Solid, pixel_grid, trace

SMALL = Intrinsics(100.0, 110.0, 39.5, 29.5, 80, 60)
GREY = Material((128, 128, 128))
WALL = Plane((0, 0, 2), (0, 0, -1))


def world(*shapes: Plane | Sphere | Box | Cylinder, pitch: float = 0.0) -> World:
    return World(tuple(Solid(s, GREY, i) for i, s in enumerate(shapes)), pitch=pitch)


def step(near: float = 1.0, far: float = 2.0) -> World:
    """A near box that hides the left half of a far wall, edge at x = 0."""
    board = Box((-2, 0, near + 0.005), (4, 8, 0.01))
    return world(Plane((0, 0, far), (0, 0, -1)), board)


def test_plane_that_faces_the_camera_has_one_depth() -> None:
    view = render(world(WALL), SMALL)
    assert np.array_equal(view.depth, np.full((60, 80), 2.0))
    assert (view.labels == 0).all()
    # The angle to the normal is that to the optical axis.
    u, v = pixel_grid(SMALL)
    x, y = (u - 39.5) / 100, (v - 29.5) / 110
    assert np.allclose(view.cosine, 1 / np.sqrt(1 + x * x + y * y))


def test_ground_seen_from_above_has_the_depth_of_the_formula() -> None:
    ground = World((Solid(Plane((0, 0, 0), (0, -1, 0)), GREY, 0),), eye=(0, -0.75, 0), pitch=20)
    view = render(ground, SMALL)
    _, v = pixel_grid(SMALL)
    y, c, s = (v - 29.5) / 110, np.cos(np.radians(20)), np.sin(np.radians(20))
    fall = c * y + s  # how far a ray falls per metre along the axis
    expected = np.where(fall > 0, 0.75 / np.where(fall > 0, fall, 1), np.inf)
    assert np.allclose(view.depth, expected)
    assert np.array_equal(view.labels >= 0, fall > 0)


def test_sphere_covers_exactly_the_pixels_within_its_angle() -> None:
    view = render(world(WALL, Sphere((0.1, -0.05, 1.5), 0.3)), SMALL)
    u, v = pixel_grid(SMALL)
    rays = np.stack([(u - 39.5) / 100, (v - 29.5) / 110, np.ones_like(u)], axis=-1)
    center = np.array([0.1, -0.05, 1.5])
    cosine = rays @ center / np.linalg.norm(rays, axis=-1) / np.linalg.norm(center)
    inside = cosine > np.sqrt(1 - 0.3**2 / (center @ center))
    assert np.array_equal(view.labels == 1, inside)
    # Every visible point lies on the sphere.
    points = rays[inside] * view.depth[inside][:, None]
    assert np.allclose(np.linalg.norm(points - center, axis=1), 0.3)


def test_box_and_cylinder_by_hand() -> None:
    rays = np.array([[0.0, 0, 1], [0.0, 0.3, 1], [0.6, 0, 1]])
    t, normals = Box((0, 0, 2), (1, 1, 1)).hit(np.zeros(3), rays)
    assert t.tolist() == [1.5, 1.5, np.inf]
    assert normals[0].tolist() == [0, 0, -1]
    # Turned by 45 degrees an edge points to the camera.
    turned, _ = Box((0, 0, 2), (1, 1, 1), 45).hit(np.zeros(3), rays)
    assert turned[0] == pytest.approx(2 - np.sqrt(0.5))
    t, normals = Cylinder((0, 0.5, 2), 0.5, 1.0).hit(np.zeros(3), rays)
    assert t[:2].tolist() == pytest.approx([1.5, 1.5])
    assert normals[0].tolist() == [0, 0, -1]
    lid, up = Cylinder((0, 1, 2), 0.5, 0.4).hit(np.zeros(3), np.array([[0, 0.3, 1]]))
    assert (lid[0], up[0].tolist()) == (pytest.approx(2.0), [0, -1, 0])


def test_second_view_sees_each_point_at_its_disparity() -> None:
    made = WORLDS["balls"]()
    left, right = render(made, CAMERA), render(made, CAMERA, shift=0.08)
    u, v = pixel_grid(CAMERA)
    column = u - CAMERA.fx * 0.08 / left.depth
    near = np.rint(column).astype(int)
    inside = (near >= 0) & (np.abs(column - near) < 0.02)
    rows = v[inside].astype(int)
    agree = right.labels[rows, near[inside]] == left.labels[inside]
    assert agree.mean() > 0.93  # the rest is hidden from the right
    both = right.depth[rows, near[inside]][agree]
    assert np.median(np.abs(both - left.depth[inside][agree])) < 1e-3


def test_texture_stays_on_the_surface() -> None:
    points = np.random.default_rng(1).uniform(-2, 2, (500, 3))
    assert np.array_equal(grain(points, 0.05), grain(points.copy(), 0.05))
    assert 0.1 < grain(points, 0.05).std() < 0.5
    nearby = np.abs(grain(points + 1e-4, 0.05) - grain(points, 0.05))
    assert nearby.max() < 0.1


def test_time_of_flight_noise_grows_with_the_square_of_the_distance() -> None:
    camera = Intrinsics(800.0, 800.0, 79.5, 59.5, 160, 120)
    spreads = []
    for depth in (1.0, 2.0, 4.0):
        flat = world(Plane((0, 0, depth), (0, 0, -1)))
        found = TimeOfFlight(columns=160, samples=1).depth(flat, camera, np.random.default_rng(0))
        assert found.mean() == pytest.approx(depth, abs=0.002)
        spreads.append(float((found - depth).std()))
    assert np.array(spreads) / spreads[0] == pytest.approx([1, 4, 16], rel=0.05)
    assert spreads[0] == pytest.approx(0.004, rel=0.08)


def test_time_of_flight_has_flying_pixels_at_edges_and_no_gaps() -> None:
    exact = render(step(), SMALL).depth
    found = TimeOfFlight(columns=40, noise=0).depth(step(), SMALL, np.random.default_rng(0))
    flying = (found > 1.05) & (found < 1.95)
    columns = np.flatnonzero(flying.any(axis=0))
    assert np.isfinite(found).all()
    assert columns.size > 0
    assert np.abs(columns - 39.5).max() <= 4  # two pixels of the sensor
    away = np.abs(np.arange(80) - 39.5) > 5
    assert np.allclose(found[:, away], exact[:, away], atol=0.02)


def test_structured_light_shadow_is_as_wide_as_the_parallax() -> None:
    camera = Intrinsics(525.0, 525.0, 319.5, 29.5, 640, 60)
    plain = StructuredLight(noise=0, lateral=0, offset=(0, 0), grazing=89)
    # The projector is on the right: what hides the left of the wall lights all that is seen.
    mirrored = world(Plane((0, 0, 2), (0, 0, -1)), Box((2, 0, 1.005), (4, 8, 0.01)))
    gap = np.isnan(plain.depth(mirrored, camera, np.random.default_rng(0))).sum(axis=1)
    width = 525 * 0.075 * (1 / 1 - 1 / 2)
    assert np.abs(gap - width).max() <= 1
    assert not np.isnan(plain.depth(step(), camera, np.random.default_rng(0))).any()


def test_structured_light_depth_comes_in_steps() -> None:
    sensor = StructuredLight(lateral=0, offset=(0, 0))
    found = sensor.depth(world(Plane((0, 0, 4), (0, 0, -1))), SMALL, np.random.default_rng(0))
    levels = np.unique(found)
    steps = 580 * 0.075 * 8 / levels
    assert np.allclose(steps, np.rint(steps))
    assert len(levels) > 2
    # Z^2 / (8 f b) between neighbouring levels: 4.6 cm at 4 m.
    assert np.median(np.diff(levels)) == pytest.approx(16 / (8 * 580 * 0.075), rel=0.05)


def test_structured_light_is_off_by_its_offset() -> None:
    sensor = StructuredLight(noise=0, lateral=0, offset=(24, 0))  # at 640 columns
    found = sensor.depth(step(), SMALL, np.random.default_rng(0))
    edge = (found < 1.5).sum(axis=1) - (render(step(), SMALL).depth < 1.5).sum(axis=1)
    assert (edge == 3).all()


def test_stereo_finds_textured_depth_and_nothing_on_a_bare_wall() -> None:
    rich = World((Solid(WALL, Material((150, 150, 150), 0.8, 0.05), 0),))
    found = Stereo(noise=1).depth(rich, CAMERA, np.random.default_rng(0))
    assert np.isfinite(found).mean() > 0.8
    assert np.nanmedian(found) == pytest.approx(2, abs=0.03)
    matched, truth = scene("shelf", "stereo")
    assert matched.depth is not None
    gaps = np.isnan(matched.depth)
    assert gaps[truth == 1].mean() > 0.5 > 0.2 > gaps[truth == 0].mean()


@pytest.mark.parametrize("name", WORLDS)
def test_scene_has_all_its_segments_and_repeats(name: str) -> None:
    camera = CAMERA.scaled_to(160, 120)
    frame, truth = scene(name, camera=camera)
    assert np.unique(truth).tolist() == list(range(truth.max() + 1))
    assert np.bincount(truth.ravel()).min() > 200
    again, _ = scene(name, camera=camera)
    assert np.array_equal(frame.colors, again.colors)
    assert frame.valid.all()


def test_truth_is_found_where_both_cues_tell() -> None:
    frame, truth = scene("balls")
    found = segment(frame, int(truth.max()) + 1, threads=1)
    assert evaluate(found.labels, truth, ignore=None)["voi_bits"] < 0.1


def test_rays_miss_what_is_behind() -> None:
    t, _, solid = trace(world(Sphere((0, 0, -3), 1)), np.zeros(3), np.array([[0.0, 0, 1]]))
    assert (t[0], solid[0]) == (np.inf, -1)


def test_errors_name_the_choices() -> None:
    with pytest.raises(GeohueError, match="choose one of boxes, balls"):
        scene("kitchen")
    with pytest.raises(GeohueError, match="choose one of tof, kinect, stereo"):
        scene("boxes", "lidar")
    with pytest.raises(GeohueError, match="has no size"):
        scene("boxes", camera=Intrinsics(1, 1, 0, 0))
    assert list(SENSORS) == ["tof", "kinect", "stereo"]


def test_exact_depth_has_no_sensor() -> None:
    made = measured(world(WALL), None, SMALL)
    assert made.depth is not None
    assert np.array_equal(made.depth, np.full((60, 80), 2.0, np.float32))
