"""Six kinds of new user bring their first files; each scene is simulated or ships with geohue."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

import geohue
from geohue import Scene
from geohue.cli.app import run
from geohue.results import write_ply, write_png

FAST = ("--preset", "fast")


@pytest.fixture(scope="module")
def boxes() -> Scene:
    return geohue.load_sample("boxes")


def numbers_of(scene: Scene) -> str:
    camera = scene.intrinsics
    assert camera is not None
    return f"{camera.fx},{camera.fy},{camera.cx},{camera.cy}"


def millimetres(scene: Scene) -> np.ndarray:
    assert scene.depth is not None
    return np.nan_to_num(scene.depth * 1000).round().astype(np.uint16)


def labels_in(folder: Path) -> np.ndarray:
    labels = cv2.imread(str(folder / "labels.png"), cv2.IMREAD_UNCHANGED)
    assert labels is not None
    return labels


def test_realsense(boxes: Scene, tmp_path: Path) -> None:
    """Depth aligned to the colour, at half its size; the far wall is not wanted."""
    color, depth, out = tmp_path / "color.png", tmp_path / "depth.png", tmp_path / "out"
    height, width = boxes.shape
    write_png(color, boxes.colors[: height // 2 * 2, : width // 2 * 2].copy())
    write_png(depth, millimetres(boxes)[: height // 2 * 2 : 2, : width // 2 * 2 : 2].copy())
    given = ["segment", str(color), str(depth), "--intrinsics", numbers_of(boxes), "-o", str(out)]
    assert run([*given, "--max-depth", "60", *FAST]) == 0
    assert labels_in(out).shape == (height // 2 * 2, width // 2 * 2)
    assert labels_in(out).max() > 1


def test_phone_lidar(boxes: Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A folder of an app: pictures, small depth maps, confidence."""
    height, width = (side // 4 * 4 for side in boxes.shape)
    depth = millimetres(boxes)[2:height:4, 2:width:4].copy()
    camera = boxes.intrinsics
    assert camera is not None
    K = [camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1]
    colors = boxes.colors[:height, :width]
    cv2.imwrite(str(tmp_path / "frame_00000.jpg"), colors[..., ::-1])
    (tmp_path / "frame_00000.json").write_text(json.dumps({"intrinsics": K}))
    write_png(tmp_path / "depth_00000.png", depth)
    write_png(tmp_path / "conf_00000.png", np.full(depth.shape, 2, np.uint8))
    out = tmp_path / "out"
    assert run(["segment", str(tmp_path), "-o", str(out), *FAST]) == 0
    assert labels_in(out).shape == (height, width)
    assert "scaled to its" in capsys.readouterr().err


def test_photogrammetry(boxes: Scene, tmp_path: Path) -> None:
    """A cloud in map coordinates, with a few points that are garbage."""
    points = boxes.points[boxes.valid][::7].astype(np.float64)
    points += np.array([500_000.0, 4_000_000.0, 100.0])
    points[3] = np.nan
    write_ply(tmp_path / "scan.ply", points, boxes.colors[boxes.valid][::7], np.zeros(len(points)))
    assert run(["segment", str(tmp_path / "scan.ply"), "-o", str(tmp_path / "out"), *FAST]) == 0
    labels = np.load(tmp_path / "out" / "labels.npy")
    assert labels[3] == -1
    assert labels.max() > 0


def test_arrays(boxes: Scene) -> None:
    """Floats, alpha and a matrix, as they come from a robot."""
    camera = boxes.intrinsics
    assert camera is not None
    K = np.array([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]])
    rgba = np.dstack([boxes.colors / 255, np.ones(boxes.shape)])
    scene = Scene.from_rgbd(rgba, millimetres(boxes)[..., None], K, 0.001)
    whole = Scene.from_rgbd(boxes.colors, millimetres(boxes), camera, 0.001)
    one, two = (geohue.segment(s, preset="fast").labels for s in (scene, whole))
    assert np.array_equal(one, two)
    assert geohue.evaluate(one, two + 1)["rand"] == 1.0


def test_stereo_camera(tmp_path: Path) -> None:
    """Folders of both cameras, all pairs in one go."""
    rng = np.random.default_rng(0)
    wide = cv2.GaussianBlur(rng.integers(0, 256, (60, 100, 3)).astype(np.uint8), (0, 0), 1.0)
    write_png(tmp_path / "in" / "left" / "0.png", wide[:, :92].copy())
    write_png(tmp_path / "in" / "right" / "0.png", wide[:, 8:].copy())
    out = tmp_path / "out"
    given = ["batch", str(tmp_path / "in"), "--calib", "100,0.1", "-o", str(out)]
    assert run([*given, "-k", "2", "--processes", "1", *FAST]) == 0
    assert labels_in(out / "0").shape == (60, 92)


def test_data_set(boxes: Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A folder of frames, segmented and compared with labels."""
    write_png(tmp_path / "in" / "rgb" / "a.png", boxes.colors)
    write_png(tmp_path / "in" / "depth" / "a.png", millimetres(boxes))
    out = tmp_path / "out"
    assert run(["batch", str(tmp_path / "in"), "-o", str(out), "--processes", "1", *FAST]) == 0
    capsys.readouterr()
    labels = str(out / "a" / "labels.png")
    assert run(["evaluate", labels, labels, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["rand"] == 1.0
