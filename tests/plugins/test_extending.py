"""The package of docs/extending.md, installed: its parts are seen by every command and worker."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from geohue import PRESETS, GeohueError, Scene, segment
from geohue.baselines import BASELINES
from geohue.cli.app import run
from geohue.features import cue_columns
from geohue.plugins import KINDS, Registry, plugins_of
from geohue.read.images.depth_units import DEPTH_UNITS
from geohue.results.png import write_png
from geohue.segmentation.clusterers import known_methods
from geohue.studies.compare.cells import all_rows, merging_presets

PAGE = Path(__file__).parents[2] / "docs" / "extending.md"
BROKEN = {
    "gone": "no_such_module:METHOD",
    "other": "tones:run",
    "renamed": "tones:METHOD",
}


def install(folder: Path, name: str, groups: dict[str, dict[str, str]]) -> None:
    """Write what an installer leaves of a package but for its modules."""
    info = folder / f"{name}-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    lines = []
    for group, entries in groups.items():
        lines += [f"[{group}]", *(f"{key} = {value}" for key, value in entries.items()), ""]
    (info / "entry_points.txt").write_text("\n".join(lines))


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The package of the page, on the path of this process and those that it starts."""
    text, folder = PAGE.read_text(encoding="utf-8"), tmp_path_factory.mktemp("package")
    (table,) = re.findall(r"```toml\n(.*?)```", text, re.DOTALL)
    for file, code in re.findall(r"```python\n# (\w+\.py)\n(.*?)```", text, re.DOTALL):
        (folder / file).write_text(code, encoding="utf-8")
    install(folder, "tones-and-more", tomllib.loads(table)["project"]["entry-points"])
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        plugins_of.cache_clear()
        yield folder
    plugins_of.cache_clear()


@pytest.fixture(scope="module")
def stills(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Frames in the page's layout, by the page's sensor: a dark half, and a bright one behind."""
    folder = tmp_path_factory.mktemp("stills")
    truth = np.repeat([[1, 2]], 36, axis=0).repeat(24, axis=1).astype(np.uint16)
    for number in ("01", "02"):
        rgb = np.array([30, 220], np.uint8)[truth - 1][..., None].repeat(3, axis=2)
        write_png(folder / f"still-{number}.png", rgb)
        write_png(folder / f"range-{number}.png", (1000 * truth + 0xA000).astype(np.uint16))
        write_png(folder / f"truth-{number}.png", truth)
    return folder


def test_help_names_what_plugins_bring(package: Path) -> None:
    path = os.pathsep.join([str(package), *sys.path])
    told = {
        command: subprocess.run(
            [sys.executable, "-m", "geohue", *command.split(), "--help"],
            capture_output=True,
            text=True,
            check=True,
            env={**os.environ, "PYTHONPATH": path, "COLUMNS": "200"},
        ).stdout
        for command in ("segment", "compare", "")
    }
    for name in ("tones", "height", "layered", ".semi", "tof13"):
        assert f"Plugins: {name}." in told["segment"]
    assert "Plugins: tones." in told["compare"]
    assert "methods: tones; cues: height; voters: layers; presets: layered" in told[""]


def test_names_are_known_without_an_import(package: Path) -> None:
    code = (
        "import sys; from geohue.plugins import KINDS, plugins_of\n"
        "print([name for kind in KINDS for name in plugins_of(kind)], 'tones' in sys.modules)"
    )
    env = {**os.environ, "PYTHONPATH": os.pathsep.join([str(package), *sys.path])}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=env)
    names = ["tones", "height", "layers", "layered", ".semi", "stills", "tof13"]
    assert done.stdout == f"{names} False\n", done.stderr


@pytest.mark.usefixtures("package")
def test_all_has_what_plugins_bring() -> None:
    assert "tones" in known_methods()
    assert "tones" in all_rows()
    assert "fusion+height" in cue_columns()
    assert merging_presets() == ("best", "fast", "layered")
    assert BASELINES.foreign() == ("tones",)
    assert "tof13" in DEPTH_UNITS


def test_compare_runs_them_in_its_processes(
    package: Path,  # noqa: ARG001
    stills: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    rows = ["--methods", "tones,layered", "--cues", "color,fusion+height", "-k", "2"]
    assert run(["compare", str(stills), *rows, "--json", "-o", str(tmp_path)]) == 0
    cells = json.loads(capsys.readouterr().out)["cells"]
    assert [(c["method"], c["cues"], c["status"], c["regions"]) for c in cells] == [
        ("tones", "color", "done", 2),
        ("tones", "fusion+height", "undefined", None),
        ("layered", "color", "done", 2),
        ("layered", "fusion+height", "done", 2),
    ]


def test_benchmark_runs_them_on_their_data(
    package: Path,  # noqa: ARG001
    stills: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    given = ["--methods", "nncsc,tones", "--cues", "color,fusion+height", "-k", "2"]
    where = ["--presets", "layered", "--processes", "2", "--no-plots", "-o", str(tmp_path / "out")]
    assert run(["benchmark", str(stills), *given, *where]) == 0
    lines = capsys.readouterr().out.splitlines()[2:]
    assert [line.split("|")[1:7] for line in lines] == [
        [f" {part} " for part in (*row, "2", "0", "0.000")]
        for row in (
            ("nncsc", "color", "layered"),
            ("nncsc", "fusion+height", "layered"),
            ("tones", "color", "-"),
        )
    ]


def test_batch_reads_layout_and_sensor_in_its_processes(
    package: Path,  # noqa: ARG001
    stills: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(["info", str(stills), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["layout"], facts["n_frames"], facts["labels"]) == ("stills", 2, 2)
    assert facts["frame_median_depth_m"] == 1.5
    given = ["--method", "tones", "--cues", "color", "-k", "2", "--processes", "2", "--lean"]
    assert run(["batch", str(stills), "-o", str(tmp_path / "out"), *given]) == 0
    assert "2 of 2 frame(s)" in capsys.readouterr().out


def test_a_cloud_of_a_format_of_its_own(
    package: Path,  # noqa: ARG001
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    rng = np.random.default_rng(0)
    far = np.repeat([[0.0], [5.0]], 60, axis=0)
    rows = np.hstack(
        [rng.random((120, 3)) + far, np.repeat([[200, 9, 9], [9, 9, 200]], 60, axis=0)]
    )
    np.savetxt(tmp_path / "scan.semi", rows, delimiter=";")
    given = ["-k", "2", "--preset", "paper", "-o", str(tmp_path / "out")]
    assert run(["segment", str(tmp_path / "scan.semi"), *given]) == 0
    assert np.load(tmp_path / "out" / "labels.npy")[::60].tolist() == [0, 1]
    assert run(["info", str(tmp_path / "scan.semi")]) == 0
    assert "semi" in capsys.readouterr().out


@pytest.mark.usefixtures("package")
def test_the_voter_changes_what_is_found(three_boxes: tuple[Scene, NDArray[np.int32]]) -> None:
    scene, _ = three_boxes
    voted, plain = (segment(scene, preset=name, k=5) for name in ("layered", "fast"))
    assert PRESETS["layered"].merge.panel[-1] == "layers"
    assert not np.array_equal(voted.labels, plain.labels)


@pytest.fixture
def broken(package: Path, tmp_path: Path) -> Iterator[None]:
    """Plugins that cannot be imported, are no methods, or call themselves something else."""
    install(tmp_path / "site", "broken-pack", {"geohue.methods": BROKEN})
    assert package.is_dir()
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(tmp_path / "site")
        plugins_of.cache_clear()
        yield
    plugins_of.cache_clear()
    for name in BROKEN:
        BASELINES._loaded.pop(name, None)


@pytest.mark.usefixtures("broken")
def test_a_broken_plugin_is_one_warning() -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for _ in range(2):
            assert BASELINES.foreign() == ("tones",)
            with pytest.raises(KeyError):
                BASELINES["gone"]
    told = [str(entry.message) for entry in caught]
    assert len(told) == 3
    assert any(
        text == "plugin 'gone' of broken-pack (methods) is left out: ModuleNotFoundError: No "
        "module named 'no_such_module'; update or remove broken-pack"
        for text in told
    )
    assert any(
        "'other' is <function run" in text and "expected a Baseline" in text for text in told
    )
    assert any("'renamed' calls itself 'tones': give it one name" in text for text in told)


@pytest.mark.usefixtures("broken")
def test_a_broken_plugin_is_a_line_and_stops_nothing(
    stills: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = ["benchmark", str(stills), "--methods", "tones", "--cues", "all", "-k", "2"]
    where = ["--processes", "2", "--no-plots", "-o", str(tmp_path / "out")]
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        assert run([*given, *where]) == 0
        lines = capsys.readouterr().err.splitlines()
        assert run(["segment", str(stills), "--method", "gone", "-o", str(tmp_path / "o")]) == 2
    # Each once, and not by the workers again.
    told = sorted(line for line in lines if "plugin" in line)
    starts = [f"geohue: warning: plugin '{name}' of broken-pack (methods)" for name in BROKEN]
    assert [line.split(" is left out")[0] for line in told] == sorted(starts)
    error = capsys.readouterr().err
    assert error.startswith("geohue: error: --method gone: choose one of nncsc, kmeans")
    assert error.count("\n") == 1


def test_a_registry_takes_each_name_once() -> None:
    registry = Registry("colors", {"red": 1}, lambda value: isinstance(value, int), "a number")
    registry.add("blue", 2)
    for name in ("red", "blue", ""):
        with pytest.raises(GeohueError, match="the name is taken or empty"):
            registry.add(name, 3)
    with pytest.raises(GeohueError, match="colors 'green' is 'x': expected a number"):
        registry.add("green", "x")  # type: ignore[arg-type]
    assert (dict(registry), len(registry)) == ({"red": 1, "blue": 2}, 2)
    registry.remove("blue")
    registry.remove("red")  # ours stay
    assert list(registry) == ["red"]
    assert "green" not in registry
    assert set(KINDS) == {
        *("methods", "cues", "voters", "presets"),
        *("clouds", "layouts", "sensors"),
    }
