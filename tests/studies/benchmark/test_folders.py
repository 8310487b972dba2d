"""Folders of labels against folders of labels."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from geohue.cli.app import run as command
from geohue.errors import GeohueError
from geohue.results.png import write_png
from geohue.studies.benchmark.folders import evaluate_folders, label_files

HALVES = np.array([[1, 1, 2, 2]], np.uint16)
QUARTERED = np.array([[1, 2, 3, 3]], np.uint16)


@pytest.fixture
def folders(tmp_path: Path) -> tuple[Path, Path]:
    pred, gt = tmp_path / "pred", tmp_path / "gt"
    write_png(pred / "a.png", HALVES)
    write_png(pred / "b" / "labels.png", QUARTERED)
    for name in ("a", "b", "c"):
        write_png(gt / name / "labels.png", HALVES)
    return pred, gt


def test_mean_and_frames(folders: tuple[Path, Path]) -> None:
    found = evaluate_folders(*folders)
    # b splits half of the pixels in two: half a bit.
    assert [found["frames"][name]["voi_bits"] for name in ("a", "b")] == [0, 0.5]
    assert found["mean"]["voi_bits"] == 0.25
    assert found["mean"]["covering"] == (1 + 0.75) / 2
    assert found["missing"] == ["c"]


def test_crop(folders: tuple[Path, Path]) -> None:
    assert evaluate_folders(*folders, crop=(0, 1, 2, 4))["mean"]["voi_bits"] == 0


def test_errors_name_the_frame(folders: tuple[Path, Path], tmp_path: Path) -> None:
    pred, gt = folders
    write_png(pred / "b" / "labels.png", np.ones((2, 2), np.uint16))
    with pytest.raises(GeohueError, match=r"^frame b: "):
        evaluate_folders(pred, gt)
    write_png(pred / "d.png", HALVES)
    with pytest.raises(GeohueError, match="such as d are not in"):
        evaluate_folders(pred, gt)
    (tmp_path / "empty").mkdir()
    with pytest.raises(GeohueError, match="has no label images"):
        label_files(tmp_path / "empty")


def test_command(folders: tuple[Path, Path], capsys: pytest.CaptureFixture[str]) -> None:
    pred, gt = folders
    assert command(["evaluate", str(pred), str(gt), "--json"]) == 0
    told = capsys.readouterr()
    assert json.loads(told.out)["mean"]["voi_bits"] == 0.25
    assert "1 reference frame(s) without a segmentation, such as c" in told.err
    assert command(["evaluate", str(pred), str(gt)]) == 0
    shown = capsys.readouterr().out
    assert "mean of 2 frame(s)" in shown
    assert command(["evaluate", str(pred), str(gt / "a" / "labels.png")]) == 2
    assert "give a folder of results" in capsys.readouterr().err
    assert command(["evaluate", str(pred / "a.png"), str(gt / "a" / "labels.png")]) == 0
