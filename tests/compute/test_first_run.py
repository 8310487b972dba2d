"""What is compiled on a first run, and what is said of it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest
from numba.core.caching import CacheImpl
from numba.core.dispatcher import Dispatcher

import geohue.compute.compiled
from geohue import GeohueWarning
from geohue.cli.app import run
from geohue.compute import ahead, first_run
from geohue.merge.eigen import eigenvalue
from geohue.segmentation import warm


def test_compiling_is_told_once() -> None:
    told: list[str] = []
    with first_run.on_compile(lambda: told.append("now")):
        assert numba.njit(lambda x: x + 1)(1) == 2
        assert numba.njit(lambda x: x + 2)(1) == 3
    numba.njit(lambda x: x + 3)(1)
    assert told == ["now"]


def test_a_loop_that_is_there_is_not_told_of() -> None:
    add = numba.njit(lambda x: x + 1)
    add(1)
    with first_run.on_compile(lambda: pytest.fail("nothing is compiled")):
        assert add(2) == 3


def test_without_a_folder_to_keep_loops_they_work_and_the_mend_is_named(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(CacheImpl, "_locator_classes", [])
    with pytest.warns(GeohueWarning, match="set NUMBA_CACHE_DIR"):
        add = geohue.compute.compiled.vectorized(_add)
    assert add(1.0) == 2.0


def _add(x: float) -> float:
    return x + 1


def test_the_command_line_says_so_in_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def compile_all() -> None:
        first_run.announce()
        first_run.announce()

    monkeypatch.setattr(warm, "compile_all", compile_all)
    assert run(["warm"]) == 0
    captured = capsys.readouterr()
    assert captured.out.startswith("all loops are compiled")
    assert len(captured.err.splitlines()) == 1
    assert "compiling" in captured.err


def test_warming_up_leaves_nothing_to_compile() -> None:
    code = """
import gc, numba, numpy as np, geohue
from geohue.baselines import BASELINES
from geohue.datasets import load_sample
from geohue.segmentation.warm import compile_all

def signatures():
    return {(d.__module__, d.__name__, str(s)) for d in gc.get_objects()
            if isinstance(d, numba.core.dispatcher.Dispatcher) and d.__module__.startswith("geohue")
            for s in d.signatures}

compile_all()
warm = signatures()
scene = load_sample("motorcycle")
for preset in geohue.PRESETS:
    geohue.segment(scene.take(np.arange(scene.size).reshape(scene.shape)[::4, ::4]), preset=preset)
    geohue.segment(geohue.Scene.from_cloud(scene.points[::9, ::9].reshape(-1, 3),
                                           scene.colors[::9, ::9].reshape(-1, 3)), preset=preset)
for method, baseline in BASELINES.items():
    geohue.segment(scene.take(np.arange(scene.size).reshape(scene.shape)[::9, ::9]), k=3,
                   method=method, cues=baseline.cues[0])
print(len(warm) > 10, sorted(signatures() - warm))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "True []"


USER = """
from geohue.compute.compiled import compiled
from helper import SHARE, half

@compiled
def loop(x):
    return half(x) + SHARE
"""
HELPER = """
from geohue.compute.compiled import compiled

SHARE = {share}

@compiled
def half(x):
    return x / {divisor}
"""
ASK = """
from geohue.compute.first_run import on_compile
with on_compile(lambda: print("compiles", end=" ")):
    from user import loop
    print(loop(12.0))
"""


def test_machine_code_follows_what_is_compiled_into_it(tmp_path: Path) -> None:
    """numba keeps the code of `loop` by the file of `loop`, which is not the one that changes."""
    (tmp_path / "user.py").write_text(USER)
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "kept")}
    environment["PYTHONPATH"] = os.pathsep.join([str(tmp_path), *filter(None, sys.path)])

    def answer(share: float, divisor: int) -> str:
        (tmp_path / "helper.py").write_text(HELPER.format(share=share, divisor=divisor))
        command = [sys.executable, "-B", "-c", ASK]
        return subprocess.check_output(command, env=environment, text=True, cwd=tmp_path).strip()

    assert answer(1.0, 2) == "compiles 7.0"
    assert answer(1.0, 2) == "7.0"
    assert answer(1.0, 3) == "compiles 5.0"
    assert answer(2.0, 3) == "compiles 6.0"
    assert answer(2.0, 3) == "6.0"


def test_helpers_compile_the_loops_that_a_run_takes_from_them() -> None:
    """Each part, used on next to nothing, has the signatures of a real scene and no others."""
    code = """
import geohue, numpy as np
from importlib import import_module
from geohue.datasets import load_sample
from geohue.segmentation.warm import COMPILE, PARTS

def signatures():
    loops = [name.rsplit(".", 1) for part in PARTS.values() for name in part]
    return {name: {str(s) for s in getattr(import_module(module), name).signatures}
            for module, name in loops}

for part in ("merging", "borders", "quality", "fill"):
    COMPILE[part]()
helped = signatures()
scene = load_sample("motorcycle")
scene = scene.take(np.arange(scene.size).reshape(scene.shape)[::6, ::6])
for preset in ("best", "paper"):
    geohue.segment(scene, k=3, preset=preset)
print(all(helped.values()), helped == signatures())
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "True True"


def test_a_run_waits_for_the_helper_that_compiles_a_loop(tmp_path: Path) -> None:
    done = tmp_path / "done"
    command = f"import sys, time, pathlib; time.sleep(0.2); pathlib.Path({str(done)!r}).touch(); "
    shares = [{"slow": ["a.loop"], "never": ["b.loop"]}]
    with ahead.helped(command + "print(sys.argv[1], flush=True); time.sleep(60)", shares):
        assert not ahead.wait_for("another.loop")
        assert not done.exists()
        assert ahead.wait_for("a.loop")
        assert done.exists()
        assert not ahead.wait_for("a.loop")


def test_a_helper_that_dies_is_not_waited_for() -> None:
    with ahead.helped("raise SystemExit(1)", [{"part": ["a.loop"]}]):
        assert ahead.wait_for("a.loop")
        assert not ahead.wait_for("a.loop")
        ahead.finish()


def test_parts_of_loops_are_functions_of_python_too() -> None:
    assert not isinstance(eigenvalue, Dispatcher)
    assert eigenvalue(np.array([1.0, 0, 0, 2, 0, 3]), 0) == pytest.approx(1)
