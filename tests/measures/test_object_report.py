"""Object measures from `evaluate`, from folders and from the command line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geohue.cli.app import run as command
from geohue.measures import ObjectProtocol, evaluate
from geohue.results.png import write_png
from geohue.studies.benchmark.folders import evaluate_folders

TABLE = ObjectProtocol(background=(1,))

# The table 1, an object 2 cut in two, and one without a segment of its own.
GT = np.array([[1, 1, 1, 2, 2, 2, 2, 2, 1, 1, 3, 1, 1]], np.uint16)
PRED = np.array([[4, 4, 4, 5, 5, 5, 6, 6, 4, 4, 4, 4, 4]], np.uint16)


@pytest.fixture
def files(tmp_path: Path) -> tuple[str, str]:
    write_png(tmp_path / "pred" / "a.png", PRED)
    write_png(tmp_path / "pred" / "b.png", GT)
    for name in ("a", "b"):
        write_png(tmp_path / "gt" / name / "labels.png", GT)
    return str(tmp_path / "pred"), str(tmp_path / "gt")


def test_keys_are_added() -> None:
    plain, found = evaluate(PRED, GT), evaluate(PRED, GT, objects=TABLE)
    assert {name: found[name] for name in plain} == plain
    assert set(found) - set(plain) == {
        "objects_precision",
        "objects_recall",
        "objects_f",
        "objects_detected",
        "objects_boundary_precision",
        "objects_boundary_recall",
        "objects_boundary_f",
        "n_objects_pred",
        "n_objects_gt",
    }
    assert found["objects_precision"] == 3 / 5
    assert found["objects_recall"] == 3 / 6
    assert found["objects_detected"] == 1 / 2  # F of the larger piece is 6 / 8
    assert (found["n_objects_pred"], found["n_objects_gt"]) == (2, 2)
    # Outlines of 5 at 2, 4 and of 6 at 4, 7; of the objects at 2, 7 and at 9, 10. 5 is paired.
    assert found["objects_boundary_precision"] == 1 / 4
    assert found["objects_boundary_recall"] == 1 / 4
    cloud = evaluate(PRED[0], GT[0], objects=TABLE)
    assert not any(name.startswith("objects_boundary") for name in cloud)
    assert cloud["objects_f"] == found["objects_f"]


def test_crop() -> None:
    found = evaluate(PRED, GT, crop=(0, 1, 0, 6), objects=TABLE)
    assert (found["objects_precision"], found["objects_recall"]) == (1, 1)


def test_folders(files: tuple[str, str]) -> None:
    found = evaluate_folders(*files, objects=TABLE)
    assert found["frames"]["b"]["objects_f"] == 1
    assert found["mean"]["objects_recall"] == (3 / 6 + 1) / 2


def test_command(files: tuple[str, str], capsys: pytest.CaptureFixture[str]) -> None:
    def told(*options: str) -> dict[str, Any]:
        assert command(["evaluate", *files, "--json", *options]) == 0
        scores: dict[str, Any] = json.loads(capsys.readouterr().out)["frames"]["a"]
        return scores

    assert "objects_f" not in told()
    assert told("--objects", "--background", "1")["objects_recall"] == 3 / 6
    assert told("--objects", "--background", "1,3")["objects_recall"] == 3 / 5
    assert told("--objects")["n_objects_gt"] == 3
    own = told("--objects", "--background", "1", "--background-from", "prediction")
    assert own["objects_precision"] == 4 / 13  # the table's segment is paired with object 3
    one = [f"{files[0]}/a.png", f"{files[1]}/a/labels.png"]
    assert command(["evaluate", *one, "--objects", "--background", "1"]) == 0
    assert "objects f                  0.5455" in capsys.readouterr().out


def test_refusals(files: tuple[str, str], capsys: pytest.CaptureFixture[str]) -> None:
    refused = {
        "belong to --objects": ["--background", "1"],
        "choose among truth": ["--objects", "--background-from", "guess"],
        "with commas": ["--objects", "--background", "table"],
    }
    for message, options in refused.items():
        assert command(["evaluate", *files, *options]) == 2
        assert message in capsys.readouterr().err
