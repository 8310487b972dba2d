"""A folder takes one run at a time, and what a killed one has left stops nobody."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

from geohue.errors import GeohueError
from geohue.jobs.lock import LOCK, only_run


def test_one_run_at_a_time(tmp_path: Path) -> None:
    for _ in range(2):  # the second finds nothing of the first
        with only_run(tmp_path / "out"):
            owner = f"process {os.getpid()} on {platform.node()}"
            with (
                pytest.raises(GeohueError, match=rf"out: another run works there \({owner}\)"),
                only_run(tmp_path / "out"),
            ):
                pytest.fail("two runs in one folder")
            with only_run(tmp_path / "other"):
                pass
            assert (tmp_path / "out" / LOCK).exists()
        assert not (tmp_path / "out" / LOCK).exists()


def test_a_failed_run_gives_its_folder_back(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError), only_run(tmp_path):
        raise ZeroDivisionError
    assert not list(tmp_path.iterdir())


def _ended() -> int:
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


def test_a_killed_run_stops_nobody(tmp_path: Path) -> None:
    # Its number may be ours by now, where numbers begin anew.
    for number in (_ended(), os.getpid(), 2**80):
        (tmp_path / LOCK).write_text(f"{number} {platform.node()}\n")
        with only_run(tmp_path):
            assert (tmp_path / LOCK).read_text().split()[0] == str(os.getpid())


@pytest.mark.skipif(sys.platform == "win32", reason="there its open file tells that a process runs")
@pytest.mark.parametrize(
    ("content", "says"),
    [
        (f"{os.getppid()} {platform.node()}", f"process {os.getppid()} on"),
        (f"1 {platform.node()}", "process 1 on"),
        ("1 elsewhere.example", "process 1 on elsewhere.example"),
        ("", "it has just begun"),
    ],
)
def test_who_may_still_run_is_left_alone(tmp_path: Path, content: str, says: str) -> None:
    (tmp_path / LOCK).write_text(content)
    with pytest.raises(GeohueError, match=rf"{says}.* remove running\.lock"), only_run(tmp_path):
        pytest.fail("two runs in one folder")
    assert (tmp_path / LOCK).read_text() == content


def test_a_file_is_no_folder(tmp_path: Path) -> None:
    (tmp_path / "out").touch()
    with pytest.raises(GeohueError, match="out: cannot be written"), only_run(tmp_path / "out"):
        pytest.fail("a run in a file")
