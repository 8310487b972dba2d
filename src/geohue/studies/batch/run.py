"""The batch: each frame's results in a folder of its own, and a table of all."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

from geohue.errors import GeohueError
from geohue.jobs.ledger import Row
from geohue.jobs.run import SETTINGS, Place, Progress, Table, run_table
from geohue.results.outputs import write_results
from geohue.segmentation.driver import segment
from geohue.studies.batch.settings import Settings
from geohue.studies.items import Item

TABLE = "batch.csv"
KEYS = ("name",)
FIELDS = (*KEYS, "k", "weight", "quality", "n_points", "n_labelled", "seconds", "error")


@dataclass(frozen=True, slots=True)
class Task:
    """One scene, and where its results go."""

    item: Item
    settings: Settings
    out: Path

    @property
    def key(self) -> tuple[str, ...]:
        """The name of its row."""
        return (self.item.name,)


def run_task(task: Task) -> dict[str, Any]:
    """Segment a scene, write its results, and return its row."""
    if not (task.out / SETTINGS).is_file():
        raise GeohueError(
            f"{task.out}: is not on the worker's machine; all need the same file system"
        )
    start = perf_counter()
    scene = task.item.read()
    seg = segment(scene, **task.settings.as_dict(), threads=1)
    folder, chosen = task.out / task.item.name, task.settings
    write_results(folder, scene, seg, chosen.formats, lean=chosen.lean)
    return {
        "k": seg.k,
        "weight": None if math.isnan(seg.weight) else seg.weight,
        "quality": seg.quality,
        "n_points": seg.n_points,
        "n_labelled": seg.n_labelled,
        "seconds": round(perf_counter() - start, 4),
    }


def batch(
    items: Sequence[Item],
    out: str | Path,
    settings: Settings | None = None,
    *,
    source: Mapping[str, Any] | None = None,
    processes: int = 1,
    scheduler: str | None = None,
    timeout: float | None = None,
    resume: bool = False,
    progress: Progress | None = None,
) -> list[Row]:
    """Segment many scenes.

    Parameters
    ----------
    items : sequence of Item
        The scenes (`find_items`).
    out : str or Path
        Receives a folder for each scene (`geohue.results.outputs.write_results`), ``batch.csv``, a
        row a scene, and ``run.json``: the settings, the version and the machine.
    settings : Settings, optional
    source : mapping, optional
        What names the scenes' origin, ready for JSON: those of different ones do not mix in `out`.
    processes : int
        How many work at a time, each with one thread.
    scheduler : str, optional
        A dask scheduler whose workers do it instead (`geohue.jobs.pool.run_jobs`).
    timeout : float, optional
        Seconds that a scene may take, after which it has failed; not with a scheduler.
    resume : bool
        Go on with what is in `out`: scenes that are done are kept, failures tried once more.
    progress : callable, optional
        Called with the number of scenes done, their number in all, and a line about the last.

    Returns
    -------
    list of dict of str to str
        The rows of ``batch.csv``, in the order of `items`; ``error`` is not empty where a scene
        failed.

    Raises
    ------
    GeohueError
        If `out` has a run and `resume` is not set, that run had other settings or is under way,
        or the scheduler is of no use.

    Examples
    --------
    >>> import numpy as np
    >>> from geohue.results.png import write_png
    >>> folder = getfixture("tmp_path")
    >>> write_png(folder / "a.png", np.tile(np.uint8([[[0, 0, 0], [250, 9, 9]]]), (20, 10, 1)))
    >>> rows = batch([Item("a", folder / "a.png")], folder / "out", Settings(k=2, cues="color"))
    >>> rows[0]["k"], rows[0]["error"]
    ('2', '')
    """
    target = Path(out).absolute()
    chosen = settings or Settings()
    return run_table(
        target,
        Table(TABLE, FIELDS, KEYS),
        {**(source or {}), **chosen.for_json()},
        run_task,
        [Task(item, chosen, target) for item in items],
        Place(processes, scheduler, timeout),
        resume=resume,
        progress=progress,
    )
