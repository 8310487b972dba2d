"""The benchmark runner: scores, resuming, failures, and the command line around it."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from geohue.cli.app import run as command
from geohue.errors import GeohueError
from geohue.jobs.ledger import Ledger, Row
from geohue.jobs.lock import LOCK
from geohue.read.images.pictures import read_labels, read_written_labels
from geohue.results.png import write_png
from geohue.studies.benchmark import run as module
from geohue.studies.benchmark.frames import find_frames, load_frame
from geohue.studies.benchmark.run import FIELDS, Measurement, benchmark, measure
from geohue.studies.benchmark.summary import Spread, summarise, table
from geohue.studies.benchmark.trials import Answer, Conditions, Trial, plan

HERE = Path(__file__).parent

MakeFrames = Callable[..., Path]
TRIALS = plan(["nncsc"], ["fusion", "color"], ["fast"])
TWO = Conditions(k=2)


@pytest.fixture(scope="module")
def frames(tmp_path_factory: pytest.TempPathFactory, make_frames: MakeFrames) -> Path:
    return make_frames(tmp_path_factory.mktemp("frames"))


def untimed(path: Path) -> list[Row]:
    with path.open(newline="") as file:
        return [{k: v for k, v in row.items() if k != "seconds"} for row in csv.DictReader(file)]


def test_exact_scores_on_frames_that_split_cleanly(frames: Path, tmp_path: Path) -> None:
    rows = benchmark(frames, tmp_path / "out", TRIALS, TWO)
    assert [row["frame"] for row in rows] == ["0000", "0000", "0001", "0001", "0002", "0002"]
    for row in rows:
        assert (float(row["voi_bits"]), float(row["rand"]), row["n_pred"]) == (0, 1, "2")
        # 34 of the 36 rows are labelled.
        assert int(row["n_pixels"]) == 34 * 48
    labels = read_labels(tmp_path / "out/labels/nncsc-fusion-fast/0001.png")
    assert np.unique(labels).tolist() == [1, 2]


def test_processes_give_the_same_table(frames: Path, tmp_path: Path) -> None:
    benchmark(frames, tmp_path / "one", TRIALS, TWO)
    benchmark(frames, tmp_path / "two", TRIALS, TWO, processes=2)
    assert untimed(tmp_path / "one/frames.csv") == untimed(tmp_path / "two/frames.csv")


def test_killed_run_goes_on_and_ends_with_the_same_table(frames: Path, tmp_path: Path) -> None:
    out, whole = tmp_path / "out", tmp_path / "whole"
    process = subprocess.Popen([sys.executable, HERE / "_slow_run.py", frames, out])
    try:
        deadline = time.monotonic() + 40
        while not _lines(out / "frames.csv") >= 3 and time.monotonic() < deadline:
            time.sleep(0.02)
    finally:
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
    before = (out / "frames.csv").read_bytes()
    assert 3 <= before.count(b"\n") < 7
    # What a kill in the middle of a write would leave.
    with (out / "frames.csv").open("ab") as file:
        file.write(b"0002,nncsc,fus")
    done: list[str] = []

    def note(count: int, total: int, text: str) -> None:
        assert text.startswith("00")
        done.append(f"{count}/{total}")

    benchmark(frames, out, TRIALS, TWO, resume=True, progress=note)
    assert done == [f"{i}/6" for i in range(before.count(b"\n"), 7)]
    assert (out / "frames.csv").read_bytes().startswith(before)  # none lost, none repeated
    benchmark(frames, whole, TRIALS, TWO)
    assert untimed(out / "frames.csv") == untimed(whole / "frames.csv")


def _lines(path: Path) -> int:
    return path.read_bytes().count(b"\n") if path.exists() else 0


def test_failing_frame_and_method_stop_nothing(tmp_path: Path, make_frames: MakeFrames) -> None:
    folder = make_frames(tmp_path / "frames")
    write_png(folder / "0001" / "depth.png", np.zeros((36, 48), np.uint16))
    trials = plan(["nncsc"], ["fusion", "color"], ["fast"])
    rows = benchmark(folder, tmp_path / "out", trials, TWO)
    failed = [(row["frame"], row["cues"]) for row in rows if row["error"]]
    assert failed == [("0001", "fusion")]
    assert rows[2]["error"].startswith("GeohueError: no point has a position")
    (folder / "0002" / "rgb.png").write_bytes(b"no picture")
    with pytest.raises(GeohueError, match="has a run already; use --resume"):
        benchmark(folder, tmp_path / "out", trials, TWO)
    again = make_frames(tmp_path / "mended", 3)
    mended = benchmark(again, tmp_path / "out", trials, TWO, resume=True)
    assert [row["error"] for row in mended] == [""] * 6
    assert summarise(mended)[0].failures == 0


def test_frames_are_read_again_when_they_change(tmp_path: Path, make_frames: MakeFrames) -> None:
    folder = make_frames(tmp_path / "frames", 1)
    for out, n_gt in (("before", "2"), ("after", "1")):
        rows = benchmark(folder, tmp_path / out, TRIALS[:1], TWO)
        assert [row["n_gt"] for row in rows] == [n_gt]
        write_png(folder / "0000" / "labels.png", np.ones((36, 48), np.uint16))


def test_other_settings_are_not_mixed_into_a_run(frames: Path, tmp_path: Path) -> None:
    benchmark(frames, tmp_path / "out", TRIALS[:1], TWO, limit=1)
    with pytest.raises(GeohueError, match="the run there has k = 2, this one 3"):
        benchmark(frames, tmp_path / "out", TRIALS, Conditions(k=3), resume=True)
    rows = benchmark(frames, tmp_path / "out", TRIALS, TWO, resume=True)
    assert len(rows) == 6


def test_names_with_spaces_read_back_as_they_are(tmp_path: Path) -> None:
    ledger = Ledger(tmp_path / "table.csv", ["frame", "voi"], ["frame"])
    names = [" a", "a  b", 'c,\t"d"', "\u00fc"]
    for name in names:
        ledger.append({"frame": name, "voi": 1.0})
    assert list(ledger.rows()) == [(name,) for name in names]


def test_ledger_keeps_whole_rows_only(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    ledger = Ledger(path, ["frame", "error", "voi"], ["frame"])
    ledger.append({"frame": "b", "error": 'a "quoted",\nbroken line', "voi": 0.1})
    ledger.append({"frame": "a", "voi": float("nan")})
    with path.open("ab") as file:
        file.write(b'c,"half a ro')
    reopened = Ledger(path, ["frame", "error", "voi"], ["frame"])
    assert reopened.rows()[("b",)] == {
        "frame": "b",
        "error": 'a "quoted", broken line',
        "voi": "0.1",
    }
    assert list(reopened.rows()) == [("b",), ("a",)]
    reopened.append({"frame": "b", "voi": 2.0})
    reopened.sort(lambda key: key)
    assert path.read_text() == "frame,error,voi\na,,nan\nb,,2.0\n"
    with pytest.raises(GeohueError, match="has other columns"):
        Ledger(path, ["frame", "rand"], ["frame"])


def test_summary_by_hand() -> None:
    base: Row = dict.fromkeys(FIELDS, "1")
    rows = [
        base | {"method": "m", "cues": "color", "preset": "-", "voi_bits": v, "error": e}
        for v, e in (("1.0", ""), ("2.0", ""), ("6.0", ""), ("", "broke"))
    ]
    (summary,) = summarise(rows)
    assert (summary.name, summary.frames, summary.failures) == ("m color", 3, 1)
    # Variance (4 + 1 + 9) / 3; the quartiles of three values lie half-way between them.
    assert summary.measures["voi_bits"] == Spread(3.0, 2.0, (14 / 3) ** 0.5, 1.5, 4.0)
    assert table([summary]).splitlines()[2] == (
        "| m | color | - | 3 | 1 | 3.000 | 2.160 | 2.000 | 1.50-4.00 | 1.000 | 1.000 | 1.000 "
        "| 1.0 | 1.00 |"
    )


def test_crop_keeps_points_and_camera(frames: Path) -> None:
    whole, truth = load_frame(find_frames(frames)[0])
    part, cut = load_frame(find_frames(frames)[0], (4, 30, 10, 40))
    assert np.array_equal(part.points, whole.points[4:30, 10:40])
    assert np.array_equal(cut, truth[4:30, 10:40])
    assert part.intrinsics is not None
    assert part.depth is not None
    assert np.allclose(part.intrinsics.unproject(part.depth), part.points, atol=1e-6)


def test_object_labels_are_preferred_and_limits_spread(
    tmp_path: Path, make_frames: MakeFrames
) -> None:
    folder = make_frames(tmp_path / "data" / "frames", 6)
    write_png(folder / "0003" / "labels_object.png", np.ones((36, 48), np.uint16))
    (folder / "notes").mkdir()
    found = find_frames(tmp_path / "data", 2)
    assert [(f.name, f.labels.name) for f in found if f.labels] == [
        ("0000", "labels.png"),
        ("0003", "labels_object.png"),
    ]
    with pytest.raises(GeohueError, match="no frames with labels"):
        find_frames(folder / "notes")


def test_labels_of_a_data_set_are_those_of_its_frames(
    tmp_path: Path, make_frames: MakeFrames
) -> None:
    made = make_frames(tmp_path / "made", 3)
    for i, part in enumerate(sorted(made.iterdir())):
        (part / "rgb.png").rename(part / "color.png")  # as in no folder of frames of ours
        (part / "labels.png").rename(part / ("label.png" if i != 1 else "other.png"))
    found = find_frames(made)
    assert [item.name for item in found] == ["0000", "0002"]
    rows = benchmark(made, tmp_path / "out", TRIALS[:1], TWO)
    assert [(row["frame"], row["n_gt"], float(row["voi_bits"])) for row in rows] == [
        ("0000", "2", 0),
        ("0002", "2", 0),
    ]


def test_a_frame_that_takes_too_long_has_failed(frames: Path, tmp_path: Path) -> None:
    rows = benchmark(frames, tmp_path / "out", TRIALS[:1], TWO, limit=1, timeout=0.05)
    assert [row["error"] for row in rows] == ["not done after 0.05 s"]


def test_plan_pairs_methods_with_their_cues() -> None:
    assert plan(["kmeans", "nncsc"], ["geometry"], ["fast", "fast"]) == [
        Trial("kmeans", "geometry", "-"),
        Trial("nncsc", "geometry", "fast"),
    ]
    with pytest.raises(GeohueError, match="no method works on these cues"):
        plan(["edison"], ["fusion"])
    assert [trial.name for trial in plan()] == ["nncsc-fusion-best"]  # as `geohue.segment` does
    with pytest.raises(GeohueError, match="choose among nncsc, kmeans"):
        plan(["cmeans"])


def test_command_writes_table_and_pictures(
    frames: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    given = ["benchmark", str(frames), "-o", str(out), "-k", "2", "--presets", "fast"]
    assert command([*given, "--limit", "2"]) == 0
    assert "| nncsc | fusion | fast | 2 | 0 | 0.000 |" in capsys.readouterr().out
    assert {path.name for path in out.iterdir()} - {LOCK} == {
        "frames.csv",
        "run.json",
        "summary.md",
        "labels",
        "boxes.png",
        "regions.png",
        "best-worst-nncsc-fusion-fast.png",
    }
    settings = json.loads((out / "run.json").read_text())
    assert settings["k"] == 2
    assert "core" in settings["machine"]["cpu"]


def test_command_with_a_frame_that_fails_does_not_exit_with_0(
    tmp_path: Path, make_frames: MakeFrames, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = make_frames(tmp_path / "frames", 2)
    (folder / "0001" / "depth.png").write_bytes(b"no depth")
    given = ["benchmark", str(folder), "-o", str(tmp_path / "out"), "-k", "2", "--presets", "fast"]
    assert command([*given, "--no-plots"]) == 1
    assert "| nncsc | fusion | fast | 1 | 1 |" in capsys.readouterr().out
    assert (tmp_path / "out" / "summary.md").exists()


def test_more_labels_than_16_bits_tell_apart(
    frames: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    many = np.full((36, 48), 70_000, np.int32)
    many[0, 0], many[0, 1] = -1, 70_000 - 65_536  # the two would be one after a wrap
    monkeypatch.setattr(module, "answer", lambda *_: Answer(many, 0.1))
    frame = find_frames(frames, 1)[0]
    job = Measurement(frame, TRIALS[0], TWO, None, tmp_path)
    write_png(tmp_path / "labels/nncsc-fusion-fast/0000.png", np.ones((36, 48), np.uint16))
    assert measure(job)["k"] == 70_001
    assert np.array_equal(read_written_labels(job.labels_name), many)
    assert [file.name for file in job.labels_name.parent.iterdir()] == ["0000.npy"]


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (["--protocol", "nyu", "--crop", "0,1,0,1"], "both name a part"),
        (["--protocol", "sun"], "--protocol sun: choose one of nyu"),
        (["--crop", "1,2"], "expected four whole numbers"),
        (["--cues", "smell"], "--cues smell"),
        (["--processes", "0"], "expected at least 1"),
        (["-k", "2", "--presets", "slow"], "--preset slow"),
        (["-k", "0"], "-k 0"),
        (["--seed", "-1"], "--seed -1"),
    ],
)
def test_command_names_what_is_wrong(
    frames: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    more: list[str],
    message: str,
) -> None:
    assert command(["benchmark", str(frames), "-o", str(tmp_path / "out"), *more]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
