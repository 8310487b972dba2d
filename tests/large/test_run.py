"""Whole runs over a cloud on disk: like in memory, whatever the pieces, and after a kill."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import geohue
from geohue import GeohueError, Scene
from geohue.cli.app import run as command
from geohue.features import CUES
from geohue.jobs.lock import LOCK
from geohue.large import passes, segment_file, stages
from geohue.large.fit import fit
from geohue.large.passes import LabelJob, label
from geohue.large.state import State
from geohue.measures import adjusted_rand_index
from geohue.read.clouds.ply import read_ply
from large.clouds import table, three_blobs
from large.run_slowly import STRETCH

N = 12_000
SCRIPT = Path(__file__).with_name("run_slowly.py")


@pytest.fixture
def cloud(tmp_path: Path) -> Path:
    """Three balls, two of whose points have no place."""
    xyz, rgb, _ = three_blobs(N)
    xyz[[5, 7000]] = np.nan
    np.save(tmp_path / "cloud.npy", table(xyz, rgb))
    return tmp_path / "cloud.npy"


@pytest.fixture
def small_stretches(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stages, "JOB", STRETCH)


def _labels(out: Path) -> NDArray[np.int32]:
    return np.asarray(np.load(out / "labels.npy"))


def _outcome(out: Path) -> dict[str, Any]:
    """What a run found, without the time that it took."""
    content: dict[str, Any] = json.loads((out / "result.json").read_text())
    del content["timings_s"]
    return content


@pytest.mark.parametrize("cues", CUES)
@pytest.mark.parametrize("k", [1, 3, "auto"])
def test_small_cloud_as_in_memory(cloud: Path, tmp_path: Path, cues: str, k: Any) -> None:
    rows = np.load(cloud)
    scene = Scene.from_cloud(rows[:, :3], rows[:, 3:].astype(np.uint8))
    whole = geohue.segment(scene, k, preset="paper", cues=cues)
    found = segment_file(cloud, tmp_path / "out", k, cues=cues, processes=1)
    np.testing.assert_array_equal(_labels(tmp_path / "out"), whole.labels)
    assert (found.k, found.weight) == (whole.k, whole.weight)
    assert found.sizes == tuple(np.bincount(whole.labels[whole.labels >= 0]))
    assert found.warnings == whole.warnings
    if whole.quality is not None:
        assert found.quality == pytest.approx(whole.quality, rel=1e-9)
    assert [w for w, _ in found.weight_curve] == [w for w, _ in whole.weight_curve]


@pytest.mark.usefixtures("small_stretches")
def test_sample_stands_for_the_cloud(
    cloud: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stages, "SAMPLE", 600)
    found = segment_file(cloud, tmp_path / "out", 3, processes=1)
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
    found = segment_file(cloud, out, 3, processes=1, progress=lambda *step: seen.append(step))
    names = ["labels.npy", "overlay.png", "result.json", "weight_curve.png"]
    assert sorted({file.name for file in out.iterdir()} - {LOCK}) == names
    assert _outcome(out)["sizes"] == list(found.sizes)
    assert np.load(found.labels_file, mmap_mode="r").dtype == np.int32
    assert {stage for stage, _, _ in seen} == {"measure", "fit", "label"}
    assert all((stage, N, N) in seen for stage in ("measure", "fit", "label"))
    segment_file(cloud, tmp_path / "given", 3, weight=1.0, processes=1)  # nothing searched
    given = {file.name for file in (tmp_path / "given").iterdir()} - {LOCK}
    assert sorted(given) == names[:3]


def test_presets_that_merge_take_the_papers_cut_in_pieces(cloud: Path, tmp_path: Path) -> None:
    found = segment_file(cloud, tmp_path / "out", 3, preset="best", processes=1)
    rows = np.load(cloud)
    scene = Scene.from_cloud(rows[:, :3], rows[:, 3:].astype(np.uint8))
    whole = geohue.segment(scene, 3, "agreement", "best")
    np.testing.assert_array_equal(_labels(tmp_path / "out"), whole.labels)
    assert found.weight == whole.weight


def _start(cloud: Path, out: Path, log: Path, *more: str) -> subprocess.Popen[bytes]:
    folders = [str(SCRIPT.parents[1]), os.environ.get("PYTHONPATH", "")]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, folders))}
    command = [sys.executable, str(SCRIPT), str(cloud), str(out), str(log), *more]
    return subprocess.Popen(command, env=environment)


def test_killed_run_resumes_where_it_was(cloud: Path, tmp_path: Path) -> None:
    out, log, whole = tmp_path / "out", tmp_path / "log", tmp_path / "whole"
    first = _start(cloud, out, log)
    ledger = out / "state" / "labelled.csv"
    while first.poll() is None and not (
        ledger.exists() and len(ledger.read_text().splitlines()) > 4
    ):
        time.sleep(0.005)
    first.send_signal(signal.SIGKILL)
    assert first.wait() == -signal.SIGKILL
    assert not (out / "labels.npy").exists()
    kept = {line.split(",")[0] for line in ledger.read_text().splitlines()[1:]}
    before = set(log.read_text().split())
    assert 4 <= len(kept) < N // STRETCH
    log.unlink()
    assert _start(cloud, out, log, "resume").wait() == 0
    again = set(log.read_text().split())
    assert not again & kept
    assert len(before | again) == N // STRETCH
    assert _start(cloud, whole, log).wait() == 0
    for name in ("labels.npy", "segmented.ply", "overlay.png"):
        assert (out / name).read_bytes() == (whole / name).read_bytes()
    assert _outcome(out) == _outcome(whole)


@pytest.fixture
def stopped(cloud: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A run whose stretch at 3000 could not be labelled."""
    monkeypatch.setattr(stages, "JOB", STRETCH)

    def fail_once(job: LabelJob) -> list[int]:
        if job.start == 3000:
            raise GeohueError("disk: is on fire")
        return label(job)

    with monkeypatch.context() as patch:
        patch.setattr(stages, "label", fail_once)
        with pytest.raises(GeohueError, match=r"1 of 12 stretches .* 3000 \(disk: is on fire\)"):
            segment_file(cloud, tmp_path / "out", 3, weight=1.0, processes=1)
    return tmp_path / "out"


def test_failed_stretch_keeps_the_others(
    stopped: Path, cloud: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    done: list[int] = []

    def noted(job: LabelJob) -> list[int]:
        done.append(job.start)
        return label(job)

    monkeypatch.setattr(stages, "label", noted)
    segment_file(cloud, stopped, 3, weight=1.0, processes=1, resume=True)
    assert done == [3000]
    segment_file(cloud, stopped.parent / "whole", 3, weight=1.0, processes=1)
    np.testing.assert_array_equal(_labels(stopped), _labels(stopped.parent / "whole"))


def test_a_failure_that_passes_is_tried_again(
    cloud: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried: list[int] = []

    def fail_at_first(job: LabelJob) -> list[int]:
        tried.append(job.start)
        if tried == [0]:
            raise OSError("a hiccup")
        return label(job)

    monkeypatch.setattr(stages, "label", fail_at_first)
    segment_file(cloud, tmp_path / "out", 3, weight=1.0, processes=1)
    assert tried == [0, 0]


def _touch(cloud: Path) -> dict[str, Any]:
    os.utime(cloud, ns=(0, 0))
    return {}


def _grow(cloud: Path) -> dict[str, Any]:
    np.save(cloud, np.concatenate([np.load(cloud), np.ones((1, 6), np.float32)]))
    return {}


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (_touch, "modified_ns"),
        (_grow, "bytes"),
        (lambda _: {"seed": 1}, "has seed = 0"),
        (lambda _: {"cues": "color"}, "has cues = fusion"),
    ],
)
def test_another_run_is_not_resumed(
    stopped: Path, cloud: Path, change: Callable[[Path], dict[str, Any]], says: str
) -> None:
    settings: dict[str, Any] = {"k": 3, "weight": 1.0} | change(cloud)
    with pytest.raises(GeohueError, match=says):
        segment_file(cloud, stopped, **settings, processes=1, resume=True)


@pytest.mark.parametrize(
    ("change", "fits"),
    [({"k": 2}, 1), ({"weight": 2.0}, 1), ({"preset": "fast"}, 1), ({"formats": ["ply"]}, 0)],
)
def test_what_was_measured_serves_another_question(
    stopped: Path,
    cloud: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    change: dict[str, Any],
    fits: int,
) -> None:
    settings: dict[str, Any] = {"k": 3, "weight": 1.0} | change
    segment_file(cloud, tmp_path / "whole", **settings, processes=1)
    fitted: list[Any] = []

    def noted(*given: Any) -> Any:
        fitted.append(given)
        return fit(*given)

    monkeypatch.setattr(stages, "fit", noted)
    monkeypatch.setattr(stages, "measure", None)  # nothing is measured again
    segment_file(cloud, stopped, **settings, processes=1, resume=True)
    assert len(fitted) == fits
    assert _outcome(stopped) == _outcome(tmp_path / "whole")
    for file in (tmp_path / "whole").iterdir():
        if file.name != "result.json":  # which has times
            assert (stopped / file.name).read_bytes() == file.read_bytes()


def test_nothing_begun_stays_behind(stopped: Path, cloud: Path) -> None:
    (stopped / "segmented.ply.part").touch()  # as if it had been asked for
    segment_file(cloud, stopped, 2, weight=1.0, processes=1, resume=True)
    assert not list(stopped.glob("*.part"))


def test_too_many_segments_do_not_lock_a_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    xyz, rgb, _ = three_blobs(5)
    np.save(tmp_path / "a.npy", table(xyz, rgb))
    given = ["segment", str(tmp_path / "a.npy"), "-o", str(tmp_path / "out"), "--processes", "1"]
    assert command([*given, "-k", "9"]) == 2
    assert "5 usable point(s) cannot form 9 segments: lower k" in capsys.readouterr().err
    assert command([*given, "-k", "2", "--resume"]) == 0
    assert _outcome(tmp_path / "out")["k"] == 2


def test_a_folder_takes_one_run_at_a_time(cloud: Path, tmp_path: Path) -> None:
    refused: list[str] = []

    def again(*_: Any) -> None:
        with pytest.raises(GeohueError, match="another run works there") as found:
            segment_file(cloud, tmp_path / "out", 3, processes=1, resume=True)
        refused.append(str(found.value))

    segment_file(cloud, tmp_path / "out", 3, weight=1.0, processes=1, progress=again)
    assert len(refused) > 3


def test_an_unfinished_run_is_not_overwritten(stopped: Path, cloud: Path) -> None:
    with pytest.raises(GeohueError, match="--resume"):
        segment_file(cloud, stopped, 3, weight=1.0, processes=1)


def test_a_run_without_a_stretch_may_begin_again(cloud: Path, tmp_path: Path) -> None:
    State(tmp_path / "out", {"k": 2}, resume=False)
    assert segment_file(cloud, tmp_path / "out", 3, weight=1.0, processes=1).k == 3


def test_a_name_that_is_taken_is_told_of_and_nothing_is_lost(cloud: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    (out / "labels.npy").mkdir(parents=True)
    with pytest.raises(GeohueError, match=r"has other files in it \(labels.npy\)"):
        segment_file(cloud, out, 3, weight=1.0, processes=1)
    with pytest.raises(GeohueError, match=r"labels.npy: cannot be replaced"):
        segment_file(cloud, out, 3, weight=1.0, processes=1, overwrite=True)
    assert (out / "labels.npy").is_dir()
    (out / "labels.npy").rmdir()
    assert segment_file(cloud, out, 3, weight=1.0, processes=1, resume=True).k == 3
    assert {file.name for file in out.iterdir()} - {LOCK} == {
        "labels.npy",
        "overlay.png",
        "result.json",
    }


def test_nothing_is_taken_from_a_run_whose_end_was_cut_off(
    stopped: Path, cloud: Path, tmp_path: Path
) -> None:
    (stopped / "state" / "run.json").unlink()
    other = tmp_path / "other.npy"
    np.save(other, np.load(cloud)[::-1])
    segment_file(other, stopped, 3, weight=1.0, processes=1)
    segment_file(other, tmp_path / "whole", 3, weight=1.0, processes=1)
    np.testing.assert_array_equal(_labels(stopped), _labels(tmp_path / "whole"))


@pytest.mark.parametrize("content", ["{", "3"])
def test_damaged_settings_are_named(stopped: Path, cloud: Path, content: str) -> None:
    (stopped / "state" / "run.json").write_text(content)
    with pytest.raises(GeohueError, match=r"run.json: is damaged .* to begin again"):
        segment_file(cloud, stopped, 3, weight=1.0, processes=1, resume=True)


@pytest.mark.parametrize("content", [b"no archive", b"PK\x03\x04 cut short", b""])
def test_damaged_fit_is_named_and_made_again(
    stopped: Path, cloud: Path, tmp_path: Path, content: bytes
) -> None:
    fit = stopped / "state" / "fit.npz"
    fit.write_bytes(content)
    with pytest.raises(GeohueError, match=r"fit.npz: is damaged .* remove it and resume"):
        segment_file(cloud, stopped, 3, weight=1.0, processes=1, resume=True)
    fit.unlink()
    segment_file(cloud, stopped, 3, weight=1.0, processes=1, resume=True)
    segment_file(cloud, tmp_path / "whole", 3, weight=1.0, processes=1)
    np.testing.assert_array_equal(_labels(stopped), _labels(tmp_path / "whole"))


@pytest.mark.parametrize("content", ["{", "[]", "{}"])
def test_a_result_of_something_else_is_replaced(cloud: Path, tmp_path: Path, content: str) -> None:
    out = tmp_path / "out"
    out.mkdir()
    np.save(out / "labels.npy", np.zeros(3))
    (out / "result.json").write_text(content)
    with pytest.raises(GeohueError, match="has other files"):
        segment_file(cloud, out, 3, weight=1.0, processes=1, resume=True)
    segment_file(cloud, out, 3, weight=1.0, processes=1, resume=True, overwrite=True)
    assert _outcome(out)["n_points"] == N


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


def test_a_finished_run_resumes_to_itself(
    cloud: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    first = segment_file(cloud, out, 3, cues="geometry", processes=1)
    monkeypatch.setattr(stages, "label", None)  # nothing is labelled again
    monkeypatch.setattr(stages, "measure", None)
    again = segment_file(cloud, out, 3, cues="geometry", processes=1, resume=True)
    assert again.summary() == first.summary()


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="no /proc")
def test_memory_is_kept(tmp_path: Path) -> None:
    """The whole process, libraries and all, on a cloud of which every point is 24 bytes."""
    xyz, rgb, _ = three_blobs(1_300_000)
    np.save(tmp_path / "cloud.npy", table(xyz, rgb))
    options = f"-k 3 --lambda 1 --memory 400MB -o {tmp_path / 'out'}".split()
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
        ({"weight": "merge"}, 'weight="merge" needs the whole cloud in memory'),
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
