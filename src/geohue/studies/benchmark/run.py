"""The benchmark: many frames through many methods, resumable, one failure at a time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.jobs.ledger import Row
from geohue.jobs.run import Place, Progress, Table, run_table
from geohue.measures.crop import Crop
from geohue.results.labels import write_labels
from geohue.scene import Scene
from geohue.segmentation.arguments import SegmentArguments
from geohue.studies.benchmark.frames import find_frames, load_frame
from geohue.studies.benchmark.trials import Conditions, Trial, answer, scores
from geohue.studies.items import Item

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
class Measurement:
    """One frame for one trial."""

    frame: Item
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


_LAST: dict[str, Any] = {}  # the frame that this process has loaded last: trials follow each other


def _loaded(frame: Item, crop: Crop | None) -> tuple[Scene, NDArray[np.int32]]:
    state = frame.name, crop, frame.ages()  # files may change between the runs of a worker
    if _LAST.get("state") != state:
        _LAST.clear()
        _LAST.update(loaded=load_frame(frame, crop), state=state)
    loaded: tuple[Scene, NDArray[np.int32]] = _LAST["loaded"]
    return loaded


def measure(job: Measurement) -> dict[str, Any]:
    """Segment a frame, write its labels, and return its scores."""
    scene, truth = _loaded(job.frame, job.crop)
    given = answer(job.trial, scene, job.conditions)
    write_labels(job.labels_name, given.labels)
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
    timeout: float | None = None,
    resume: bool = False,
    progress: Progress | None = None,
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
    timeout : float, optional
        Seconds that a frame may take, after which it has failed; not with a scheduler.
    resume : bool
        Go on with what is in `out`: rows that are there are kept, failures tried once more.
    progress : callable, optional
        Called with the number of jobs done, their number in all, and a line about the last.

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
        {**asdict(chosen), "crop": None if crop is None else list(crop)},
        measure,
        [Measurement(frame, trial, chosen, crop, target) for frame in frames for trial in trials],
        Place(processes, scheduler, timeout),
        resume=resume,
        progress=progress,
    )
