"""What ``--help`` shows, at the widths of usual terminals; completion; options without effect."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import click
import numpy as np
import pytest
import typer

from geohue.cli.app import app, run
from geohue.cli.examples import EXAMPLES
from geohue.results import write_png

COMMANDS = sorted(typer.main.get_command(app).commands)  # type: ignore[attr-defined]


def _shown(name: str, width: int, monkeypatch: pytest.MonkeyPatch) -> str:
    from typer import rich_utils
    from typer.testing import CliRunner

    monkeypatch.setattr(rich_utils, "MAX_WIDTH", width)
    monkeypatch.setenv("COLUMNS", str(width))
    return CliRunner().invoke(app, [name, "--help"], terminal_width=width).output


@pytest.mark.parametrize("width", [80, 100, 120])
@pytest.mark.parametrize("name", COMMANDS)
def test_no_word_is_broken(name: str, width: int, monkeypatch: pytest.MonkeyPatch) -> None:
    text = _shown(name, width, monkeypatch)
    assert max(map(len, text.splitlines())) <= width
    # Only words: frames and the gaps of columns are no part of them.
    seen = set(re.sub(r"[│╭╮╰╯─]", " ", text).split())
    seen |= {name for word in seen for name in word.split(",")}  # --format,--formats
    command = typer.main.get_command(app).commands[name]  # type: ignore[attr-defined]
    for param in command.params:
        words = {*(param.metavar or "").split(), *(param.help or "").split()}
        words |= set() if param.param_type_name == "argument" else set(param.opts)
        assert words <= seen | {"--help"}, (param.name, words - seen)
    for line in EXAMPLES.get(name, ()):
        assert line in text
    told = "".join(line for line in text.splitlines() if "--help" not in line)  # typer's own
    assert not re.search(r"\beq\. ?\d|<(str|int|bool|float)|Sec\. ", told)


@pytest.mark.parametrize("name", sorted(EXAMPLES))
def test_examples_name_commands_and_options_that_there_are(name: str) -> None:
    command: click.Command = typer.main.get_command(app).commands[name]  # type: ignore[attr-defined]
    known = {option for param in command.params for option in param.opts}
    assert len(EXAMPLES[name]) == 2
    for line in EXAMPLES[name]:
        assert f"geohue {name}" in line
        assert set(re.findall(r"(?<= )--?[a-z]+", line)) <= known


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_shell_completes(shell: str) -> None:
    given = {
        "_GEOHUE_COMPLETE": f"complete_{shell}",
        "COMP_WORDS": "geohue segm",
        "COMP_CWORD": "1",
        "_TYPER_COMPLETE_ARGS": "geohue segm",
        "_TYPER_COMPLETE_FISH_ACTION": "get-args",
    }
    code = "import sys; sys.argv = ['geohue']; from geohue.cli import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | given, capture_output=True, text=True
    )
    assert "segment" in done.stdout, done.stderr


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ("a.png d.png --frame 3", "--frame chooses a frame of a data set"),
        ("a.png d.png --views 1", "--views is for two views"),
        ("--sample boxes --intrinsics 1,2,3,4", "--sample and --intrinsics do not go together"),
        ("a.png --right d.png --frame 1", "--right and --frame do not go together"),
    ],
)
def test_options_without_effect_are_refused(
    options: str, says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_png(tmp_path / "a.png", np.zeros((9, 9, 3), np.uint8))
    write_png(tmp_path / "d.png", np.full((9, 9), 900, np.uint16))
    given = [str(tmp_path / word) if word.endswith(".png") else word for word in options.split()]
    assert run(["segment", *given, "--json"]) == 2
    assert says in capsys.readouterr().err
