"""Run the cells of a plate on a scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from time import process_time
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from geohue.compute.parallel import cores, workers
from geohue.errors import GeohueError
from geohue.jobs.pool import check_timeout, run_jobs
from geohue.ncut.cutter import Cutter
from geohue.prepared import prepare_scene
from geohue.scene import Scene
from geohue.segmentation.arguments import Count, SegmentArguments
from geohue.segmentation.clusterers import check_method
from geohue.segmentation.driver import segment
from geohue.segmentation.result import Segmentation
from geohue.settings import PAPER_METHOD, preset_named
from geohue.studies.compare.cells import Cell, Comparison, Result, plan_cells

TIMEOUT = 600.0
"""Seconds that a cell may take."""

_MOST_PROCESSES = 4  # each has a copy of the scene
_REHEARSAL = 600  # points


@dataclass(frozen=True, slots=True, eq=False)
class Shared:
    """What all cells have in common; sent once to each process."""

    scene: Scene
    truth: NDArray[np.integer] | None
    k: int
    preset: str
    seed: int
    k_chosen: bool = False


def compare(
    scene: Scene,
    methods: Sequence[str] | None = None,
    cues: Sequence[str] | None = None,
    k: int | Literal["auto"] = "auto",
    *,
    truth: NDArray[np.integer] | None = None,
    preset: str = "paper",
    seed: int = 0,
    processes: int | None = None,
    timeout: float = TIMEOUT,
    progress: Callable[[int, int, Result], None] | None = None,
) -> Comparison:
    """Segment a scene by every method on every cue.

    Parameters
    ----------
    scene : Scene
    methods : sequence of str, optional
        The rows of the plate: methods of `geohue.segment`, and its presets that merge regions; by
        default "best" and all methods.
    cues : sequence of str, optional
        Its columns, each as ``cues=`` of `geohue.segment`; by default `cue_columns`.
    k : int or "auto"
        Number of segments for the methods that are told it; "auto" is chosen once, by the
        proposed method on colour and geometry alike, and the same for all but the presets, which
        find their own; of a given K they take the level.
    truth : (H, W) or (N,) integer, optional
        True labels, 0 for none: adds VoI, RI and the other measures.
    preset : str
        Settings of the proposed method and of what all share (`geohue.segment`).
    seed : int
        The source of chance.
    processes : int, optional
        How many cells at a time, each in a process with one thread; by default one a core, at
        most four.
    timeout : float
        Seconds for one cell, after which it has failed.
    progress : callable, optional
        Called after each cell with the number of cells done, their number in all, and the last one.

    Returns
    -------
    Comparison
        A method that fails, dies or takes too long is a failed cell; the others are not affected.

    Raises
    ------
    GeohueError
        For a bad argument, or a scene on which K cannot be chosen.

    Notes
    -----
    Processes are spawned: a script must call this below ``if __name__ == "__main__":``.
    """
    cells = plan_cells(methods, cues)
    SegmentArguments(k=k, preset=preset, seed=seed)  # checks them
    _check(scene, truth, processes)
    check_timeout(timeout)
    chosen = choose_count(scene, preset, seed) if k == "auto" else k
    found = {cell: result for cell in cells if (result := _undefined(cell, scene)) is not None}
    todo = [cell for cell in cells if cell not in found]
    if not todo:
        raise GeohueError(next(iter(found.values())).reason)
    work = partial(run_cell, Shared(scene, truth, chosen, preset, seed, k == "auto"))
    together = min(processes or min(cores(), _MOST_PROCESSES), len(todo))
    for count, outcome in enumerate(run_jobs(work, todo, together, timeout=timeout), start=1):
        cell = outcome.job
        found[cell] = outcome.result or Result(cell, "failed", outcome.reason)
        if progress is not None:
            progress(count, len(todo), found[cell])
    results = tuple(found[cell] for cell in cells)
    return Comparison(results, chosen, k == "auto", preset, seed, scene.warnings)


def run_cell(shared: Shared, cell: Cell) -> Result:
    """Segment the scene by one cell, with one thread."""
    scene = shared.scene
    # A rehearsal on a few points loads libraries and compiles, so that it is not in the time.
    with suppress(Exception):
        _segment(shared, scene.take(scene.thinning(_REHEARSAL, np.random.default_rng(0))), cell)
    start = process_time()
    seg = _segment(shared, scene, cell)
    seconds = process_time() - start
    scores: Mapping[str, float] = {}
    if shared.truth is not None:
        from geohue.measures import evaluate

        scores = evaluate(seg.labels, shared.truth)
    return Result.of(cell, seg, seconds, scores, scene.warnings)


def _segment(shared: Shared, scene: Scene, cell: Cell) -> Segmentation:
    same: dict[str, Any] = {"cues": cell.cues, "seed": shared.seed, "threads": 1}
    if cell.merges:
        k: Count = "auto" if shared.k_chosen else shared.k
        return segment(scene, k, preset=cell.method, **same)
    return segment(scene, shared.k, preset=shared.preset, method=cell.method, **same)


def choose_count(scene: Scene, preset: str = "paper", seed: int = 0) -> int:
    """Choose K as the proposed method does: on the draft, colour and geometry alike."""
    settings, fused = preset_named(preset), bool(scene.valid.any())
    with workers() as team:
        prepared = prepare_scene(scene, settings, "fusion" if fused else "color", seed, team)
        return Cutter(prepared, settings.cut.k_max).choose_k(1.0 if fused else 0.0)


def _undefined(cell: Cell, scene: Scene) -> Result | None:
    try:
        check_method(PAPER_METHOD if cell.merges else cell.method, cell.cues, scene.is_grid)
    except GeohueError as error:
        return Result(cell, "undefined", str(error))
    return None


def _check(
    scene: Scene,
    truth: NDArray[np.integer] | None,
    processes: int | None,
) -> None:
    if truth is not None and truth.shape != scene.shape:
        raise GeohueError(
            f"the ground truth has shape {truth.shape}, the scene {scene.shape}: "
            "give labels of the same frame"
        )
    if processes is not None and processes < 1:
        raise GeohueError(f"processes is {processes}: expected at least 1")
