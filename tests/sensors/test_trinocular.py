"""Colours for range points: what each camera sees, occlusions, and the real set-ups."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue import GeohueError, Intrinsics, Scene, segment
from geohue.fill.unseen import label_unseen
from geohue.read import read_color
from geohue.read.cameras.rig import read_rig
from geohue.read.images.raw_depth import read_range
from geohue.read.scenes.ranges import read_range_scene
from geohue.sensors import Lens, PosedCamera, Rig, color_range_points
from sensors.rigs import CAMERA, rotation

RED, BLUE, GREEN = (200, 40, 40), (40, 40, 200), (30, 180, 60)


def plain(color: tuple[int, int, int], height: int = 80, width: int = 100) -> NDArray[np.uint8]:
    return np.full((height, width, 3), color, np.uint8)


def two_cameras(shift: float = 0.1, depth: bool = True) -> Rig:
    """One camera on either side of the sensor."""
    cameras = tuple(
        PosedCamera(Lens(CAMERA), np.eye(3), np.array([s, 0, 0]), n)
        for s, n in ((shift, "left"), (-shift, "right"))
    )
    return Rig(cameras, Lens(CAMERA) if depth else None)


def post() -> NDArray[np.float32]:
    """A wall at 2 m with a post at 1 m in columns 45 to 54."""
    depth = np.full((80, 100), 2.0, np.float32)
    depth[:, 45:55] = 1.0
    return depth


def test_each_camera_misses_what_the_post_hides() -> None:
    # The left camera sees the post 10 px to the right of where the sensor does, the wall 5 px:
    # the post hides the wall's columns 50 + 55 - 50 = 55 .. 59 from it, and 40 .. 44 from the
    # right camera.
    rig = two_cameras()
    found = color_range_points(rig.points(post()), [plain(RED), plain(BLUE)], rig)
    row = found.seen_by[40]
    assert row[55:60].tolist() == [2] * 5
    assert row[40:45].tolist() == [1] * 5
    assert (row[45:55] == 3).all()
    assert (row[10:40] == 3).all()


def test_the_first_camera_that_sees_a_point_gives_its_colour() -> None:
    rig = two_cameras()
    points = rig.points(post())
    found = color_range_points(points, [plain(RED), plain(BLUE)], rig)
    # The tones of one plain picture cannot be fitted but by their mean, which makes blue red.
    assert found.colors[40, 20].tolist() == list(RED)
    assert found.colors[40, 57].tolist() == list(RED)
    assert found.second_colors is not None
    assert found.second_colors[40, 20].tolist() == list(BLUE)
    assert found.second_colors[40, 42].tolist() == list(BLUE)


def test_tones_of_the_second_camera_are_brought_to_the_first() -> None:
    rng = np.random.default_rng(0)
    rig = two_cameras(0.0)  # both cameras at the sensor: they see the same
    image = rng.integers(60, 160, (80, 100, 3)).astype(np.uint8)
    darker = (image * 0.5 + 10).astype(np.uint8)
    blind = image.copy()
    points = rig.points(np.full((80, 100), 2.0, np.float32))
    blend = color_range_points(points, [blind, darker], rig, "blend")
    assert np.abs(blend.colors.astype(int) - image).max() <= 2


def test_colours_are_those_of_the_pixels() -> None:
    rng = np.random.default_rng(1)
    image = rng.integers(0, 256, (80, 100, 3)).astype(np.uint8)
    rig = Rig((PosedCamera(Lens(CAMERA)),), Lens(CAMERA))
    scene = Scene.from_range_and_cameras(np.full((80, 100), 2.0), [image], rig)
    assert np.array_equal(scene.colors, image)
    assert scene.second_colors is None
    assert scene.unseen is not None
    assert not scene.unseen.any()
    assert scene.depth is not None


def test_a_fine_picture_is_averaged_over_a_points_area() -> None:
    rng = np.random.default_rng(2)
    coarse = rng.integers(0, 256, (80, 100, 3)).astype(np.uint8)
    fine = coarse.repeat(4, axis=0).repeat(4, axis=1)
    speckled = fine.copy()
    speckled[::4, ::4] = 0
    camera = CAMERA.scaled_to(400, 320)
    rig = Rig((PosedCamera(Lens(camera)),), Lens(CAMERA))
    points = rig.points(np.full((80, 100), 2.0, np.float32))
    found = color_range_points(points, [speckled], rig)
    assert np.abs(found.colors[5:-5, 5:-5] - coarse[5:-5, 5:-5] * (15 / 16)).max() < 3


def test_points_in_nobodys_view_keep_geometry_and_take_the_nearest_label() -> None:
    # The camera looks at the left half only.
    narrow = Intrinsics(100.0, 100.0, 49.5, 39.5, 50, 80)
    rig = Rig((PosedCamera(Lens(narrow)),), Lens(CAMERA))
    scene = Scene.from_range_and_cameras(post(), [plain(GREEN, 80, 50)], rig)
    assert scene.unseen is not None
    assert scene.unseen[40].tolist() == [False] * 50 + [True] * 50
    assert np.isfinite(scene.points).all()
    assert not scene.valid[:, 50:].any()
    labels = np.where(scene.valid, np.where(post() < 1.5, 1, 0), -1).astype(np.int32)
    full = label_unseen(labels, scene)
    assert (full[:, :50] == labels[:, :50]).all()
    assert (full[:, 50:53] == 1).all()  # on the post
    assert full[40, 99] == -1  # far from everything labelled
    assert (scene.colors[:, 50:] == GREEN).all()


@given(gaps=st.lists(st.floats(0.01, 0.09), min_size=1, max_size=8))
def test_labels_of_the_unseen_reach_no_farther_at_a_second_call(gaps: list[float]) -> None:
    # Two labelled points 1 m apart, then unseen ones, each near the one before: reach is 0.05 m.
    places = np.concatenate([[0.0, 1.0], 1.0 + np.cumsum(gaps)])
    points = np.zeros((len(places), 3), np.float32)
    points[:, 0] = places
    unseen = np.arange(len(places)) >= 2
    scene = Scene(np.zeros((len(places), 3), np.uint8), points, unseen=unseen)
    labels = np.full(len(places), -1, np.int32)
    labels[:2] = 0, 1
    once = label_unseen(labels, scene)
    near = points[:, 0] - 1 < 0.05
    assert once[2:].tolist() == np.where(near[2:], 1, -1).tolist()
    assert np.array_equal(label_unseen(once, scene), once)


def scan() -> NDArray[np.float32]:
    """A scanner's view of a wall at 4 m with a post at 2 m before it; x forward, z up."""
    azimuth, elevation = np.meshgrid(
        np.radians(np.arange(-20, 20.1, 0.4)), np.radians(np.arange(-10, 10.1, 0.8))
    )
    distance = np.where(np.abs(azimuth) < np.radians(3), 2.0, 4.0) / np.cos(azimuth)
    forward = distance * np.cos(azimuth)
    left = -distance * np.sin(azimuth)
    return np.stack([forward, left, distance * np.tan(elevation)], -1).reshape(-1, 3).astype("f4")


def test_scattered_points_hide_each_other_too() -> None:
    points = scan()
    R = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0]], np.float64)  # to x right, y down, z forward
    beside = PosedCamera(Lens(CAMERA), R, np.array([0.5, 0, 0]))  # half a metre to the left
    found = color_range_points(points, [plain(RED)], Rig((beside,)))
    azimuth = np.degrees(np.arctan2(-points[:, 1], points[:, 0]))
    there = beside.transform(points)
    place = beside.lens.project(there)
    inside = (place >= 0).all(axis=1) & (place[:, 0] <= 99) & (place[:, 1] <= 79)
    # From there the post covers the wall's x from -0.105 * 2 + 0.5 to 0.105 * 2 + 0.5.
    wall = points[:, 0] > 3
    x = -points[:, 1]
    hidden = inside & wall & (x > 0.35) & (x < 0.62)
    clear = inside & wall & ((x < 0.15) | (x > 0.9))
    assert hidden.sum() > 30
    assert (found.seen_by[hidden] == 0).mean() > 0.95
    assert (found.seen_by[clear] == 1).mean() > 0.97
    assert (found.seen_by[inside & (np.abs(azimuth) < 2.5)] == 1).all()


def test_nothing_depends_on_the_order_of_the_points() -> None:
    points = scan()
    order = np.random.default_rng(3).permutation(len(points))
    R = np.array([[0, -1, 0], [0, 0, -1], [1, 0, 0]], np.float64)
    rig = Rig((PosedCamera(Lens(CAMERA), R @ rotation(2, 1), np.array([0.2, 0, 0])),))
    image = np.random.default_rng(4).integers(0, 256, (80, 100, 3)).astype(np.uint8)
    one = Scene.from_range_and_cameras(points, [image], rig)
    two = Scene.from_range_and_cameras(points[order], [image], rig)
    assert one.unseen is not None
    assert two.unseen is not None
    assert np.array_equal(one.unseen[order], two.unseen)
    seen = ~two.unseen
    assert np.array_equal(one.colors[order][seen], two.colors[seen])


def test_refuses_what_does_not_fit() -> None:
    rig = two_cameras()
    with pytest.raises(GeohueError, match="3 picture"):
        Scene.from_range_and_cameras(post(), [plain(RED)] * 3, rig)
    with pytest.raises(GeohueError, match="no camera sees any"):
        Scene.from_range_and_cameras([[0.0, 0.0, -1.0]], [plain(RED)], two_cameras(depth=False))
    with pytest.raises(GeohueError, match="points have shape"):
        Scene.from_range_and_cameras(np.zeros((2, 2, 2)), [plain(RED)], rig)
    with pytest.raises(GeohueError, match="choose one of first, blend"):
        Scene.from_range_and_cameras(post(), [plain(RED)], rig, choice="best")  # type: ignore[arg-type]


def test_herrera_kinect_with_two_cameras(data_dir: Path) -> None:
    folder = data_dir / "herrera_kinect_2rgb"
    rig = read_rig(folder / "calibration.json")
    depth = read_range(folder / "0026-d.pgm", rig).depth
    images = [read_color(folder / f"0026-c{n}.jpg") for n in (1, 2)]
    found = color_range_points(rig.points(depth), images, rig)
    known = np.isfinite(depth)
    assert (found.seen_by[known] > 0).mean() > 0.98
    both = found.seen_by == 3
    assert both[known].mean() > 0.35
    # Both see the same things: their brightness goes together.
    assert found.second_colors is not None
    grey = [c[both].mean(axis=1) for c in (found.colors, found.second_colors)]
    assert np.corrcoef(*grey)[0, 1] > 0.95
    scene = read_range_scene(
        folder / "0026-d.pgm",
        [folder / f"0026-c{n}.jpg" for n in (1, 2)],
        [folder / "calibration.json"],
    )
    assert scene.shape == (480, 640)
    seg = segment(scene, preset="fast", fill=False)
    assert seg.k >= 3
    assert seg.labels[100, 60] != seg.labels[280, 300]  # shelf far behind, board


def test_kitti_lidar_with_two_cameras(data_dir: Path) -> None:
    folder = data_dir / "kitti_stereo_lidar" / "demo"
    images = [folder / "left.png", folder / "right.png"]
    scene = read_range_scene(folder / "lidar.bin", images, [folder / "calib.txt"])
    assert scene.shape == (103344,)
    assert scene.second_colors is not None
    assert 16_000 < scene.valid.sum() < 18_500  # of the 17.8 thousand in the left picture
    difference = np.abs(scene.colors.astype(int) - scene.second_colors)[scene.valid]
    assert difference.mean() < 16  # against 36 at 20 px beside the mark
    seg = segment(scene, preset="fast")
    assert seg.k >= 2
    assert (seg.labels[scene.valid] >= 0).all()
    assert scene.unseen is not None
    assert (seg.labels[scene.unseen] >= 0).any()  # labelled by the nearest seen point
    assert (seg.labels[scene.unseen] < 0).any()  # behind the scanner
    assert np.array_equal(label_unseen(seg.labels, scene), seg.labels)
