"""``geohue compare``: its files, its progress, and one line for every mistake."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from geohue import Scene
from geohue.cli.app import run
from geohue.studies.compare import run as module
from studies.compare import _faults

Frame = tuple[str, str, str]


@pytest.fixture
def frame(tmp_path: Path, three_boxes: tuple[Scene, NDArray[np.int32]]) -> Frame:
    """Colour, depth and true labels as files."""
    scene, truth = three_boxes
    assert scene.depth is not None
    names = [str(tmp_path / f"{name}.png") for name in ("rgb", "depth", "truth")]
    cv2.imwrite(names[0], scene.colors[..., ::-1])
    cv2.imwrite(names[1], (scene.depth * 1000).round().astype(np.uint16))
    cv2.imwrite(names[2], (truth + 1).astype(np.uint8))
    return names[0], names[1], names[2]


def test_files_and_progress(
    frame: Frame, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    chosen = ["--methods", "nncsc,edison", "--cues", "fusion, color", "-k", "3"]
    options = ["--gt", frame[2], "--processes", "1", "-o", str(out), "--json"]
    assert run(["compare", *frame[:2], *chosen, *options]) == 0
    captured = capsys.readouterr()
    printed = json.loads(captured.out)
    assert printed == json.loads((out / "compare.json").read_text())
    assert [cell["status"] for cell in printed["cells"]] == ["done", "done", "undefined", "done"]
    assert printed["cells"][0]["rand"] > 0.99
    made = sorted(file.name for file in out.iterdir())
    assert made == ["compare.csv", "compare.html", "compare.json", "labels", "plate.png"]
    lines = captured.err.splitlines()
    assert [line for line in lines if "/3 " in line] == [
        "geohue: 1/3 nncsc-fusion done",
        "geohue: 2/3 nncsc-color done",
        "geohue: 3/3 edison-color done",
    ]
    assert any(line.startswith("geohue: warning: no intrinsics given") for line in lines)


def test_a_failure_is_a_warning(
    frame: Frame,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(module, "run_cell", _faults.faulty_cell)
    chosen = ["--methods", "nncsc,kmeans", "--cues", "color", "-k", "3", "--processes", "1"]
    assert run(["compare", *frame[:2], *chosen, "-o", str(tmp_path / "out")]) == 1
    captured = capsys.readouterr()
    assert (
        "geohue: warning: kmeans-color failed: RuntimeError: <b>no & luck</b>"
        in captured.err.splitlines()
    )
    rows = captured.out.splitlines()
    assert rows[0].split() == ["method", "cues", "regions", "time", "(s)", "weight", "Q"]
    assert rows[1].split()[:3] == ["nncsc", "color", "3"]
    assert rows[2].split() == ["kmeans", "color", "failed"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--methods", "magic"], "methods 'magic': choose among best, fast, nncsc, kmeans"),
        (["--methods", ","], "no methods given"),
        (["--cues", "depth"], "--cues depth: choose one of fusion, color, geometry"),
        (["--methods", "edison", "--cues", "fusion"], "not defined for --cues"),
        (["-k", "few"], '-k few: expected "auto" or a whole number'),
        (["-k", "0"], "-k 0"),
        (["--seed", "-1"], "--seed -1: expected a whole number of at least 0"),
        (["--preset", "ultra"], "paper, fast, best"),
        (["--processes", "0"], "--processes 0"),
        (["--timeout", "-1"], "timeout is -1"),
        (["--gt", "none.png"], "none.png: no such file"),
        (["--gt", "small.png"], "ground truth has shape (5, 5)"),
        (["--gt", "rgb.png"], "no label image"),
        (["--gt", "real.npy"], "no labels; labels are whole numbers"),
        (["--sample", "motorcycle"], "choose one"),
        (["--wrong"], "--wrong"),
    ],
)
def test_mistakes(
    options: list[str],
    message: str,
    frame: Frame,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    cv2.imwrite("small.png", np.ones((5, 5), np.uint16))
    np.save("real.npy", np.ones((60, 90)))
    assert message in line_of(["compare", *frame[:2], *options, "-o", "out"], capsys)
    assert not Path("out").exists()


def test_nothing_to_compare(capsys: pytest.CaptureFixture[str]) -> None:
    assert "no scene" in line_of(["compare"], capsys)


def test_all_methods_fail(
    frame: Frame,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(module, "run_cell", _faults.always_fails)
    chosen = ["--methods", "nncsc", "--cues", "color", "-k", "4", "-o", str(tmp_path / "out")]
    assert run(["compare", *frame[:2], *chosen]) == 2
    last = capsys.readouterr().err.splitlines()[-1]
    assert last.startswith("geohue: error: every method failed; nncsc-color: ValueError: ")
    assert last.endswith("with K 4")
    assert not (tmp_path / "out").exists()


def line_of(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """Run a command that must fail; returns its one line."""
    assert run(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    lines = captured.err.splitlines()
    assert len(lines) == 1, captured.err
    assert lines[0].startswith("geohue: error: ")
    return lines[0]
