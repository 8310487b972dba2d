"""Folders of stereo pairs, and labels brought back to the raw left view."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from geohue import GeohueError, Intrinsics, Scene
from geohue.cli.app import run
from geohue.datasets import open_dataset
from geohue.results import write_png
from geohue.stereo import StereoRig

RNG = np.random.default_rng(0)


def make(folder: Path, frames: int = 2) -> Path:
    for number in range(frames):
        wide = cv2.GaussianBlur(RNG.integers(0, 256, (60, 100, 3)).astype(np.uint8), (0, 0), 1.0)
        write_png(folder / "left" / f"{number}.png", wide[:, :92].copy())
        write_png(folder / "right" / f"{number}.png", wide[:, 8:].copy())
    return folder


def test_a_batch_of_pairs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder, out = make(tmp_path / "in"), tmp_path / "out"
    given = ["batch", str(folder), "-o", str(out), "--calib", "100,0.1", "-k", "2"]
    assert run([*given, "--processes", "1", "--preset", "fast"]) == 0
    assert cv2.imread(str(out / "0" / "labels.png"), -1).shape == (60, 92)  # type: ignore[union-attr]
    assert (out / "1" / "disparity.png").exists()
    capsys.readouterr()
    assert run(["info", str(folder), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["layout"], facts["n_frames"], facts["frame_kind"]) == ("stereo", 2, "stereo pair")
    left, right = (str(folder / side / "0.png") for side in ("left", "right"))
    assert run(["info", left, "--right", right, "--calib", "100,0.1", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["baseline_m"] == 0.1
    assert facts["disparity_px"][1] == pytest.approx(8, abs=0.5)
    assert facts["rectified_here"] is False


def test_sides_that_do_not_match(tmp_path: Path) -> None:
    folder = make(tmp_path, 3)
    (folder / "right" / "2.png").unlink()
    data = open_dataset(folder)
    assert len(data) == 2
    assert "3 left and 2 right picture(s), of which 2 have the same name" in data.notes[0]
    (folder / "calib.txt").write_text("100, 0.1")
    assert open_dataset(folder)[0].stereo is not None
    for file in (folder / "right").iterdir():
        file.rename(file.with_name(f"r{file.name}"))
    with pytest.raises(GeohueError, match="3 left and 2 right"):
        open_dataset(folder)


def test_labels_return_to_the_raw_view() -> None:
    noise = RNG.integers(0, 256, (90, 120, 3)).astype(np.uint8)
    image = np.asarray(cv2.GaussianBlur(noise, (0, 0), 1.5), np.uint8)
    camera = Intrinsics(100.0, 100.0, 59.5, 44.5, 120, 90)
    turn = np.asarray(cv2.Rodrigues(np.array([0.0, 0.0, 0.05]))[0], np.float64)
    rig = StereoRig(
        camera, camera, left_distortion=(-0.1, 0.0, 0.0, 0.0), rotation=turn,
        translation=np.array([-0.1, 0.0, 0.0]),
    )  # fmt: skip
    turned, _, _ = rig.rectify(image, image)
    there = rig.left_map(120, 90)
    back = cv2.remap(turned, there, None, cv2.INTER_LINEAR)  # type: ignore[call-overload]
    inside = (slice(15, -15),) * 2
    errors = [np.abs(view[inside].astype(int) - image[inside]).mean() for view in (back, turned)]
    assert 2 * errors[0] < errors[1]
    pair = Scene.from_stereo(image, image, rig, np.full((90, 120), 5.0)).pair
    assert pair is not None
    assert pair.unrectified is not None
    labels = np.arange(90 * 120).reshape(90, 120) % 7
    x, y = np.rint(there[40, 50]).astype(int)
    assert pair.to_original(labels, -1)[40, 50] == labels[y, x]
