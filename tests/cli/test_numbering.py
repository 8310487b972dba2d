"""`evaluate` and `compare` read every file of a result in its own numbering."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from geohue import GeohueError, Scene, Segmentation
from geohue.cli.app import run
from geohue.read.labels import read_segments
from geohue.results.outputs import write_results

LABELS = np.repeat(np.arange(-1, 5, dtype=np.int32), 20).reshape(10, 12)


def _write(folder: Path, labels: np.ndarray[tuple[int, ...], np.dtype[np.int32]]) -> Path:
    """A cloud (organised, where the labels are a grid) with segments."""
    rng = np.random.default_rng(0)
    scene = Scene.from_cloud(rng.random((*labels.shape, 3)), np.zeros((*labels.shape, 3), np.uint8))
    k = int(labels.max()) + 1
    seg = Segmentation(labels, k, 1.0, None, [], "nncsc", "paper", "fusion", 0, {})
    write_results(folder, scene, seg)
    return folder


def test_every_file_of_a_result_is_equal_to_itself(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    grid, flat = _write(tmp_path / "grid", LABELS), _write(tmp_path / "flat", LABELS.ravel())
    pairs = [
        (grid / "labels.png", grid / "labels.npy"),
        (grid / "labels.npy", grid / "labels.png"),
        (grid, grid / "labels.png"),  # the folder stands for the labels in it
        (flat / "labels.npy", flat / "segmented.ply"),
        (flat, flat / "labels.npy"),
    ]
    for pred, gt in pairs:
        assert run(["evaluate", str(pred), str(gt), "--json"]) == 0
        scores = json.loads(capsys.readouterr().out)
        assert scores["voi_bits"] == 0
        # 20 pixels have no label in the reference, and are left out.
        assert (scores["n_pred"], scores["n_gt"], scores["n_pixels"]) == (5, 5, 100)


def test_folders_of_clouds_are_measured(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _write(tmp_path / "pred" / "a", LABELS.ravel())
    _write(tmp_path / "gt" / "a", LABELS.ravel())
    assert run(["evaluate", str(tmp_path / "pred"), str(tmp_path / "gt"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["mean"]["n_pixels"] == 100


def test_more_segments_than_16_bits_tell_apart(tmp_path: Path) -> None:
    labels = np.arange(-1, 2**16, dtype=np.int32)[None]
    most = np.minimum(labels, 2**16 - 2)
    assert not (_write(tmp_path / "more", labels) / "labels.png").exists()
    assert (_write(tmp_path / "most", most) / "labels.png").exists()
    for name, written in (("more", labels), ("most", most)):
        loaded = Segmentation.load(tmp_path / name)
        np.testing.assert_array_equal(loaded.labels, written)
    told = json.loads((tmp_path / "more" / "result.json").read_text())["numbering"]
    assert told["labels.npy"] == {"none": -1, "first": 0}


@pytest.mark.parametrize(
    ("array", "says"),
    [
        (np.zeros((2, 2)), "holds float64"),
        (np.zeros((2, 2, 3), np.int32), "no labels"),
        (np.array([-2, 0]), "labels from -2 to 0"),
        (np.array([2**31]), "expected -1 or more"),
    ],
)
def test_arrays_that_are_no_labels(
    tmp_path: Path, array: np.ndarray[tuple[int, ...], np.dtype[np.generic]], says: str
) -> None:
    np.save(tmp_path / "a.npy", array)
    with pytest.raises(GeohueError, match=says):
        read_segments(tmp_path / "a.npy")
