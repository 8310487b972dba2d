"""Cells that go wrong, importable by the processes of a crew."""

from __future__ import annotations

import os
import signal
import time

from geohue.studies.compare.cells import Cell, Result
from geohue.studies.compare.run import Shared, run_cell


def faulty_cell(shared: Shared, cell: Cell) -> Result:
    """Run a cell; k-means raises, mean shift is killed, Felzenszwalb never ends."""
    if cell.method == "kmeans":
        raise RuntimeError("<b>no &\nluck</b>")
    if cell.method == "meanshift":
        os.kill(os.getpid(), signal.SIGKILL)
    if cell.method == "felzenszwalb":
        time.sleep(600)
    return run_cell(shared, cell)


def always_fails(shared: Shared, cell: Cell) -> Result:
    """Run no cell."""
    raise ValueError(f"{cell.name} with K {shared.k}")
