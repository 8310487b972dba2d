"""Whole runs over a cloud on disk: like in memory, whatever the pieces, and after a kill."""

from __future__ import annotations

import re
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import geohue
from geohue import GeohueError, Scene
from geohue.features import CUES
from geohue.jobs.lock import LOCK
from geohue.large import passes, segment_file, stages
from geohue.measures import adjusted_rand_index
from geohue.read.clouds.ply import read_ply
from large.clouds import N, table, three_blobs
from large.clouds import labels_of as _labels
from large.clouds import outcome_of as _outcome


@pytest.mark.parametrize("cues", CUES)
@pytest.mark.parametrize("k", [1, 3, "auto"])
def test_small_cloud_as_in_memory(cloud: Path, tmp_path: Path, cues: str, k: Any) -> None:
    rows = np.load(cloud)
    scene = Scene.from_cloud(rows[:, :3], rows[:, 3:].astype(np.uint8))
    whole = geohue.segment(scene, k, preset="paper", cues=cues)
    found = segment_file(cloud, tmp_path / "out", k, preset="paper", cues=cues, processes=1)
    assert found.levels is None
    assert not (tmp_path / "out" / "levels.npz").exists()
    np.testing.assert_array_equal(_labels(tmp_path / "out"), whole.labels)
    assert (found.k, found.weight) == (whole.k, whole.weight)
    assert found.sizes == tuple(np.bincount(whole.labels[whole.labels >= 0]))
    notes = [note for note in whole.warnings if cues != "color" or "coordinates" not in note]
    assert list(found.warnings) == notes  # by colour, points without a place have a label
    if whole.quality is not None:
        assert found.quality == pytest.approx(whole.quality, rel=1e-9)
    assert [w for w, _ in found.weight_curve] == [w for w, _ in whole.weight_curve]


@pytest.mark.parametrize("preset", ["paper", "fast"])
@pytest.mark.usefixtures("small_stretches")
def test_sample_stands_for_the_cloud(
    cloud: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, preset: str
) -> None:
    monkeypatch.setattr(stages, "SAMPLE", 600)
    found = segment_file(cloud, tmp_path / "out", 3, preset=preset, processes=1)
    labels = _labels(tmp_path / "out")
    _, _, truth = three_blobs(N)
    assert (labels == -1).sum() == 2
    assert labels[[5, 7000]].tolist() == [-1, -1]
    used = labels >= 0
    assert adjusted_rand_index(labels[used], truth[used]) > 0.99
    assert sum(found.sizes) == N - 2


@pytest.mark.usefixtures("small_stretches")
def test_neither_memory_nor_processes_change_the_result(cloud: Path, tmp_path: Path) -> None:
    ways: list[dict[str, Any]] = [
        {"processes": 1},
        {"memory": "500MB"},
        {"memory": "1.5GB", "processes": 2},
    ]
    for i, way in enumerate(ways):
        segment_file(cloud, tmp_path / str(i), 3, weight=1.0, **way)
    for i in range(1, len(ways)):
        np.testing.assert_array_equal(_labels(tmp_path / str(i)), _labels(tmp_path / "0"))
        assert _outcome(tmp_path / str(i)) == _outcome(tmp_path / "0")


@pytest.mark.usefixtures("small_stretches")
def test_segmented_ply(cloud: Path, tmp_path: Path) -> None:
    segment_file(cloud, tmp_path / "out", 3, weight=1.0, processes=1, formats=["ply"])
    rows, written = np.load(cloud), read_ply(tmp_path / "out" / "segmented.ply")
    np.testing.assert_array_equal(
        written.points, np.where(np.isnan(rows[:, :1]), np.nan, rows[:, :3])
    )
    np.testing.assert_array_equal(written.colors, rows[:, 3:].astype(np.uint8))
    np.testing.assert_array_equal(written.labels, _labels(tmp_path / "out"))


def test_files_of_a_run(cloud: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    seen: list[tuple[str, int, int]] = []
    found = segment_file(
        cloud, out, 3, preset="paper", processes=1, progress=lambda *step: seen.append(step)
    )
    names = ["labels.npy", "overlay.png", "result.json", "weight_curve.png"]
    assert sorted({file.name for file in out.iterdir()} - {LOCK}) == names
    assert _outcome(out)["sizes"] == list(found.sizes)
    assert np.load(found.labels_file, mmap_mode="r").dtype == np.int32
    assert {stage for stage, _, _ in seen} == {"measure", "fit", "label"}
    assert all((stage, N, N) in seen for stage in ("measure", "fit", "label"))
    segment_file(cloud, tmp_path / "given", 3, weight=1.0, processes=1)  # nothing searched
    given = {file.name for file in (tmp_path / "given").iterdir()} - {LOCK}
    assert sorted(given) == names[:3]


def test_blocks_without_any_coordinates_have_no_label(
    cloud: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(passes, "BLOCK", 500)
    rows = np.load(cloud)
    rows[500:1000, :3] = np.nan
    np.save(cloud, rows)
    result = segment_file(cloud, tmp_path / "out", 3, weight=1.0, processes=1)
    unknown = np.flatnonzero(_labels(tmp_path / "out") < 0)
    assert unknown.tolist() == np.flatnonzero(np.isnan(rows[:, :3]).any(axis=1)).tolist()
    assert sum(result.sizes) == len(rows) - len(unknown)


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="no /proc")
def test_memory_is_kept(tmp_path: Path) -> None:
    """The whole process, libraries and all, on a cloud of which every point is 24 bytes."""
    xyz, rgb, _ = three_blobs(1_300_000)
    np.save(tmp_path / "cloud.npy", table(xyz, rgb))
    options = f"-k 3 --memory 400MB -o {tmp_path / 'out'}".split()
    process = subprocess.Popen(
        [sys.executable, "-m", "geohue", "segment", str(tmp_path / "cloud.npy"), *options],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    status, peak = Path(f"/proc/{process.pid}/status"), 0
    while process.poll() is None:  # ru_maxrss would count what this process had before
        found = re.search(r"VmHWM:\s+(\d+) kB", status.read_text())
        peak = max(peak, int(found.group(1)) * 1024 if found else 0)
        time.sleep(0.02)
    assert process.returncode == 0
    assert 100e6 < peak < 400e6


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"memory": "100MB"}, "at least 380MB"),
        ({"processes": 0}, "processes is 0"),
        ({"k": 0}, "k is 0"),
        ({"cues": "smell"}, "smell"),
        ({"formats": ["pcd"]}, "choose ply, las, laz"),
        ({"preset": "slow"}, "slow"),
        ({"weight": "consensus"}, 'weight="consensus" needs the whole cloud in memory'),
        ({"detail": "finest"}, "detail is 'finest'"),
        ({"detail": "fine", "preset": "paper"}, "this preset has no levels"),
        ({"detail": "fine", "k": 3}, "give one of them"),
    ],
)
def test_bad_arguments(cloud: Path, tmp_path: Path, arguments: Any, says: str) -> None:
    with pytest.raises(GeohueError, match=says):
        segment_file(cloud, tmp_path / "out", **arguments)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        (np.full((9, 6), np.nan), "finite coordinates"),
        (np.ones((9, 3)), "no colours"),
        (np.ones((2, 6)), "2 usable"),
    ],
)
def test_clouds_without_anything_to_split(
    tmp_path: Path, rows: NDArray[np.float64], says: str
) -> None:
    np.save(tmp_path / "a.npy", rows)
    with pytest.raises(GeohueError, match=says):
        segment_file(tmp_path / "a.npy", tmp_path / "out", 3, processes=1)
