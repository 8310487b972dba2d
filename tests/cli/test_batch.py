"""`geohue batch`: what it finds, what it writes, and that nothing is lost or done twice."""

from __future__ import annotations

import csv
import json
import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from geohue.camera import Intrinsics
from geohue.cli.app import run
from geohue.datasets.frames import Dataset, Frame
from geohue.errors import GeohueError
from geohue.jobs.lock import LOCK
from geohue.read.images.pictures import read_labels
from geohue.results import write_ply
from geohue.results.pcd import write_pcd
from geohue.results.png import write_png
from geohue.studies import items as module
from geohue.studies.batch import Settings, find_items
from jobs.frames import HEIGHT, WIDTH, write_frames

HERE = Path(__file__).parent
FAST = ["-k", "2", "--preset", "fast", "--processes", "1"]


@pytest.fixture(scope="module")
def frames(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_frames(tmp_path_factory.mktemp("frames"), 3)


def rows_of(out: Path) -> dict[str, dict[str, str]]:
    with (out / "batch.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len({row["name"] for row in rows}) == len(rows)
    return {row["name"]: row for row in rows}


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def test_each_frame_gets_what_segment_gives_it(
    frames: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["batch", str(frames), "-o", str(tmp_path / "out"), *FAST]) == 0
    assert "3 of 3 frame(s) segmented, " in capsys.readouterr().out
    rows = rows_of(tmp_path / "out")
    assert list(rows) == ["0000", "0001", "0002"]
    assert names(tmp_path / "out") - {LOCK} == {*rows, "batch.csv", "run.json"}
    for i, (name, row) in enumerate(rows.items()):
        part, alone = frames / name, tmp_path / "alone"
        given = [str(part / file) for file in ("rgb.png", "depth.png")]
        camera = ["--intrinsics", str(part / "intrinsics.json")]
        assert run(["segment", *given, *camera, *FAST[:4], "-o", str(alone)]) == 0
        assert names(alone) == names(tmp_path / "out" / name)
        for file in ("labels.png", "overlay.png", "segmented.ply"):
            assert (alone / file).read_bytes() == (tmp_path / "out" / name / file).read_bytes()
        summary = json.loads((tmp_path / "out" / name / "result.json").read_text())
        told = ("k", "weight", "quality", "n_points", "n_labelled")
        assert {key: float(row[key]) for key in told} == {key: summary[key] for key in told}
        labels = read_labels(tmp_path / "out" / name / "labels.png")
        # The two halves, by hand.
        assert len(np.unique(labels[:, : WIDTH // 2 + 3 * i])) == 1
        assert len(np.unique(labels[:, WIDTH // 2 + 3 * i :])) == 1
        assert int(row["n_points"]) == HEIGHT * WIDTH


def test_detail_reaches_every_frame(frames: Path, tmp_path: Path) -> None:
    given = ["--preset", "fast", "--processes", "1", "--limit", "1"]
    for detail in ("-20", "20"):
        out = ["-o", str(tmp_path / detail), "--detail", detail]
        assert run(["batch", str(frames), *out, *given]) == 0
    one, many = (
        json.loads((tmp_path / detail / "0000" / "result.json").read_text())
        for detail in ("-20", "20")
    )
    assert (one["detail"], one["k"]) == (-20, 1)
    assert many["k"] == many["levels"]["n"] > 2  # the finest level: a segment a region
    assert json.loads((tmp_path / "20" / "run.json").read_text())["detail"] == 20


def test_settings_that_no_frame_could_have() -> None:
    for wrong in ({"preset": "paper"}, {"weight": 1.0}, {"k": 2}, {"method": "kmeans"}):
        with pytest.raises(GeohueError, match="detail is 'fine'"):
            Settings(detail="fine", **wrong)
    assert Settings().preset == "best"


def test_failed_frames_stop_nothing_and_are_tried_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, out = write_frames(tmp_path / "frames", 5), tmp_path / "out"
    (folder / "0001" / "rgb.png").write_bytes(b"no picture")
    write_png(folder / "0002" / "depth.png", np.zeros((HEIGHT, WIDTH), np.uint16))
    (folder / "0003" / "depth.png").unlink()
    given = ["batch", str(folder), "-o", str(out), *FAST]
    assert run(given) == 1
    told = capsys.readouterr()
    assert "2 of 5 frame(s) segmented" in told.out
    assert "3 failed: their column error says why" in told.out
    rows = rows_of(out)
    assert {n for n, row in rows.items() if row["error"]} == {"0001", "0002", "0003"}
    for name in ("0001", "0002", "0003"):
        assert f"geohue: warning: {name}: {rows[name]['error']}" in told.err
        assert not (out / name).exists()
    assert "rgb.png" in rows["0001"]["error"]
    assert rows["0002"]["error"].startswith("GeohueError: no point has a position")
    before = (out / "0000" / "labels.png").stat().st_mtime_ns
    write_frames(folder, 5)
    assert run([*given, "--resume"]) == 0
    assert "5 of 5 frame(s) segmented" in capsys.readouterr().out
    assert [row["error"] for row in rows_of(out).values()] == [""] * 5
    assert (out / "0000" / "labels.png").stat().st_mtime_ns == before  # not done again


def test_killed_batch_goes_on(tmp_path: Path) -> None:
    folder, out = write_frames(tmp_path / "frames", 5), tmp_path / "out"
    given = [str(folder), "-o", str(out), *FAST, "--lean"]
    process = subprocess.Popen([sys.executable, HERE / "_slow_batch.py", *given])
    try:
        deadline = time.monotonic() + 60
        while not _lines(out / "batch.csv") >= 3 and time.monotonic() < deadline:
            time.sleep(0.02)
    finally:
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
    before = (out / "batch.csv").read_bytes()
    assert 3 <= before.count(b"\n") < 6
    finished = [line.split(",")[0] for line in before.decode().splitlines()[1:]]
    times = {name: (out / name / "result.json").stat().st_mtime_ns for name in finished}
    assert run(["batch", *given, "--resume"]) == 0
    assert (out / "batch.csv").read_bytes().startswith(before)  # none lost, none repeated
    assert list(rows_of(out)) == [f"{i:04d}" for i in range(5)]
    assert times == {name: (out / name / "result.json").stat().st_mtime_ns for name in finished}
    assert names(out / "0004") == {"labels.png", "result.json"}


def _lines(path: Path) -> int:
    return path.read_bytes().count(b"\n") if path.exists() else 0


def test_runs_do_not_mix(frames: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = ["-o", str(tmp_path / "out")]
    assert run(["batch", str(frames), *out, *FAST, "--limit", "1", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["n_frames"], told["n_failed"], told["failed"]) == (1, 0, {})
    assert run(["batch", str(frames), *out, *FAST]) == 2
    assert "has a run already; use --resume, or give another folder" in capsys.readouterr().err
    assert run(["batch", str(frames), *out, *FAST, "--seed", "1", "--resume"]) == 2
    assert "the run there has seed = 0, this one 1" in capsys.readouterr().err
    other = write_frames(tmp_path / "other", 1)
    assert run(["batch", str(other), *out, *FAST, "--resume"]) == 2
    assert "the run there has folder" in capsys.readouterr().err
    assert run(["batch", str(frames), *out, *FAST, "--resume"]) == 0
    assert list(rows_of(tmp_path / "out")) == ["0000", "0001", "0002"]


def test_batch_and_benchmark_do_not_mix(
    frames: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = ["-o", str(tmp_path / "out")]
    assert run(["batch", str(frames), *out, *FAST, "--limit", "1"]) == 0
    before = (tmp_path / "out" / "run.json").read_bytes()
    labelled = write_frames(tmp_path / "labelled", 1)
    write_png(labelled / "0000" / "labels.png", np.ones((HEIGHT, WIDTH), np.uint16))
    assert run(["benchmark", str(labelled), *out, "-k", "2", "--presets", "fast"]) == 2
    assert "has a run of another command (batch.csv)" in capsys.readouterr().err
    assert (tmp_path / "out" / "run.json").read_bytes() == before


def test_clouds_are_a_scene_a_file(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    group = (np.arange(400) % 2).astype(np.int32)
    points = (rng.normal(0, 0.2, (400, 3)) + group[:, None] * [3, 0, 0]).astype(np.float32)
    colors = np.array([[200, 30, 30], [30, 30, 200]], np.uint8)[group]
    folder = tmp_path / "clouds"
    write_ply(folder / "10.ply", points, colors, group)
    write_ply(folder / "9.ply", points, colors, group)
    write_pcd(folder / "10.pcd", points, colors, group)
    (folder / "README.txt").write_text("two clouds, one of them twice")
    assert run(["batch", str(folder), "-o", str(tmp_path / "out"), *FAST]) == 0
    assert list(rows_of(tmp_path / "out")) == ["9", "10.pcd", "10.ply"]
    labels = np.load(tmp_path / "out" / "10.pcd" / "labels.npy")
    assert np.array_equal(labels == labels[0], group == group[0])


def test_pictures_alone_need_to_be_wanted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    picture = np.zeros((20, 30, 3), np.uint8)
    picture[:, 15:] = (200, 40, 40)
    write_png(tmp_path / "pictures" / "a.png", picture)
    given = ["batch", str(tmp_path / "pictures"), "-o", str(tmp_path / "out"), *FAST]
    assert run(given) == 2
    assert "for pictures alone, give --cues color" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    assert run([*given, "--cues", "color"]) == 0
    assert read_labels(tmp_path / "out" / "a" / "labels.png")[0, ::15].tolist() in ([1, 2], [2, 1])


def test_any_line_of_text_is_a_name(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    names = [" two  spaces", "[bold", "x[", "é"]
    for name in names:
        write_png(tmp_path / "pictures" / f"{name}.png", np.eye(20, dtype=np.uint8) * 255)
    given = ["batch", str(tmp_path / "pictures"), "-o", str(tmp_path / "out"), *FAST]
    assert run([*given, "--cues", "color"]) == 0
    assert sorted(rows_of(tmp_path / "out")) == sorted(names)
    assert "é" in capsys.readouterr().err


@pytest.mark.skipif(sys.platform != "linux", reason="names of bytes")
@pytest.mark.parametrize("name", ["two\nlines", "\udcff"])
def test_other_names_are_refused(tmp_path: Path, name: str) -> None:
    write_png(tmp_path / "a.png", np.zeros((20, 20, 3), np.uint8))
    (tmp_path / "a.png").rename(tmp_path / f"{name}.png")
    with pytest.raises(GeohueError, match="which is no line of text; rename it"):
        find_items(tmp_path, pictures=True)


@pytest.mark.parametrize("two", [("A", "a"), ("Stra\u00dfe", "STRASSE"), ("\u00e9", "e\u0301")])
def test_names_of_one_folder_elsewhere_are_refused(tmp_path: Path, two: tuple[str, str]) -> None:
    for name in two:
        write_png(tmp_path / f"{name}.png", np.zeros((20, 20, 3), np.uint8))
    if len(list(tmp_path.iterdir())) < 2:
        pytest.skip("this file system has one name for both")
    with pytest.raises(GeohueError, match=r"share one folder on .*; rename one"):
        find_items(tmp_path, pictures=True)


def _listing(folder: Path, names: str) -> Dataset:
    """A data set whose depth maps are computed, each of the number that its name is."""
    shape = (HEIGHT, WIDTH)

    def frame(name: str) -> Frame:
        camera = Intrinsics(40.0, 40.0, 24.0, 18.0)
        return Frame(
            name,
            lambda: np.zeros((*shape, 3), np.uint8),
            lambda: np.full(shape, float(name), np.float32),
            camera,
        )

    return Dataset("made", folder, [frame(name) for name in names])


def test_frames_that_come_in_do_not_move_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    there = ["24"]
    monkeypatch.setattr(module, "open_dataset", lambda *_, **__: _listing(tmp_path, there[0]))

    def depths() -> dict[str, float]:
        items, _ = find_items(tmp_path, "made")
        return {item.name: float(item.read().points[0, 0, 2]) for item in items}

    assert depths() == {"2": 2, "4": 4}
    there[0] = "1234"
    assert depths() == {"1": 1, "2": 2, "3": 3, "4": 4}
    items, _ = find_items(tmp_path, "made")
    there[0] = "34"  # two went before a worker has seen them
    for item in items:
        with pytest.raises(GeohueError, match="has changed since it was listed; go on with"):
            item.read()


def _flat(folder: Path, write: Callable[[Path, int], None]) -> None:
    for i in range(3):
        write(folder / "color" / f"{i}.png", i)
        if i != 1:
            write(folder / "depth" / f"{i}.png", i)


def _twice(folder: Path, write: Callable[[Path, int], None]) -> None:
    for part in ("a", "b"):
        for kind in ("rgb", "depth"):
            write(folder / part / f"0_{kind}.png", 0)


def _scenes(folder: Path, write: Callable[[Path, int], None]) -> None:
    camera = {"cam_K": [40.0, 0, 24, 0, 40, 18, 0, 0, 1], "depth_scale": 1.0}
    for scene in ("000001", "000002"):
        for kind in ("rgb", "depth"):
            write(folder / scene / kind / "000003.png", 0)
        (folder / scene / "scene_camera.json").write_text(json.dumps({"3": camera}))


@pytest.mark.parametrize(
    ("make", "expected"),
    [
        (_flat, ["0", "2", "1"]),  # the picture without depth is not passed over
        (_twice, ["a/0_rgb", "b/0_rgb"]),
        (_scenes, ["000001/000003", "000002/000003"]),
    ],
)
def test_names_of_frames(
    tmp_path: Path,
    make: Callable[[Path, Callable[[Path, int], None]], None],
    expected: list[str],
) -> None:
    def write(file: Path, _: int) -> None:
        is_depth = "depth" in file.stem or file.parent.name == "depth"
        shape = (HEIGHT, WIDTH) if is_depth else (HEIGHT, WIDTH, 3)
        write_png(file, np.ones(shape, np.uint16 if is_depth else np.uint8))

    make(tmp_path, write)
    items, _ = find_items(tmp_path)
    assert [item.name for item in items] == expected
    assert items[0].read().shape == (HEIGHT, WIDTH)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (["-k", "0"], "-k 0: expected"),
        (["-k", "some"], "-k some: expected"),
        (
            ["--lambda", "-1"],
            "--lambda -1.0: expected auto, quality, agreement, consensus, merge, or at least 0",
        ),
        (["--lambda", "nan"], "--lambda nan: expected"),
        (
            ["--lambda", "consensus", "--method", "kmeans"],
            "--lambda consensus is for --method nncsc, not kmeans",
        ),
        (["--preset", "slow"], "--preset slow: choose one of"),
        (["--detail", "high"], "--detail high: expected coarse, auto, fine or a number"),
        (["--detail", "fine", "--preset", "paper"], "--preset paper has no levels"),
        (["--detail", "1", "-k", "3"], "--detail 1.0 and -k 3: give one of them"),
        (["--cues", "smell"], "--cues smell: choose one of"),
        (["--method", "magic"], "magic"),
        (["--seed", "-1"], "--seed -1: expected"),
        (["--format", "docx"], "--format docx: choose one of"),
        (["--limit", "0"], "--limit 0: expected"),
        (["--depth-scale", "ell"], "ell"),
        (["--layout", "heap"], "--layout heap: choose"),
        (["--processes", "0"], "--processes 0: expected at least 1"),
        (["--processes", "2", "--scheduler", "tcp://127.0.0.1:9"], "both say where to work"),
    ],
)
def test_mistakes_are_one_line_before_anything_is_written(
    frames: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    more: list[str],
    message: str,
) -> None:
    assert run(["batch", str(frames), "-o", str(tmp_path / "out"), *more]) == 2
    told = capsys.readouterr().err
    assert told.startswith("geohue: error: ")
    assert message in told
    assert told.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_folder_without_frames(tmp_path: Path) -> None:
    with pytest.raises(GeohueError, match="no such folder"):
        find_items(tmp_path / "nothing")
    with pytest.raises(GeohueError, match="has nothing to segment"):
        find_items(tmp_path)


def test_frames_whose_depth_is_computed_can_be_sent(data_dir: Path) -> None:
    items, notes = find_items(data_dir / "middlebury2006_third", limit=2)
    assert notes[0].startswith("no dmin.txt")
    for item in items:
        sent = pickle.loads(pickle.dumps(item))
        assert np.array_equal(sent.read().points, item.read().points, equal_nan=True)
