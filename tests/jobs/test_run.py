"""The folder of a run: begun once, never mixed."""

from __future__ import annotations

from pathlib import Path

import pytest

from geohue.errors import GeohueError
from geohue.jobs.run import SETTINGS, open_run

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
