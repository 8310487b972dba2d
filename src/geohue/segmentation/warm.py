"""Every compiled loop, compiled ahead of the first user, or by two processes for a first run."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np

from geohue.baselines import BASELINES
from geohue.compute import ahead
from geohue.compute.parallel import Workers, cores
from geohue.scene import Scene
from geohue.segmentation.driver import segment
from geohue.settings import PRESETS, Preset

PARTS = {
    "merging": ("geohue.merge.greedy.run",),
    "borders": ("geohue.merge.borders.draw_cells",),
    "quality": tuple(
        f"geohue.weight.passes.{name}"
        for name in (
            "window_deviation",
            "add_colors",
            "window_interior",
            "add_texture",
            "add_distances",
        )
    ),
    "fill": ("geohue.fill.steps.start", "geohue.fill.steps.spread"),
    "systems": (),
}
"""What a helper compiles at a time, with the names of the loops that are waited for."""

_COMMAND = "from geohue.segmentation.warm import help_out; help_out()"


@contextmanager
def compiling_ahead(preset: str | Preset) -> Iterator[None]:
    """Let other processes compile what a preset needs last, if this is its first run.

    Parameters
    ----------
    preset : str or Preset
        The name of one of `PRESETS`; for another nothing is done.
    """
    names = _shares(preset) if isinstance(preset, str) and _is_first(preset) else []
    shares = [{name: PARTS[name] for name in share} for share in names]
    with ahead.helped(_COMMAND, shares):
        yield


def _shares(preset: str) -> list[tuple[str, ...]]:
    """The parts of each helper; this process needs a core, too."""
    parts = ("fill", "quality") if preset == "paper" else ("merging", "borders", "quality")
    shares: list[list[tuple[str, ...]]] = [[], [parts], [parts[:1], parts[1:]]]
    return shares[min(cores(), 3) - 1]


def _is_first(preset: str) -> bool:
    from geohue.compute.compiled import is_missing
    from geohue.fill.steps import spread
    from geohue.merge.greedy import run

    return preset in PRESETS.own and is_missing(spread if preset == "paper" else run)


def help_out() -> None:
    """Compile the parts that the command line names, and print each that is there."""
    import sys

    for name in sys.argv[1:]:
        COMPILE[name]()
        sys.stdout.write(f"{name}\n")
        sys.stdout.flush()


def _compile_merging() -> None:
    from geohue.merge.cues import NAMES
    from geohue.merge.greedy import merge_all
    from geohue.merge.table import BORDER_COLUMNS, REGION_COLUMNS, Table

    sums = (np.ones((2, REGION_COLUMNS)), np.ones((2, 1)), np.ones((1, BORDER_COLUMNS)))
    merge_all(Table(*sums, np.array([[0, 1]]), np.ones(3)), np.zeros(len(NAMES) + 1))


def _compile_borders() -> None:
    from geohue.merge.borders import draw_borders

    at, regions = np.arange(2), np.zeros((2, 2), np.int32)
    values = np.zeros((2, 2, 4), np.float32)
    draw_borders(regions, np.zeros(1, np.int32), at, at, values, Workers(None))


def _compile_quality() -> None:
    from geohue.weight.quality import QualityMetric

    scene = Scene.from_rgbd(np.zeros((4, 4, 3), np.uint8), np.ones((4, 4)))
    QualityMetric(scene)(np.arange(16, dtype=np.int32).reshape(4, 4) // 8)


def _compile_fill() -> None:
    from geohue.fill import fill_labels

    fill_labels(np.array([[0, -1, 1]]), np.zeros((1, 3, 3), np.float32))


def _compile_systems() -> None:
    for method, baseline in BASELINES.own.items():
        segment(_small_scene(), k=3, method=method, cues=baseline.cues[0])


COMPILE: dict[str, Callable[[], None]] = {
    "merging": _compile_merging,
    "borders": _compile_borders,
    "quality": _compile_quality,
    "fill": _compile_fill,
    "systems": _compile_systems,
}
"""How each of `PARTS` is compiled: by its use on next to nothing."""


def compile_all() -> None:
    """Compile every loop by running every method on a small scene, so that no user waits for it.

    For images of machines and the like: what is compiled is kept in the folder that
    ``NUMBA_CACHE_DIR`` names, else beside the code, else in the user's cache.
    """
    scene = _small_scene()
    shares = [{"systems": PARTS["systems"]}] if cores() > 1 else []
    with ahead.helped(_COMMAND, shares):
        for preset in PRESETS.own:
            segment(scene, preset=preset)
            segment(scene, k=3, preset=preset)
        points = Scene.from_cloud(scene.points[scene.valid], scene.colors[scene.valid])
        segment(points, k=3)
        ahead.finish()
    _compile_systems()


def _small_scene() -> Scene:
    """Three planes with a gap, and a point far from all others, which takes a loop of its own."""
    part = np.arange(48) // 16
    rgb = np.random.default_rng(0).integers(0, 40, (36, 48, 3), np.uint8)
    rgb[..., 0] += (60 * part).astype(np.uint8)
    depth = np.tile(1.0 + part, (36, 1)).astype(np.float32)
    depth[10:20, 10:20] = np.nan
    depth[0, 0] = 90.0
    return Scene.from_rgbd(rgb, depth)
