"""Stereo pairs and calibration on the command line."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from geohue.cli.app import run
from geohue.read.cameras.rig import read_rig
from geohue.read.cameras.stereo_calibration import read_stereo_calibration

SHIFT = 8


@pytest.fixture
def pair(tmp_path: Path) -> tuple[str, str, str]:
    """A textured pair 8 pixels apart, with a nearer square 16 pixels apart; and its disparity."""
    rng = np.random.default_rng(0)
    wide = cv2.GaussianBlur(rng.integers(0, 256, (80, 140, 3)).astype(np.uint8), (0, 0), 1.0)
    left, right = wide[:, : 140 - SHIFT].copy(), wide[:, SHIFT:].copy()
    disparity = np.full(left.shape[:2], SHIFT, np.uint8)
    square = np.clip(rng.normal(200, 20, (30, 30, 3)), 0, 255).astype(np.uint8)
    left[20:50, 60:90] = square
    right[20:50, 60 - 2 * SHIFT : 90 - 2 * SHIFT] = square
    disparity[20:50, 60:90] = 2 * SHIFT
    names = [str(tmp_path / f"{n}.png") for n in ("left", "right", "disparity")]
    for name, image in zip(names, (left, right, 4 * disparity), strict=True):
        assert cv2.imwrite(name, image)
    return names[0], names[1], names[2]


def result_of(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> dict[str, object]:
    assert run(arguments) == 0
    result = json.loads(capsys.readouterr().out)
    assert isinstance(result, dict)
    return result


def test_a_pair_with_and_without_its_disparity(
    pair: tuple[str, str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    left, right, disparity = pair
    common = ["segment", left, "--right", right, "-k", "2", "--json", "--calib", "100,0.1"]
    given = [*common, "--disparity", disparity, "--disparity-scale", "1/4"]
    result = result_of([*given, "-o", str(tmp_path / "a")], capsys)
    labels = cv2.imread(str(tmp_path / "a" / "labels.png"), cv2.IMREAD_UNCHANGED)
    assert labels is not None
    assert set(labels[22:48, 62:88].ravel()) == {2}
    assert result["n_labelled"] == result["n_points"]
    assert result_of(common, capsys)["k"] == 2
    assert result_of([*given, "--views", "1"], capsys)["k"] == 2


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--disparity", "d.png"], "give --right too"),
        (["--calib", "500,0.1"], "give --right or --camera too"),
        (["depth.png", "--right", "r.png"], "leave out DEPTH"),
        (["--right", "r.png", "--depth-scale", "tum"], "leave out --depth-scale"),
        (["--camera", "c.png"], "needs the rig"),
        (["--right", "missing.png"], "missing.png: no such file"),
    ],
)
def test_mistakes(
    options: list[str],
    message: str,
    pair: tuple[str, str, str],
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(["segment", pair[0], *options]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert message in lines[0]


def test_exchanged_images_and_lost_scales(
    pair: tuple[str, str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    left, right, _ = pair
    assert run(["segment", right, "--right", left]) == 2
    assert "exchange" in capsys.readouterr().err
    assert run(["segment", left, "--right", right, "--disparity-scale", "2"]) == 2
    assert "--disparity-scale has no disparity to scale" in capsys.readouterr().err


def test_calibrate_writes_what_segment_reads(
    data_dir: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = data_dir / "opencv_samples"
    numbers = ("01", "03", "05", "07", "09", "12")
    pictures = [str(folder / f"{side}{n}.jpg") for side in ("left", "right") for n in numbers]
    out = tmp_path / "out"
    report = result_of(["calibrate", *pictures, "-o", str(out), "--json"], capsys)
    error = report["reprojection_error_px"]
    assert isinstance(error, float)
    assert error < 0.5
    assert read_stereo_calibration(out / "stereo.yml").baseline == report["baseline"]
    assert (out / "rectified.png").exists()


def test_calibrate_mistakes(
    pair: tuple[str, str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = ["-o", str(tmp_path / "out")]
    for arguments, message in (
        (list(pair), "as many right ones as left ones"),
        ([*pair[:2], "--pattern", "nine"], "such as 9x6"),
        ([*pair[:2]], "at least 3"),
    ):
        assert run(["calibrate", *arguments, *out]) == 2
        assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_calibrate_a_depth_sensor_and_a_camera(
    data_dir: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = data_dir / "opencv_samples"
    numbers = ("01", "03", "05", "07", "09", "12")
    pictures = [str(folder / f"{side}{n}.jpg") for side in ("left", "right") for n in numbers]
    out = ["--rig", "--square", "0.03", "-o", str(tmp_path), "--json"]
    report = result_of(["calibrate", *pictures, *out], capsys)
    error = report["reprojection_error_px"]
    assert isinstance(error, float)
    assert error < 0.5
    rig = read_rig(tmp_path / "calibration.json")
    assert np.linalg.norm(rig.cameras[0].translation) == pytest.approx(0.1, abs=0.01)
