"""All files of a run appear together or not at all: also on a full disk, and after a kill."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from geohue import GeohueError, Scene, Segmentation, segment
from geohue.cli.app import run as command
from geohue.results import folder as module
from geohue.results.folder import INCOMPLETE, SEGMENTATION, check_result_folder, whole_folder
from geohue.results.outputs import write_results

RESULT = '{"version": "0"}'

SLOWLY = """
import sys, time
from pathlib import Path
from geohue.results.folder import whole_folder
with whole_folder(sys.argv[1]) as new:
    for name in ("labels.png", "overlay.png", "result.json"):
        (new / name).write_text('{"version": "new"}')
        print(name, flush=True)
        time.sleep(60 if name == sys.argv[2] else 0)
"""


@pytest.fixture
def small() -> tuple[Scene, Segmentation]:
    """A scene of two parts, and what was found."""
    image = np.zeros((20, 30, 3), np.uint8)
    image[:, 15:] = 200
    scene = Scene.from_image(image)
    return scene, segment(scene, k=2, cues="color", preset="paper")


@pytest.fixture
def earlier(tmp_path: Path) -> Path:
    """A folder with the result of an earlier run."""
    out = tmp_path / "out"
    out.mkdir()
    for name in ("labels.png", "coco.json", "weight_curve.png"):
        (out / name).write_text("old")
    (out / "result.json").write_text(RESULT)
    return out


@pytest.fixture(params=["in one step", "one by one"])
def way(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Both ways to replace a folder: with and without the system's help."""
    if request.param == "one by one":
        monkeypatch.setattr(module, "exchange", lambda *_: False)
    return str(request.param)


def _names(folder: Path) -> list[str]:
    return sorted(file.name for file in folder.iterdir())


def _write(out: Path, *names: str, overwrite: bool = False) -> None:
    with whole_folder(out, overwrite=overwrite) as new:
        for name in (*names, "result.json"):
            (new / name).write_text(RESULT)


@pytest.mark.usefixtures("way")
def test_an_earlier_result_is_replaced_whole(earlier: Path) -> None:
    earlier.chmod(0o750)
    _write(earlier, "labels.png", "overlay.png")
    assert _names(earlier) == ["labels.png", "overlay.png", "result.json"]
    assert (earlier / "labels.png").read_text() == RESULT
    assert _names(earlier.parent) == ["out"]
    assert earlier.stat().st_mode & 0o777 == 0o750


@pytest.mark.usefixtures("way")
@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, OSError(28, "No space left")])
def test_a_failure_leaves_all_as_it_was(earlier: Path, error: type[BaseException]) -> None:
    def fail() -> None:
        with whole_folder(earlier) as new:
            (new / "labels.png").write_text("half")
            raise error

    before = {file: file.read_bytes() for file in earlier.iterdir()}
    with pytest.raises(GeohueError if isinstance(error, OSError) else error):
        fail()
    assert {file: file.read_bytes() for file in earlier.iterdir()} == before
    assert _names(earlier.parent) == ["out"]


def test_other_files_make_it_refuse(earlier: Path) -> None:
    for name in ("a.txt", "b.txt", "c.txt", "d.txt"):
        (earlier / name).write_text("mine")
    with pytest.raises(GeohueError, match=r"other files in it \(a.txt, b.txt, c.txt, \.\.\.\)"):
        _write(earlier, "labels.png")
    assert (earlier / "labels.png").read_text() == "old"
    _write(earlier, "overlay.png", overwrite=True)
    assert _names(earlier) == ["a.txt", "b.txt", "c.txt", "d.txt", "overlay.png", "result.json"]
    assert (earlier / "a.txt").read_text() == "mine"


@pytest.mark.parametrize("mark", [None, "{", "[]", '{"k": 3}'])
def test_names_alone_do_not_make_a_result_ours(tmp_path: Path, mark: str | None) -> None:
    (tmp_path / "labels.png").write_text("drawn by hand")
    if mark is not None:
        (tmp_path / "result.json").write_text(mark)
    with pytest.raises(GeohueError, match="has other files in it"):
        check_result_folder(tmp_path)
    _write(tmp_path, "overlay.png", overwrite=True)
    assert (tmp_path / "labels.png").read_text() == "drawn by hand"


def test_an_empty_folder_and_a_new_one_will_do(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    for out in (tmp_path / "empty", tmp_path / "new" / "deep"):
        _write(out)
        assert _names(out) == ["result.json"]


def test_the_working_folder_stays_the_same(earlier: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A shell that stands in it would else stand in one that is gone."""
    monkeypatch.chdir(earlier)
    place = earlier.stat().st_ino
    _write(Path(), "labels.png")
    assert earlier.stat().st_ino == place
    assert _names(earlier) == ["labels.png", "result.json"]


def test_a_link_to_a_folder_stays_one(earlier: Path, tmp_path: Path) -> None:
    link = tmp_path / "link"
    link.symlink_to(earlier, target_is_directory=True)
    _write(link, "labels.png")
    assert link.is_symlink()
    assert _names(earlier) == ["labels.png", "result.json"]


def test_killed_between_two_files_it_is_taken_up_again(
    earlier: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "exchange", lambda *_: False)
    rename, moved = Path.replace, list[str]()

    def die(self: Path, target: Path) -> Path:
        moved.append(target.name)
        if len(moved) == 2:
            raise SystemExit  # as a kill: nothing is tidied up
        return rename(self, target)

    with monkeypatch.context() as patch:
        patch.setattr(Path, "replace", die)
        with pytest.raises(SystemExit):
            _write(earlier, "labels.png", "overlay.png")
    assert INCOMPLETE in _names(earlier)
    assert SEGMENTATION.mark not in _names(earlier)
    with pytest.raises(GeohueError, match=r"result.json: no such file"):
        Segmentation.load(earlier)
    (earlier / "levels.npz").write_text("of neither run")
    with pytest.raises(GeohueError, match=r"\(levels.npz\)"):
        _write(earlier)
    (earlier / "levels.npz").unlink()
    _write(earlier, "labels.png")
    assert _names(earlier) == ["labels.png", "result.json"]


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no kill -9 on this system")
@pytest.mark.parametrize("last", ["labels.png", "result.json"])
def test_kill_9_leaves_the_earlier_result(earlier: Path, last: str) -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", SLOWLY, str(earlier), last], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    while process.stdout.readline().strip() != last:
        assert process.poll() is None
    left = [name for name in _names(earlier.parent) if name != "out"]
    _write(earlier)  # another run does not take the one under way for a dead one
    assert len(left) == 1
    assert left[0] in _names(earlier.parent)
    process.send_signal(signal.SIGKILL)
    process.wait()
    process.stdout.close()
    assert (earlier / "result.json").read_text() == RESULT
    _write(earlier)
    assert _names(earlier.parent) == ["out"]  # what was left is gone


@pytest.fixture
def tiny_disk(tmp_path: Path) -> Iterator[Path]:
    """A disk of 64 kB."""
    place = tmp_path / "disk"
    place.mkdir()
    mount = shutil.which("mount")
    done = mount and subprocess.run(
        [mount, "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(place)], capture_output=True
    )
    if not done or done.returncode:
        pytest.skip("no permission to mount a small disk (tmpfs)")
    yield place
    subprocess.run(["umount", "-l", str(place)], check=True)


@pytest.mark.parametrize("inside", ["out", "."])
def test_a_full_disk_leaves_the_earlier_result(
    tiny_disk: Path, small: tuple[Scene, Segmentation], inside: str
) -> None:
    """Also where the folder is the disk itself, which cannot be exchanged for another."""
    scene, seg = small
    out = tiny_disk / inside
    write_results(out, scene, seg)
    before = {file.name: file.read_bytes() for file in out.iterdir()}
    noise = np.random.default_rng(0).integers(0, 256, (200, 300, 3)).astype(np.uint8)
    large = Scene.from_image(noise)
    labels: NDArray[np.int32] = np.zeros(large.shape, np.int32)
    many = Segmentation(labels, 1, 0.0, None, [], "nncsc", "paper", "color", 0, {})
    with pytest.raises(GeohueError, match=r"No space left.*folder with space") as error:
        write_results(out, large, many, ["segments"])
    assert ".geohue" not in str(error.value)
    assert {file.name: file.read_bytes() for file in out.iterdir()} == before
    assert [p for p in tiny_disk.rglob("*") if ".geohue" in p.name] == []
    write_results(out, scene, seg, lean=True)
    assert _names(out) == ["labels.png", "result.json"]


def test_the_command_refuses_before_it_reads(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "thesis.tex").write_text("mine")
    given = ["segment", str(tmp_path / "no such file.ply"), "-o", str(tmp_path)]
    assert command(given) == 2
    told = capsys.readouterr().err
    assert "has other files in it (thesis.tex)" in told
    assert "--overwrite" in told
    assert "overwrite=True" not in told
    assert command([*given, "--overwrite"]) == 2
    assert "no such file" in capsys.readouterr().err


def test_results_in_a_folder_of_data(tmp_path: Path, small: tuple[Scene, Segmentation]) -> None:
    """As with --overwrite: stale results go, the data stay, and the time of old files is seen."""
    scene, seg = small
    (tmp_path / "rgb.png").write_text("data")
    write_results(tmp_path, scene, seg, ["coco"], overwrite=True)
    assert (tmp_path / "coco.json").exists()
    old = time.time() - 100
    os.utime(tmp_path / "rgb.png", (old, old))
    write_results(tmp_path, scene, seg, lean=True, overwrite=True)
    assert _names(tmp_path) == ["labels.png", "result.json", "rgb.png"]
    assert json.loads((tmp_path / "result.json").read_text())["k"] == 2
