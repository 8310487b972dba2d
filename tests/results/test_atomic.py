"""Files appear whole or not at all; clouds are told apart by name or content."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from geohue.errors import GeohueError
from geohue.read import read_cloud
from geohue.results import atomic_write
from geohue.results.atomic import check_folder


def test_success_replaces_and_makes_folders(tmp_path: Path) -> None:
    target = tmp_path / "a" / "b" / "x.json"
    for text in ("one", "two"):
        with atomic_write(target) as temporary:
            assert temporary.parent == target.parent
            assert temporary.suffix == ".json"
            temporary.write_text(text)
    assert target.read_text() == "two"
    assert [file.name for file in target.parent.iterdir()] == ["x.json"]
    mask = os.umask(0)
    os.umask(mask)
    assert stat.S_IMODE(target.stat().st_mode) == 0o666 & ~mask


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_failure_keeps_the_old_file_and_nothing_else(
    tmp_path: Path, error: type[BaseException]
) -> None:
    target = tmp_path / "x.txt"
    target.write_text("old")

    def fail() -> None:
        with atomic_write(target) as temporary:
            temporary.write_text("half")
            raise error

    with pytest.raises(error):
        fail()
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


def test_full_disk_is_one_error(tmp_path: Path) -> None:
    def fill() -> None:
        with atomic_write(tmp_path / "x.txt"):
            raise OSError(28, "No space left on device")

    with pytest.raises(GeohueError, match=r"x\.txt: .*No space left on device"):
        fill()
    assert list(tmp_path.iterdir()) == []


def test_folders_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for target in (tmp_path / "file" / "x.txt", tmp_path, tmp_path / ("x" * 300)):
        with pytest.raises(GeohueError) as error, atomic_write(target):
            pass
        assert str(error.value).startswith(str(target))


def test_a_folder_is_checked_before_the_work(tmp_path: Path) -> None:
    check_folder(tmp_path / "new" / "deep")
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "file").write_text("here")
    for blocked in (tmp_path / "file", tmp_path / "file" / "under"):
        with pytest.raises(GeohueError, match="is a file"):
            check_folder(blocked)


def test_cloud_without_extension_is_known_by_its_start(tmp_path: Path) -> None:
    ply = "ply\nformat ascii 1.0\nelement vertex 1\n"
    ply += "property float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n"
    pcd = "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nDATA ascii\n1 2 3\n"
    for name, text in [("a", ply), ("b", pcd), ("c.PLY", ply), ("d.dat", "# .PCD\n" + pcd)]:
        (tmp_path / name).write_text(text)
        cloud = read_cloud(tmp_path / name)
        assert cloud.points.tolist() == [[1, 2, 3]]
        assert cloud.source == tmp_path / name
    (tmp_path / "e.stl").write_text("v 1 2 3")
    with pytest.raises(GeohueError, match=r"e\.stl: .*convert it to \.ply"):
        read_cloud(tmp_path / "e.stl")
    with pytest.raises(GeohueError, match="no such file"):
        read_cloud(tmp_path / "none.ply")


def test_importing_loads_no_heavy_library() -> None:
    heavy = "{'cv2', 'trimesh', 'pypcd4', 'PIL', 'lzf'}"
    code = f"import sys, geohue.read, geohue.results; print({heavy} & {{*sys.modules}})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


def test_no_other_thread_meets_another_mask(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The mask belongs to the process: files of other threads would be open to everybody."""
    monkeypatch.setattr(os, "umask", lambda mask: pytest.fail(f"umask({mask})"))
    with atomic_write(tmp_path / "x.txt") as temporary:
        temporary.write_text("x")
    assert (tmp_path / "x.txt").read_text() == "x"
