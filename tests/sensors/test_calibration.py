"""Checkerboards: rendered ones with known cameras, and OpenCV's stereo set."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from geohue import GeohueError
from geohue.read import read_color
from geohue.read.cameras.rig import read_rig
from geohue.results.rig import write_rig
from geohue.sensors.calibration import calibrate_rig
from geohue.stereo.calibrate import find_corners
from sensors.boards import FIRST, PATTERN, SECOND, SQUARE, poses, seen


def test_finds_the_cameras_that_rendered_the_boards(tmp_path: Path) -> None:
    pairs = [(seen(FIRST, *pose), seen(SECOND, *pose)) for pose in poses()]
    found = calibrate_rig([a for a, _ in pairs], [b for _, b in pairs], PATTERN, SQUARE)
    assert len(found.used) >= 6
    assert max(found.rms) < 0.2
    assert found.rig.depth_lens.camera.fx == pytest.approx(300, rel=0.01)
    camera = found.rig.cameras[0]
    assert camera.lens.camera.fx == pytest.approx(330, rel=0.01)
    assert camera.translation == pytest.approx(SECOND.translation, abs=0.002)
    assert camera.rotation == pytest.approx(SECOND.rotation, abs=0.01)
    write_rig(tmp_path / "rig.json", found.rig)
    again = read_rig(tmp_path / "rig.json")
    assert again.depth == found.rig.depth
    assert again.cameras[0].rotation == pytest.approx(camera.rotation)


def test_opencvs_stereo_set(data_dir: Path) -> None:
    folder = data_dir / "opencv_samples"
    numbers = [i for i in range(1, 15) if i != 10]
    sides = [
        [read_color(folder / f"{side}{i:02d}.jpg") for i in numbers] for side in ("left", "right")
    ]
    found = calibrate_rig(sides[0], sides[1], (9, 6), 1.0)
    assert len(found.used) == 13
    assert max(found.rms) < 0.25
    # intrinsics.yml and OpenCV's documentation: f = 535 px, 3.3 squares between the cameras
    assert found.rig.depth_lens.camera.fx == pytest.approx(534.8, rel=0.005)
    assert found.rig.cameras[0].translation[0] == pytest.approx(-3.33, abs=0.02)


def test_refuses_too_little() -> None:
    blank = np.zeros((60, 80), np.uint8)
    assert find_corners(blank, PATTERN) is None
    with pytest.raises(GeohueError, match="0 of 3 pairs"):
        calibrate_rig([blank] * 3, [blank] * 3, PATTERN, SQUARE)
    with pytest.raises(GeohueError, match="pairs are needed"):
        calibrate_rig([blank], [blank] * 3, PATTERN, SQUARE)
    with pytest.raises(GeohueError, match="no checkerboard"):
        calibrate_rig([blank], [blank], (1, 5), SQUARE)
