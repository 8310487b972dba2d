"""Range sensors with cameras, data sets and further outputs on the command line."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from geohue.cli.app import run


def test_a_kinect_and_two_cameras(
    data_dir: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = data_dir / "herrera_kinect_2rgb"
    arguments = ["segment", str(folder / "0000-d.pgm"), "--calib", str(folder / "calibration.json")]
    for name in ("0000-c1.jpg", "0000-c2.jpg"):
        arguments += ["--camera", str(folder / name)]
    extra = ["--preset", "fast", "--format", "segments", "--format", "coco", "--format", "pcd"]
    assert run([*arguments, *extra, "-o", str(tmp_path), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["n_labelled"] > 0.95 * result["n_points"]
    names = {file.name for file in tmp_path.iterdir()}
    assert {"labels.png", "segments.png", "coco.json", "segmented.pcd"} <= names


def test_a_scan_and_two_cameras(
    data_dir: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = data_dir / "kitti_stereo_lidar" / "demo"
    arguments = ["segment", str(folder / "lidar.bin"), "--calib", str(folder / "calib.txt")]
    for name in ("left.png", "right.png"):
        arguments += ["--camera", str(folder / name)]
    assert run([*arguments, "-k", "6", "-o", str(tmp_path), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    labels = np.load(tmp_path / "labels.npy")
    assert result["n_labelled"] == (labels >= 0).sum() > 10_000


def test_a_frame_of_a_data_set(data_dir: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = str(data_dir / "sevenscenes")
    assert run(["segment", source, "--frame", "5", "--preset", "fast", "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["n_labelled"] == result["n_points"] == 307_200
    assert run(["segment", source, "--frame", "500"]) == 2
    assert "counted from 0; --frame is 500" in capsys.readouterr().err


def test_unknown_format(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    color, depth = tmp_path / "c.png", tmp_path / "d.png"
    cv2.imwrite(str(color), np.zeros((20, 30, 3), np.uint8))
    cv2.imwrite(str(depth), np.full((20, 30), 1000, np.uint16))
    out = ["-o", str(tmp_path / "out"), "--format", "obj"]
    assert run(["segment", str(color), str(depth), "-k", "1", *out]) == 2
    assert "ply, pcd, las, laz, coco, segments" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_lens_distortion_left_out_is_a_line_of_the_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("rgb", "depth"):
        (tmp_path / name).mkdir()
    color = np.random.default_rng(0).integers(0, 255, (20, 30, 3)).astype(np.uint8)
    cv2.imwrite(str(tmp_path / "rgb" / "0.png"), color)
    cv2.imwrite(str(tmp_path / "depth" / "0.png"), np.full((20, 30), 1000, np.uint16))
    camera = tmp_path / "camera.json"
    camera.write_text('{"fx": 30, "fy": 30, "cx": 15, "cy": 10, "dist_coeffs": [0.1, 0, 0, 0, 0]}')
    for command in (["segment", "-k", "2", "-o", str(tmp_path / "out")], ["info"]):
        name, *more = command
        assert run([name, str(tmp_path), *more, "--intrinsics", str(camera)]) == 0
        lines = capsys.readouterr().err.splitlines()
        assert any(line.startswith("geohue: warning:") and "distortion" in line for line in lines)
