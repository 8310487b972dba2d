"""Errors of the command line speak of options, those of the library of arguments."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from geohue.cli.app import run
from geohue.results import write_png

IMAGE = np.tile(np.uint8([[[0, 0, 0], [250, 9, 9]]]), (20, 10, 1))


@pytest.fixture
def image(tmp_path: Path) -> str:
    """A picture of stripes."""
    write_png(tmp_path / "a.png", IMAGE)
    return str(tmp_path / "a.png")


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ("-k 0", "-k 0: expected"),
        ("--seed -1", "--seed -1: expected a whole number of at least 0"),
        ("--lambda -2", "--lambda -2"),
        ("--preset slow", "--preset slow: choose"),
        ("--cues smell", "--cues smell"),
        ("--method svm", "--method svm"),
        ("--format docx", "--format docx: choose"),
        ("--lambda consensus -k 3", "choose --lambda agreement"),
        ("--detail fine --preset paper", "leave out --detail, or choose --preset best"),
        ("--detail fine -k 3", "--detail fine and -k 3"),
    ],
)
def test_errors_name_the_option(
    options: str, says: str, image: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = ["--cues", "color"] if "cues" not in options else []
    assert run(["segment", image, *given, *options.split(), "-o", str(tmp_path / "out")]) == 2
    told = capsys.readouterr().err
    assert says in told
    assert told.count("\n") == 1
    assert not (tmp_path / "out").exists()
