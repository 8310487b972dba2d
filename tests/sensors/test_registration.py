"""Registration: cases worked by hand, laws, and the real Xtion frames."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue import GeohueError, Intrinsics, Scene, segment
from geohue.read import read_color, read_depth
from geohue.read.cameras.rig import read_rig
from geohue.scene.registered import registered_scene
from geohue.sensors import Lens, PosedCamera, Rig, edge_agreement, register_depth, undistorted
from sensors.rigs import BENT, CAMERA, beside, rotation


def wall(depth: float = 2.0) -> NDArray[np.float32]:
    return np.full((80, 100), depth, np.float32)


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 1000), holes=st.floats(0, 0.6), bent=st.booleans())
def test_a_camera_sees_what_it_saw(seed: int, holes: float, bent: bool) -> None:
    rng = np.random.default_rng(seed)
    depth = rng.uniform(0.5, 5, (80, 100)).astype(np.float32)
    depth[rng.random(depth.shape) < holes] = np.nan
    lens = Lens(CAMERA, BENT if bent else ())
    seen = register_depth(depth, Rig((PosedCamera(lens),), lens))
    np.testing.assert_allclose(seen, depth, rtol=1e-6)


def test_a_wall_moves_by_f_b_over_z() -> None:
    # 100 px * 0.1 m / 2 m = 5 px to the left in the camera on the right
    depth = wall()
    depth[:, :50] = np.nan
    seen = register_depth(depth, beside(0.1))
    assert np.flatnonzero(np.isfinite(seen[40])).tolist() == list(range(45, 95))
    assert seen[np.isfinite(seen)] == pytest.approx(2.0)


def test_the_nearer_surface_hides_the_farther_one() -> None:
    # A post at 1 m in columns 50..59 moves by 10 px, the wall at 2 m by 5: the post covers the
    # wall's columns 45..54 (in its own view), and leaves a gap of 5 px on its right.
    depth = wall()
    depth[:, 50:60] = 1.0
    row = register_depth(depth, beside(0.1))[40]
    assert row[40:50] == pytest.approx(1.0)
    assert row[30:40] == pytest.approx(2.0)
    assert np.isnan(row[50:55]).all()
    assert row[55:95] == pytest.approx(2.0)


@pytest.mark.parametrize("scale", [0.5, 1, 2, 5])
@pytest.mark.parametrize("degrees", [0, 7])
def test_a_finer_view_has_no_grid_of_holes(scale: float, degrees: float) -> None:
    width, height = round(100 * scale), round(80 * scale)
    camera = CAMERA.scaled_to(width, height)
    turn = PosedCamera(Lens(camera), rotation(2, degrees), np.array([-0.02, 0, 0]))
    seen = register_depth(wall(), Rig((turn,), Lens(CAMERA)))
    inner = seen[height // 3 : 2 * height // 3, width // 3 : 2 * width // 3]
    assert inner == pytest.approx(2.0, rel=1e-5)


def test_a_slanted_plane_stays_a_plane() -> None:
    normal, offset = np.array([0.3, -0.2, 1.0]), 2.0
    rays = Lens(CAMERA).rays(80, 100)
    depth = (offset / (rays @ normal)).astype(np.float32)
    camera = PosedCamera(Lens(CAMERA), rotation(1, 4), np.array([-0.05, 0.01, 0.02]))
    seen = register_depth(depth, Rig((camera,), Lens(CAMERA)))
    points = (rays * seen[..., None] - camera.translation) @ camera.rotation
    known = np.isfinite(seen)
    error = points[known] @ normal - offset
    assert known.mean() > 0.8
    assert np.abs(error).max() < 0.004  # a third of a pixel on this slope
    assert np.sqrt((error**2).mean()) < 0.0015


def test_depth_of_another_size_and_no_depth_at_all() -> None:
    seen = register_depth(wall()[::2, ::2], beside(0.0), (100, 80))
    assert seen[10:70, 10:90] == pytest.approx(2.0)
    assert np.isnan(register_depth(np.zeros((80, 100)), beside(0.1))).all()


def test_registered_points_lie_on_the_rays_of_the_bent_lens() -> None:
    lens = Lens(CAMERA, BENT)
    rgb = np.zeros((80, 100, 3), np.uint8)
    scene = registered_scene(rgb, wall(), Rig((PosedCamera(lens),), lens))
    assert scene.points.reshape(-1, 3) == pytest.approx(2 * lens.rays(80, 100).reshape(-1, 3))


def test_undistorted_pictures_have_straight_lines() -> None:
    lens = Lens(CAMERA, BENT)
    rays = Lens(CAMERA).rays(80, 100).reshape(-1, 3)
    pixels = lens.project(rays).reshape(80, 100, 2)
    columns = np.clip(np.rint(pixels[..., 0]), 0, 99).astype(int)
    picture = np.tile(np.arange(100, dtype=np.uint8), (80, 1))
    straight = undistorted(picture, lens)
    inner = (slice(10, 70), slice(10, 90))
    assert np.abs(straight[inner].astype(int) - columns[inner]).max() <= 1
    assert undistorted(picture, Lens(CAMERA)) is picture


def test_refuses_what_does_not_fit() -> None:
    rig = beside(0.1)
    with pytest.raises(GeohueError, match="colour camera 1: the rig has 1"):
        register_depth(wall(), rig, camera=1)
    with pytest.raises(GeohueError, match="no size"):
        register_depth(wall(), beside(0.1, Intrinsics(100.0, 100.0, 50.0, 40.0)))
    with pytest.raises(GeohueError, match="no depth camera"):
        register_depth(wall(), Rig(rig.cameras))
    with pytest.raises(GeohueError, match="no rotation matrix"):
        PosedCamera(Lens(CAMERA), -np.eye(3))


def frames(data_dir: Path, cam: str) -> list[tuple[NDArray[np.uint8], NDArray[np.float32]]]:
    folder = data_dir / "ist_maizena2" / cam
    names = [f"{i:02d}" for i in (1, 5, 9)]
    return [
        (read_color(folder / f"{n}_rgb.png"), read_depth(folder / f"{n}_depth.png").depth)
        for n in names
    ]


@pytest.mark.parametrize(("cam", "gain", "score"), [("cam1", 1.15, 1.35), ("cam2", 1.6, 3.0)])
def test_real_frames_lie_clearly_better(
    data_dir: Path, cam: str, gain: float, score: float
) -> None:
    rig = read_rig(data_dir / "ist_maizena2" / "calibration.json")
    for rgb, depth in frames(data_dir, cam):
        raw, seen = edge_agreement(rgb, depth), edge_agreement(rgb, register_depth(depth, rig))
        assert seen > max(gain * raw, score)


def test_real_frame_is_segmented(data_dir: Path) -> None:
    rig = read_rig(data_dir / "ist_maizena2" / "calibration.json")
    rgb, depth = frames(data_dir, "cam2")[1]
    scene = registered_scene(rgb, depth, rig)
    seg = segment(scene, preset="fast", fill=False)
    assert isinstance(scene, Scene)
    assert seg.k >= 3
    # The yellow cloth and the white wall above it are two parts.
    assert seg.labels[280, 300] != seg.labels[40, 270]
