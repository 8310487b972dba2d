"""``geohue video``: what it writes, and that it goes on."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from geohue import Intrinsics
from geohue.cli.app import run
from geohue.read import read_cloud
from geohue.read.images.pictures import read_written_labels
from geohue.simulate.moving import moving_scene

av = pytest.importorskip("av")


@pytest.fixture(scope="module")
def sequence(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Nine frames in the layout of 7-Scenes, the sixth damaged."""
    folder = tmp_path_factory.mktemp("sequence")
    camera = Intrinsics(66.0, 66.0, 39.5, 29.5, 80, 60)
    np.savetxt(
        folder / "camera-intrinsics.txt", np.array([[66, 0, 39.5], [0, 66, 29.5], [0, 0, 1]])
    )
    for i, frame in enumerate(moving_scene(9, camera)):
        name = folder / f"frame-{i:06d}"
        assert frame.scene.depth is not None
        cv2.imwrite(f"{name}.color.png", frame.scene.colors[..., ::-1])
        cv2.imwrite(f"{name}.depth.png", (frame.scene.depth * 1000).astype(np.uint16))
        np.savetxt(f"{name}.pose.txt", frame.pose)
    (folder / "frame-000005.depth.png").write_bytes(b"\x89PNG cut short")
    return folder


def test_a_run_writes_all_and_goes_on(
    sequence: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    wish = ["video", str(sequence), "-o", str(out), "--preset", "fast", "--fuse", "0.05"]
    assert run([*wish, "--limit", "4"]) == 0
    said = capsys.readouterr()
    assert "4 frame(s)" in said.out
    assert "p99" in said.out
    before = read_written_labels(out / "labels" / "frame-000003")
    few = len(read_cloud(out / "cloud.ply").points)
    assert run([*wish, "--resume"]) == 1  # a frame is damaged
    said = capsys.readouterr()
    assert "frame-000005: skipped" in said.err
    assert "1 skipped" in said.out
    names = sorted(file.name for file in (out / "labels").iterdir())
    assert names == [f"frame-{i:06d}.png" for i in (0, 1, 2, 3, 4, 6, 7, 8)]
    after = read_written_labels(out / "labels" / "frame-000004")
    assert (before == after).mean() > 0.9
    with av.open(str(out / "overlay.webm")) as video:
        assert sum(1 for _ in video.decode(video=0)) == 8
    assert sorted(file.name for file in out.iterdir()) == [
        "cloud.ply",
        "labels",
        "overlay.webm",
        "tracks.csv",
        "tracks.json",
        "video.json",
    ]
    tracks = json.loads((out / "tracks.json").read_text())["tracks"]
    with (out / "tracks.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == sum(track["n_frames"] for track in tracks)
    here = read_written_labels(out / "labels" / "frame-000008")
    seen = {int(row["track"]): int(row["size"]) for row in rows if row["frame"] == "8"}
    assert set(seen) == set(np.unique(here).tolist())
    assert sum(seen.values()) == pytest.approx(here.size, rel=0.01)
    assert len(read_cloud(out / "cloud.ply").points) > few
    assert json.loads((out / "video.json").read_text())["last_frame"] == 8
    assert run([*wish, "--resume"]) == 0
    assert "no further frame" in capsys.readouterr().out


def test_a_new_run_leaves_nothing_of_an_earlier_one_and_spares_other_files(
    sequence: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    wish = ["video", str(sequence), "-o", str(out), "--preset", "fast"]
    assert run([*wish, "--limit", "3"]) == 0
    assert run([*wish, "--limit", "1", "--video", "none"]) == 0
    assert [file.name for file in (out / "labels").iterdir()] == ["frame-000000.png"]
    assert not (out / "overlay.webm").exists()
    (out / "notes.txt").write_text("mine")
    assert run([*wish, "--limit", "1"]) == 2
    assert "notes.txt" in capsys.readouterr().err
    assert run([*wish, "--limit", "1", "--overwrite"]) == 0
    assert (out / "notes.txt").read_text() == "mine"


def test_settings_may_not_change_on_the_way(
    sequence: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    wish = ["video", str(sequence), "-o", str(tmp_path), "--preset", "fast", "--limit", "1"]
    assert run([*wish, "--video", "none", "--no-poses"]) == 0
    assert run([*wish, "--video", "none", "--no-poses", "--resume", "--seed", "4"]) == 2
    assert "seed" in capsys.readouterr().err
    assert not (tmp_path / "overlay.webm").exists()


def test_a_live_run_drops_frames(sequence: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wish = ["video", str(sequence), "--live", "--no-window", "--preset", "fast", "--json"]
    assert run([*wish, "--rate", "2000"]) in (0, 1)
    facts = json.loads(capsys.readouterr().out)
    assert facts["n_frames"] + facts["n_dropped"] + facts["n_skipped"] == 9
    assert facts["n_frames"] >= 1


@pytest.mark.parametrize(
    ("wish", "message"),
    [
        ([], "-o DIR"),
        (["--json", "--video", "gif"], "webm"),
        (["--json", "--resume"], "--resume"),
        (["--json", "--preset", "slow"], "preset"),
        (["--json", "--detail", "x"], "--detail"),
        (["--json", "--layout", "x"], "layout"),
        (["--json", "--rate", "0", "--live", "--no-window"], "rate"),
        (["-o", "FOLDER", "--rate", "-3"], "rate"),
        (["-o", "FOLDER", "--fuse", "0"], "voxels"),
    ],
)
def test_bad_wishes_are_one_line(
    sequence: Path,
    tmp_path: Path,
    wish: list[str],
    message: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    wish = [str(tmp_path / "out") if word == "FOLDER" else word for word in wish]
    assert run(["video", str(sequence), *wish]) == 2
    said = capsys.readouterr().err.strip().splitlines()
    assert [line.startswith("geohue: error:") for line in said].count(True) == 1
    assert message in said[-1]


def test_a_color_video_needs_depth(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.mp4").write_bytes(b"x")
    assert run(["video", str(tmp_path / "a.mp4"), "--json"]) == 2
    assert "--depth" in capsys.readouterr().err
