"""A folder takes one run at a time, and what a killed one has left stops nobody."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from pathlib import Path
from typing import Any

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


def test_a_failed_run_gives_its_folder_back(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError), only_run(tmp_path):
        raise ZeroDivisionError
    with only_run(tmp_path):
        pass


@pytest.mark.parametrize("content", ["", f"{os.getppid()} {platform.node()}\n", "1 elsewhere\n"])
def test_a_file_that_nobody_locks_stops_nobody(tmp_path: Path, content: str) -> None:
    # Numbers of processes begin anew, so the one in the file may be at work on something else.
    (tmp_path / LOCK).write_text(content)
    with only_run(tmp_path):
        assert (tmp_path / LOCK).read_text().split()[0] == str(os.getpid())


HOLD = """
import sys, time
from pathlib import Path
from geohue.jobs.lock import only_run
with only_run(Path(sys.argv[1])):
    print("holds", flush=True)
    time.sleep(60)
"""


def test_another_process_is_kept_out_until_it_is_killed(tmp_path: Path) -> None:
    command = [sys.executable, "-c", HOLD, str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "holds\n"
        with pytest.raises(GeohueError, match="another run works there"), only_run(tmp_path):
            pytest.fail("two runs in one folder")
        process.kill()
    assert (tmp_path / LOCK).exists()  # a killed process removes nothing
    with only_run(tmp_path):
        pass


RACE = """
import sys, time
from pathlib import Path
from geohue.errors import GeohueError
from geohue.jobs.lock import only_run
folder, end = Path(sys.argv[1]), time.monotonic() + 2
held = 0
while time.monotonic() < end:
    try:
        with only_run(folder / "out"):
            (folder / "inside").mkdir()  # fails where somebody else is inside
            (folder / "inside").rmdir()
            held += 1
    except GeohueError as error:
        assert "another run works there" in str(error), error
print(held)
"""


def test_no_two_are_inside_when_many_try(tmp_path: Path) -> None:
    """A file that one leaves as the next opens it must not be taken for the lock."""
    command = [sys.executable, "-c", RACE, str(tmp_path)]
    pipes: Any = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    processes = [subprocess.Popen(command, **pipes) for _ in range(4)]
    for process in processes:
        told, error = process.communicate(timeout=100)
        assert process.returncode == 0, error[-600:]
        assert int(told) > 0


def test_a_file_is_no_folder(tmp_path: Path) -> None:
    (tmp_path / "out").touch()
    with pytest.raises(GeohueError, match="out: cannot be written"), only_run(tmp_path / "out"):
        pytest.fail("a run in a file")
