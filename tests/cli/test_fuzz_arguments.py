"""Whatever stands on the command line: an exit status and a line, never a traceback.

`GEOHUE_FUZZ_CASES` sets the number of cases (`make fuzz`).
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from geohue.cli.app import run
from geohue.results.ply import write_ply

CASES = int(os.environ.get("GEOHUE_FUZZ_CASES", "40"))

COMMANDS = ("segment", "compare", "register", "calibrate", "evaluate", "benchmark", "info", "batch")
FILES = ("rgb.png", "depth.png", "tiny.png", "noise.png", "cloud.ply", "absent.png", ".", "out")
VALUES = (
    *("0", "1", "-1", "3", "300", "1e400", "nan", "inf", "auto", "", "x", "1/0", "2**9999"),
    *("525,525,2,2", "1,2", ",,,", "0,0,0,0", "best", "paper", "kmeans", "fusion", "coarse"),
    *FILES,
)
OPTIONS = (
    *("--intrinsics", "--depth-scale", "--right", "--disparity", "--disparity-scale", "--calib"),
    *("-k", "--lambda", "--cues", "--preset", "--method", "--detail", "--seed", "--threads"),
    *("--sample", "--frame", "--no-fill", "--components", "--json", "--gt", "--memory", "--absent"),
)


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with a few small files, which is the current one."""
    folder, rng = tmp_path_factory.mktemp("desk"), np.random.default_rng(0)
    rgb = rng.integers(0, 255, (12, 16, 3)).astype(np.uint8)
    cv2.imwrite(str(folder / "rgb.png"), rgb)
    cv2.imwrite(str(folder / "depth.png"), rng.integers(500, 900, (12, 16)).astype(np.uint16))
    cv2.imwrite(str(folder / "tiny.png"), rgb[:1, :1])
    (folder / "noise.png").write_bytes(rng.bytes(200))
    write_ply(folder / "cloud.ply", rng.random((30, 3)), rgb.reshape(-1, 3)[:30], np.arange(30))
    before = Path.cwd()
    os.chdir(folder)
    yield folder
    os.chdir(before)


@st.composite
def arguments(draw: st.DrawFn) -> list[str]:
    """A command, files and options, in an order that may make sense."""
    words = [draw(st.sampled_from(COMMANDS))]
    words += draw(st.lists(st.sampled_from(FILES), max_size=3))
    for _ in range(draw(st.integers(0, 4))):
        words.append(draw(st.sampled_from(OPTIONS)))
        if draw(st.booleans()):
            words.append(draw(st.sampled_from(VALUES)))
    return [*words, "-o", "out"] if draw(st.booleans()) else words


@settings(
    max_examples=CASES,
    deadline=60_000,  # ms: no hang; compare and batch start processes
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(words=arguments())
@pytest.mark.usefixtures("desk")
def test_any_arguments(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    status = run(words)
    written = capsys.readouterr().err
    assert status in (0, 1, 2)
    assert "Traceback" not in written
    if status == 2:
        assert written.count("geohue: error: ") == 1
