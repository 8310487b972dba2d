"""Merged regions of a cloud in pieces: as in memory, whatever the pieces, with the same levels."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import geohue
from geohue import Scene
from geohue.cli.app import run as command
from geohue.features import CUES
from geohue.large import passes, segment_file, stages
from geohue.large.levels import plan_regions, write_levels
from geohue.large.passes import label
from geohue.measures import adjusted_rand_index
from geohue.merge.levels import Levels
from geohue.merge.tree import MergeTree
from geohue.read import read_levels
from geohue.results.levels import write_levels as write_whole
from large.clouds import table, three_blobs

FAST = geohue.PRESETS["fast"].changed(draft_points=900, counts=(3, 5))


def _scene(file: Path) -> Scene:
    rows = np.load(file)
    return Scene.from_cloud(rows[:, :3], rows[:, 3:].astype(np.uint8))


@pytest.fixture
def cloud(tmp_path: Path) -> Path:
    """Three balls far from zero, some points twice and two without a place."""
    xyz, rgb, _ = three_blobs(4000)
    xyz[[5, 700]] = np.nan
    xyz[1000:1200], rgb[1000:1200] = xyz[1200:1400], rgb[1200:1400]
    np.save(tmp_path / "cloud.npy", table(xyz + np.float32(9000), rgb))
    return tmp_path / "cloud.npy"


@pytest.mark.parametrize("cues", CUES)
@pytest.mark.parametrize(
    "wish", [{}, {"k": 3}, {"detail": "fine"}, {"detail": 4.5}, {"k": 40}], ids=str
)
def test_a_cloud_no_larger_than_the_sample_is_split_as_in_memory(
    cloud: Path, tmp_path: Path, cues: str, wish: dict[str, Any]
) -> None:
    whole = geohue.segment(_scene(cloud), preset=FAST, cues=cues, **wish)
    found = segment_file(cloud, tmp_path / "out", preset=FAST, cues=cues, processes=1, **wish)
    labels = np.load(found.labels_file)
    np.testing.assert_array_equal(labels, whole.labels)
    assert found.sizes == tuple(np.bincount(labels[labels >= 0]))
    assert whole.levels is not None
    levels = read_levels(tmp_path / "out" / "levels.npz")
    np.testing.assert_array_equal(levels.regions, whole.levels.regions)
    np.testing.assert_array_equal(levels.tree.merges, whole.levels.tree.merges)
    np.testing.assert_array_equal(levels.tree.scores, whole.levels.tree.scores)
    told, expected = found.summary(), whole.summary()
    for name in ("k", "weight", "detail", "levels", "warnings", "cues", "n_labelled"):
        assert told[name] == expected[name], name


def test_neither_stretches_nor_blocks_change_the_labels_or_levels(
    cloud: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stages, "SAMPLE", 1500)
    outs = tmp_path / "a", tmp_path / "b"
    segment_file(cloud, outs[0], preset=FAST, detail="fine", processes=1)
    monkeypatch.setattr(stages, "JOB", 900)
    monkeypatch.setattr(passes, "BLOCK", 350)
    segment_file(cloud, outs[1], preset=FAST, detail="fine", processes=1)
    labels, again = (np.load(out / "labels.npy") for out in outs)
    np.testing.assert_array_equal(labels, again)
    levels, same = (read_levels(out / "levels.npz") for out in outs)
    np.testing.assert_array_equal(levels.regions, same.regions)
    fine = levels.at("fine")
    np.testing.assert_array_equal(fine < 0, labels < 0)
    assert adjusted_rand_index(fine[labels >= 0], labels[labels >= 0]) == 1.0
    told = json.loads((outs[0] / "result.json").read_text())
    assert told["levels"]["n"] == len(levels)
    assert told["levels"]["segments"] == [
        [d, levels.count(d)] for d, _ in told["levels"]["segments"]
    ]
    assert told["k"] == levels.count("fine")


def test_a_run_stopped_while_labelling_ends_with_the_same_levels(
    cloud: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stages, "JOB", 1000)

    def fail_once(job: passes.LabelJob) -> list[int]:
        if job.start == 2000:
            raise OSError("a hiccup")
        return label(job)

    with monkeypatch.context() as patch:
        patch.setattr(stages, "label", fail_once)
        with pytest.raises(geohue.GeohueError, match="1 of 4 stretches"):
            segment_file(cloud, tmp_path / "out", preset=FAST, processes=1)
    assert not (tmp_path / "out" / "levels.npz").exists()
    with monkeypatch.context() as patch:
        patch.setattr(stages, "fit", None)  # nothing is fitted again
        segment_file(cloud, tmp_path / "out", preset=FAST, processes=1, resume=True)
    segment_file(cloud, tmp_path / "whole", preset=FAST, processes=1)
    for name in ("levels.npz", "labels.npy"):
        assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()
    assert not (tmp_path / "out" / "state").exists()


def test_another_detail_keeps_what_was_measured(
    cloud: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_: passes.LabelJob) -> list[int]:
        raise OSError("disk full")

    with monkeypatch.context() as patch:
        patch.setattr(stages, "label", fail)
        with pytest.raises(geohue.GeohueError, match="stretches failed"):
            segment_file(cloud, tmp_path / "out", preset=FAST, processes=1)
    monkeypatch.setattr(stages, "measure", None)  # nothing is measured again
    found = segment_file(cloud, tmp_path / "out", preset=FAST, detail=6.0, processes=1, resume=True)
    assert found.k == geohue.segment(_scene(cloud), preset=FAST, detail=6.0).k > 3


def test_regions_without_a_point_are_left_out_of_the_levels(tmp_path: Path) -> None:
    regions: NDArray[np.int32] = np.array([0, 2, -1, 2, 3, 0], np.int32)
    tree = MergeTree(4, np.array([[1, 2], [0, 1], [0, 3]]), np.array([-2.0, -1.0, 1.0]))
    ((target, _),) = plan_regions(tmp_path).values()
    target.path.write_bytes(regions.tobytes())
    kept = write_levels(tmp_path / "a.npz", target, 6, np.array([2, 0, 2, 1]), tree)
    assert kept.merges.tolist() == [[0, 1], [0, 2]]
    found = read_levels(tmp_path / "a.npz")
    assert found.regions.tolist() == [0, 1, -1, 1, 2, 0]
    write_whole(tmp_path / "b.npz", Levels(found.regions, kept))
    with np.load(tmp_path / "a.npz") as ours, np.load(tmp_path / "b.npz") as whole:
        assert set(ours) == set(whole)
        for name in whole:
            np.testing.assert_array_equal(ours[name], whole[name])
            assert ours[name].dtype == whole[name].dtype


def test_the_command(cloud: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = ["segment", str(cloud), "--processes", "1", "--preset", "fast", "-o"]
    assert command([*given, str(tmp_path / "out"), "--detail", "fine"]) == 0
    told = capsys.readouterr().out
    assert "regions merged" in told
    assert "levels.npz" in told
    assert json.loads((tmp_path / "out" / "result.json").read_text())["detail"] == "fine"
    assert command([*given, str(tmp_path / "no"), "--detail", "fine", "-k", "3"]) == 2
    assert command([*given, str(tmp_path / "no"), "--detail", "fine", "--lambda", "1"]) == 2
    assert not (tmp_path / "no").exists()
