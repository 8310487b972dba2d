"""The folder of a run: begun once, never mixed."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import NamedTuple

import pytest

from geohue._version import __version__
from geohue.errors import GeohueError
from geohue.jobs.lock import LOCK
from geohue.jobs.run import SETTINGS, Place, Table, open_run, run_table

ASKED = {"k": 2, "formats": ("pcd",), "weight": float("inf")}


def test_run_goes_on_under_the_same_settings_only(tmp_path: Path) -> None:
    open_run(tmp_path / "out", "t.csv", ASKED, {"machine": "a"}, resume=False)
    open_run(tmp_path / "out", "t.csv", ASKED, {"machine": "b"}, resume=True)
    (tmp_path / "out" / "t.csv").write_text("name\na\n")
    with pytest.raises(GeohueError, match="has a run already; use --resume"):
        open_run(tmp_path / "out", "t.csv", ASKED, {}, resume=False)
    with pytest.raises(GeohueError, match="the run there has k = 2, this one 3; give another"):
        open_run(tmp_path / "out", "t.csv", ASKED | {"k": 3}, {}, resume=True)
    with pytest.raises(GeohueError, match="the run there has seed = None, this one 0"):
        open_run(tmp_path / "out", "t.csv", ASKED | {"seed": 0}, {}, resume=True)


def test_run_without_a_row_may_begin_again(tmp_path: Path) -> None:
    open_run(tmp_path, "t.csv", ASKED, {}, resume=False)
    (tmp_path / "t.csv").write_text("name\n")
    open_run(tmp_path, "t.csv", ASKED | {"k": 3}, {}, resume=False)
    with pytest.raises(GeohueError, match="the run there has k = 3, this one 2"):
        open_run(tmp_path, "t.csv", ASKED, {}, resume=True)


@pytest.mark.parametrize(("content", "message"), [("{", "is damaged"), ("[]", "has no settings")])
def test_damaged_settings_are_named(tmp_path: Path, content: str, message: str) -> None:
    (tmp_path / SETTINGS).write_text(content)
    with pytest.raises(GeohueError, match=message):
        open_run(tmp_path, "t.csv", ASKED, {}, resume=True)


def test_table_without_settings_is_not_taken_over(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text("name\n")
    with pytest.raises(GeohueError, match="no such file"):
        open_run(tmp_path, "t.csv", ASKED, {}, resume=True)


def test_runs_of_two_commands_do_not_mix(tmp_path: Path) -> None:
    open_run(tmp_path, "batch.csv", ASKED, {}, resume=False)
    open_run(tmp_path, "frames.csv", ASKED, {}, resume=False)  # the first had not begun
    (tmp_path / "frames.csv").write_text("name\na\n")
    before = (tmp_path / SETTINGS).read_bytes()
    for resume in (False, True):
        with pytest.raises(GeohueError, match=r"a run of another command \(frames.csv\); give"):
            open_run(tmp_path, "batch.csv", ASKED, {}, resume=resume)
    assert (tmp_path / SETTINGS).read_bytes() == before


class Square(NamedTuple):
    """A job that a negative number fails."""

    number: int

    @property
    def key(self) -> tuple[str, ...]:
        return (str(self.number),)


def root(job: Square) -> dict[str, float]:
    """What each job does."""
    return {"root": math.sqrt(job.number)}


def test_rows_of_a_table(tmp_path: Path) -> None:
    table = Table("t.csv", ("n", "root", "error"), ("n",))
    told: list[tuple[int, int, str]] = []

    def run(numbers: list[int], resume: bool = False) -> list[tuple[str, ...]]:
        rows = run_table(
            tmp_path,
            table,
            ASKED,
            root,
            [Square(n) for n in numbers],
            Place(),
            resume=resume,
            progress=lambda *step: told.append(step),
        )
        return [tuple(row.values()) for row in rows]

    first = run([4, -1])
    assert first[0] == ("4", "2.0", "")
    assert first[1][:2] == ("-1", "")
    assert first[1][2].startswith("ValueError")
    assert told.pop()[:2] == (2, 2)
    assert told.pop() == (1, 2, "4")
    assert [row[0] for row in run([9, -1, 4], resume=True)] == ["9", "-1", "4"]
    assert [step[:2] for step in told] == [(2, 3), (3, 3)]  # the failure again, the 4 not
    assert [line.split(",")[0] for line in (tmp_path / "t.csv").read_text().splitlines()] == [
        "n",
        "9",
        "-1",
        "4",
    ]
    assert sorted({file.name for file in tmp_path.iterdir()} - {LOCK}) == [SETTINGS, "t.csv"]
    written = json.loads((tmp_path / SETTINGS).read_text())
    assert written["version"] == __version__
    assert "core" in written["machine"]["cpu"]


def test_a_table_takes_one_run_at_a_time(tmp_path: Path) -> None:
    table = Table("t.csv", ("n", "root", "error"), ("n",))

    def again(*_: object) -> None:
        with pytest.raises(GeohueError, match="another run works there"):
            run_table(tmp_path, table, ASKED, root, [Square(1)], Place(), resume=True)

    jobs = [Square(1), Square(2)]
    assert len(run_table(tmp_path, table, ASKED, root, jobs, Place(), progress=again)) == 2
