"""The cases of the guard: what is timed in one fresh process, with one revision of geohue.

    PYTHONPATH=TREE/src python cases.py CASE FOLDER

Uses nothing but geohue as it stands in TREE, so that both revisions are asked the same. Prints
what was found as JSON; a revision that lacks what a case needs says so.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np

Run = Callable[[], Any]
LEAST_RUNS, LEAST_SECONDS = 3, 0.6


def _scene(folder: Path) -> Any:
    from geohue import Intrinsics, Scene

    with np.load(folder / "frame.npz") as frame:
        camera = Intrinsics(*frame["camera"].tolist())
        return Scene.from_rgbd(frame["rgb"], frame["depth"], camera)


def kernel(folder: Path) -> Run:
    """Affinities, degrees and eigenvectors: the fit of the cut on all points."""
    from geohue.features import extract_features
    from geohue.ncut.nystrom import nystrom_cut

    workers = _at("workers", "geohue.compute.parallel", "geohue.parallel")
    x = extract_features(_scene(folder)).mixed(1.0)
    landmarks = x[np.random.default_rng(0).choice(len(x), 100, replace=False)]

    def run() -> None:
        with workers() as team:
            nystrom_cut(x, landmarks, team, 5)

    return run


def cut(folder: Path) -> Run:
    """From features to labels, K and the weight given."""
    import geohue
    from geohue.features import extract_features
    from geohue.ncut.cutter import Cutter

    make: Any = Cutter  # another revision takes other arguments
    workers = _at("workers", "geohue.compute.parallel", "geohue.parallel")
    scene, settings = _scene(folder), geohue.Preset()
    features = extract_features(scene)
    try:
        from geohue.features import Raw
        from geohue.prepared import PreparedScene
    except ImportError:
        draft = scene.thinning(settings.draft_points, np.random.default_rng(0))

        def old() -> None:
            with workers() as team:
                make(features, draft, settings, team, 0, 5).labels(1.0, 5)

        return old

    def run() -> None:
        with workers() as team:
            prepared = PreparedScene.of(Raw(scene), features, settings, 0, team)
            make(prepared, 5).labels(1.0, 5)

    return run


def fill(folder: Path) -> Run:
    """The Appendix, on the pixels without depth and a large hole."""
    from geohue.features import lab_of
    from geohue.fill import fill_labels

    scene = _scene(folder)
    row, column = np.indices(scene.shape)
    labels = (4 * row // scene.shape[0] + 4 * (4 * column // scene.shape[1])).astype(np.int32)
    labels[~scene.valid] = -1
    labels[100:250, 200:400] = -1
    lab = lab_of(scene.colors)
    return lambda: fill_labels(labels, lab)


def _stage(preset: str, stage: str) -> Callable[[Path], Run]:
    """Return a case on one stage of `segment`, by its own clock."""

    def prepare(folder: Path) -> Run:
        import geohue

        scene = _scene(folder)
        return lambda: geohue.segment(scene, preset=preset).timings[stage]

    return prepare


def _at(name: str, *homes: str) -> Any:
    """Return a function from the first module that this revision has."""
    from importlib import import_module

    for home in homes:
        try:
            return getattr(import_module(home), name)
        except ModuleNotFoundError:
            continue
    raise ImportError(f"{name}: in none of {', '.join(homes)}")


def _reader(homes: tuple[str, ...], function: str, name: str) -> Callable[[Path], Run]:
    def prepare(folder: Path) -> Run:
        read = _at(function, *homes)
        return lambda: read(folder / name)

    return prepare


CASES: dict[str, Callable[[Path], Run]] = {
    "kernel": kernel,
    "cut": cut,
    "fill": fill,
    "weight search": _stage("paper", "weight"),
    "frame, paper": _stage("paper", "total"),
    "frame, fast": _stage("fast", "total"),
    "read PLY": _reader(("geohue.read.clouds.ply", "geohue.io.ply"), "read_ply", "cloud.ply"),
    "read LAS": _reader(("geohue.read.clouds.las", "geohue.io.las"), "read_las", "cloud.las"),
    "read depth PNG": _reader(
        ("geohue.read.images.pictures", "geohue.io.images"), "read_depth", "depth.png"
    ),
}


def timed(run: Run) -> float:
    """Return the median seconds of a run after a first one; a run may tell its own seconds."""
    run()
    found: list[float] = []
    while len(found) < LEAST_RUNS or sum(found) < LEAST_SECONDS:
        begin = perf_counter()
        own = run()
        found.append(own if isinstance(own, float) else perf_counter() - begin)
    return median(found)


def import_seconds(_: Path) -> float:
    """Return the seconds until the library and its driver are loaded."""
    begin = perf_counter()
    import geohue

    _ = geohue.segment  # type: ignore[assignment]
    return perf_counter() - begin


def command_seconds(_: Path) -> float:
    """Return the seconds until the command line is loaded."""
    begin = perf_counter()
    import geohue.cli  # noqa: F401

    return perf_counter() - begin


def peak_megabytes(folder: Path) -> float:
    """Return the peak memory of a process that segments a frame."""
    import resource

    import geohue

    geohue.segment(_scene(folder))
    unit = 2**20 if sys.platform == "darwin" else 2**10
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit


SINGLE: dict[str, Callable[[Path], float]] = {
    "import": import_seconds,
    "import command line": command_seconds,
    "peak memory of a frame (MB)": peak_megabytes,
}
"""Cases that only a fresh process can answer, once."""


def main() -> None:
    """Measure one case."""
    name, folder = sys.argv[1], Path(sys.argv[2])
    try:
        value = SINGLE[name](folder) if name in SINGLE else timed(CASES[name](folder))
        found: dict[str, Any] = {"value": value}
    except (ImportError, AttributeError, TypeError) as error:
        found = {"missing": f"{type(error).__name__}: {error}"}
    import geohue

    print(json.dumps(found | {"used": str(Path(geohue.__file__).parents[1])}))


if __name__ == "__main__":
    main()
