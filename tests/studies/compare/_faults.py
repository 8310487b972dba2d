"""Cells that go wrong, importable by the processes of a crew."""

from __future__ import annotations

import os
import signal
import time

from geohue.studies.compare.cells import Cell, Result
from geohue.studies.compare.run import Task, run_cell


def faulty_cell(task: Task, cell: Cell) -> Result:
    """Run a cell; k-means raises, mean shift is killed, Felzenszwalb never ends."""
    if cell.method == "kmeans":
        raise RuntimeError("<b>no &\nluck</b>")
    if cell.method == "meanshift":
        os.kill(os.getpid(), signal.SIGKILL)
    if cell.method == "felzenszwalb":
        time.sleep(600)
    return run_cell(task, cell)


def always_fails(task: Task, cell: Cell) -> Result:
    """Run no cell."""
    raise ValueError(f"{cell.name} with K {task.k}")


def work(job: str) -> tuple[str, int]:
    """Do what a job says; returns it with the process that did it."""
    if job == "raise":
        raise KeyError("gone")
    if job == "exit":
        os._exit(3)
    if job == "kill":
        os.kill(os.getpid(), signal.SIGKILL)
    if job == "sleep":
        time.sleep(600)
    if job == "unsendable":
        return lambda: 0, 1  # type: ignore[return-value]
    return job, os.getpid()
