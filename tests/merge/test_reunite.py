"""Parts of one surface behind something: one name, and only then."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue import GeohueError, Intrinsics, Scene, segment
from geohue.cli.app import run as command
from geohue.merge.reunite import reunite
from geohue.results.png import write_png

H, W = 48, 72
CAMERA = Intrinsics(70.0, 70.0, W / 2, H / 2, W, H)
Depth = NDArray[np.float64]


def wall(tilt: float = 0.0, distance: float = 3.0) -> Depth:
    """Depth of a plane that turns away to the right: 1 / z is linear in the pixels."""
    u = (np.arange(W) - CAMERA.cx) / CAMERA.fx
    return np.broadcast_to(1 / (1 / distance + tilt * u), (H, W)).copy()


def post(depth: Depth, nearer: float = 0.7) -> tuple[Depth, NDArray[np.uint8], NDArray[np.int32]]:
    """A post before a wall, both with noise, and the three segments that one sees."""
    rng = np.random.default_rng(0)
    depth, rgb = depth.copy(), np.full((H, W, 3), (170, 165, 150), np.int64)
    depth[:, 30:38] *= nearer
    rgb[:, 30:38] = 140, 50, 40
    labels = np.repeat([0, 1, 2], [30, 8, W - 38])[None].repeat(H, 0).astype(np.int32)
    depth *= 1 + rng.normal(0, 0.002, depth.shape)
    colors = (rgb + rng.integers(-6, 7, rgb.shape)).astype(np.uint8)
    return depth, colors, labels


def count(depth: Depth, rgb: NDArray[np.uint8], labels: NDArray[np.int32]) -> int:
    return int(reunite(labels, Scene.from_rgbd(rgb, depth, CAMERA)).max()) + 1


@pytest.mark.parametrize("tilt", [0.0, 0.1, -0.25])
def test_a_wall_behind_a_post_is_one(tilt: float) -> None:
    depth, rgb, labels = post(wall(tilt))
    found = reunite(labels, Scene.from_rgbd(rgb, depth, CAMERA))
    np.testing.assert_array_equal(found, (labels == 1).astype(np.int32))


def test_a_round_column_behind_a_post_is_one() -> None:
    u = (np.arange(W) - CAMERA.cx) / W
    round_wall = np.broadcast_to(2.0 + 1.2 * u**2, (H, W))
    assert count(*post(round_wall)) == 2


def test_what_lies_behind_parts_a_wall() -> None:
    assert count(*post(wall(), nearer=1.4)) == 3


def test_what_lies_on_a_wall_parts_it() -> None:
    assert count(*post(wall(), nearer=1.0)) == 3


@pytest.mark.parametrize("step", [0.96, 1.04])
def test_two_walls_one_before_the_other(step: float) -> None:
    depth, rgb, labels = post(wall())
    depth[:, 38:] *= step
    assert count(depth, rgb, labels) == 3


def test_two_walls_that_meet_in_a_corner_behind_the_post() -> None:
    depth = np.minimum(wall(0.35), wall(-0.35))
    assert count(*post(depth)) == 3


def test_other_colours() -> None:
    depth, rgb, labels = post(wall())
    rgb[:, 38:] = 90, 110, 160
    assert count(depth, rgb, labels) == 3


def test_parts_that_touch_stay_two() -> None:
    """Whatever was said of them was said by the merging, which knew more."""
    depth, rgb, labels = post(wall())
    labels[0] = np.where(np.arange(W) < 34, 0, 2)
    assert count(depth, rgb, labels) == 3


def test_parts_of_one_surface_behind_two_posts() -> None:
    depth, rgb, labels = post(wall(0.1))
    depth[:, 50:56], rgb[:, 50:56] = depth[:, 50:56] * 0.6, (30, 60, 140)
    labels[:, 50:56], labels[:, 56:] = 3, 4
    found = reunite(labels, Scene.from_rgbd(rgb, depth, CAMERA))
    assert found[5, [2, 33, 45, 53, 60]].tolist() == [0, 1, 0, 2, 0]


@given(st.integers(0, 2**20))
@settings(deadline=None, max_examples=20)
def test_segments_only_become_one(seed: int) -> None:
    """Each segment stays whole, and points without one stay so, whatever the scene."""
    rng = np.random.default_rng(seed)
    labels = rng.integers(-1, 5, (6, 8)).repeat(6, 0).repeat(6, 1).astype(np.int32)
    depth = rng.uniform(1, 1.01 + rng.integers(2), labels.shape)
    depth[rng.random(labels.shape) < 0.2] = np.nan
    depth[0, 0] = 1
    scene = Scene.from_rgbd(np.full((*labels.shape, 3), 90, np.uint8), depth, CAMERA)
    found = reunite(labels, scene)
    np.testing.assert_array_equal(found < 0, labels < 0)
    for label in range(5):
        assert len(np.unique(found[labels == label])) <= 1


def test_segment_reunites_on_request(tmp_path: Path) -> None:
    depth, rgb, labels = post(wall(0.1))
    scene = Scene.from_rgbd(rgb, depth, CAMERA)
    apart, one = (segment(scene, preset="fast", reunite=wish) for wish in (False, True))
    assert (apart.k, one.k) == (3, 2)
    assert one.labels[5, 10] == one.labels[5, 60] != one.labels[5, 34]
    assert one.warnings[-1] == "3 segments are 2 surfaces: parts were reunited"
    assert one.levels is not None
    assert one.levels.count() == 3  # the levels know nothing of it
    write_png(tmp_path / "rgb.png", rgb)
    np.save(tmp_path / "depth.npy", depth)
    given = ["segment", str(tmp_path / "rgb.png"), str(tmp_path / "depth.npy"), "--reunite"]
    out = tmp_path / "out"
    assert command([*given, "--preset", "fast", "-o", str(out)]) == 0
    assert '"k": 2' in (out / "result.json").read_text()
    assert command([*given, "--memory", "2GB", "-o", str(out)]) == 2


@pytest.mark.parametrize(
    "scene",
    [
        Scene.from_cloud(np.random.default_rng(0).random((40, 3)), np.zeros((40, 3), np.uint8)),
        Scene.from_image(np.zeros((8, 9, 3), np.uint8)),
    ],
    ids=["cloud", "image"],
)
def test_without_a_camera_nothing_is_in_front(scene: Scene) -> None:
    with pytest.raises(GeohueError, match="reunite needs a frame with depth"):
        segment(scene, cues="color", preset="fast", reunite=True)
