"""The benchmark: many frames through many methods, resumable, one failure at a time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue._version import __version__
from geohue.jobs.ledger import Row
from geohue.jobs.run import Place, Table, run_table
from geohue.measures.crop import Crop
from geohue.results.labels import write_labels
from geohue.scene import Scene
from geohue.segmentation.arguments import SegmentArguments
from geohue.studies.benchmark.frames import Frame, find_frames, load_frame
from geohue.studies.benchmark.trials import Conditions, Trial, answer, scores
from geohue.studies.machine import describe_machine

TABLE = "frames.csv"
LABELS = "labels"

KEYS = ("frame", "method", "cues", "preset")
MEASURES = (
    "k",
    "weight",
    "quality",
    "labelled",
    "voi_bits",
    "voi_nats",
    "over_bits",
    "under_bits",
    "rand",
    "adjusted_rand",
    "covering",
    "undersegmentation_error",
    "boundary_precision",
    "boundary_recall",
    "boundary_f",
    "boundary_displacement",
    "n_pred",
    "n_gt",
    "n_pixels",
    "seconds",
)
FIELDS = (*KEYS, *MEASURES, "error")


@dataclass(frozen=True, slots=True)
class Cell:
    """One frame for one trial."""

    frame: Frame
    trial: Trial
    conditions: Conditions
    crop: Crop | None
    out: Path

    @property
    def key(self) -> tuple[str, ...]:
        """The name of its row."""
        return (self.frame.name, self.trial.method, self.trial.cues, self.trial.preset)

    @property
    def labels_name(self) -> Path:
        """Where its labels go, without the ending (`write_labels`)."""
        return self.out / LABELS / self.trial.name / self.frame.name


@lru_cache(maxsize=1)
def _loaded(
    frame: Frame,
    crop: Crop | None,
    ages: tuple[int, ...],  # noqa: ARG001  # files may change between the runs of a worker
) -> tuple[Scene, NDArray[np.int32]]:
    return load_frame(frame, crop)


def _ages(frame: Frame) -> tuple[int, ...]:
    """Return when each file of a frame was written last (ns; 0 for one that has gone)."""
    files = (frame.color, frame.depth, frame.labels, frame.intrinsics)
    return tuple(f.stat().st_mtime_ns if f.exists() else 0 for f in files if f is not None)


def run_cell(cell: Cell) -> dict[str, Any]:
    """Segment a frame, write its labels, and return its scores."""
    scene, truth = _loaded(cell.frame, cell.crop, _ages(cell.frame))
    given = answer(cell.trial, scene, cell.conditions)
    write_labels(cell.labels_name, given.labels)
    return scores(given, truth)


def benchmark(
    folder: str | Path,
    out: str | Path,
    trials: Sequence[Trial],
    conditions: Conditions | None = None,
    *,
    crop: Crop | None = None,
    limit: int | None = None,
    processes: int = 1,
    scheduler: str | None = None,
    resume: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> list[Row]:
    """Run every trial on every frame of a folder.

    Parameters
    ----------
    folder : str or Path
        Frames (`find_frames`).
    out : str or Path
        Receives ``frames.csv``, a row a frame and trial; ``labels/``, and ``run.json``: the
        settings, the version and the machine.
    trials : sequence of Trial
        See `plan`.
    conditions : Conditions, optional
    crop : (top, bottom, left, right), optional
        The part of each frame to use (`load_frame`).
    limit : int, optional
        Use only so many frames, spread evenly over all.
    processes : int
        How many work at a time, each with one thread.
    scheduler : str, optional
        A dask scheduler whose workers do it instead (`geohue.jobs.pool.run_jobs`).
    resume : bool
        Go on with what is in `out`: rows that are there are kept, failures tried once more.
    progress : callable, optional
        Called with the number of cells done, their number in all, and a line about the last.

    Returns
    -------
    list of dict of str to str
        The rows of ``frames.csv``, frame by frame; ``error`` is not empty where a trial failed.

    Raises
    ------
    GeohueError
        For a bad argument, or if there are no frames, `out` has a run and `resume` is not set, or
        that run had other settings or is under way.
    """
    # Workers of a cluster start in other folders: they need names that hold everywhere.
    place = Path if scheduler is None else Path.absolute
    target = place(Path(out))
    frames = find_frames(place(Path(folder)), limit)
    chosen = conditions or Conditions()
    SegmentArguments(k=chosen.k, seed=chosen.seed)  # checks them
    return run_table(
        target,
        Table(TABLE, FIELDS, KEYS),
        _settings(chosen, crop),
        {"machine": describe_machine()},
        run_cell,
        [Cell(frame, trial, chosen, crop, target) for frame in frames for trial in trials],
        Place(processes, scheduler),
        resume=resume,
        progress=progress,
    )


def _settings(conditions: Conditions, crop: Crop | None) -> dict[str, Any]:
    return {
        "version": __version__,
        **asdict(conditions),
        "crop": None if crop is None else list(crop),
    }
