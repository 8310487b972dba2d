"""The stages of a run: measure all, decide on the sample, label all."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeVar

import numpy as np

from geohue.compute.parallel import workers
from geohue.errors import GeohueError
from geohue.jobs.pool import Outcome, run_jobs
from geohue.large.fit import Decision, Fitted, fit
from geohue.large.moments import Moments, merge
from geohue.large.passes import JOB, LabelJob, MeasureJob, Target, label, measure
from geohue.large.sample import SAMPLE, sample_positions
from geohue.large.state import State
from geohue.large.targets import clear_parts, prepare
from geohue.read.clouds.chunk import Chunks
from geohue.read.files import broken
from geohue.scene import Scene
from geohue.segmentation.arguments import Weight
from geohue.segmentation.result import StageClock
from geohue.settings import Preset

WORTH = 10
"""Stretches that pay for the start of a process: it takes as long as five of them."""

Progress = Callable[[str, int, int], None]
"""Called with the stage (measure, fit or label), and the points done and in all."""

Job = TypeVar("Job", MeasureJob, LabelJob)
Result = TypeVar("Result")


@dataclass(frozen=True, slots=True)
class Question:
    """What is asked of a cloud: everything that its labels depend on.

    Attributes
    ----------
    k, weight, cues, seed
        As for `geohue.segment`.
    settings : Preset
        The settings.
    """

    k: int | Literal["auto"]
    weight: Weight
    settings: Preset
    cues: str
    seed: int


@dataclass(frozen=True, slots=True)
class JobRunner:
    """Who does the jobs of a pass, and who is told.

    Attributes
    ----------
    processes : int
        How many work at a time on this machine; with 1 the calling process does.
    scheduler : str or None
        Address of a dask scheduler whose workers do them instead.
    progress : callable or None
        Told of every stretch that is done.
    """

    processes: int
    scheduler: str | None
    progress: Progress | None

    def complete(
        self, stage: str, function: Callable[[Job], Result], jobs: Sequence[Job], n_points: int
    ) -> Iterator[tuple[Job, Result]]:
        """Yield each job with its result as it ends, failed ones after a second try.

        Raises
        ------
        GeohueError
            At the end, if some failed twice.
        """
        done = n_points - sum(job.stop - job.start for job in jobs)
        self.tell(stage, done, n_points)
        rest, failed = jobs, list[Outcome[Job, Result]]()
        for _ in range(2):
            processes, failed = min(self.processes, max(1, -(-len(rest) // WORTH))), []
            for outcome in run_jobs(function, rest, processes, self.scheduler):
                if outcome.result is None:
                    failed.append(outcome)
                    continue
                done += outcome.job.stop - outcome.job.start
                self.tell(stage, done, n_points)
                yield outcome.job, outcome.result
            rest = [outcome.job for outcome in failed]
        if failed:
            first = failed[0]
            raise GeohueError(
                f"{len(failed)} of {len(jobs)} stretches failed, the first at point "
                f"{first.job.start} ({first.reason}); the others are kept: mend it and go on with "
                "--resume"
            )

    def tell(self, stage: str, done: int, n_points: int) -> None:
        """Report progress."""
        if self.progress is not None:
            self.progress(stage, done, n_points)


def measure_all(source: Chunks, state: State, question: Question, runner: JobRunner) -> Moments:
    """Measure every stretch that was not; returns the moments of the whole."""
    rows = sample_positions(source.n_points, SAMPLE, question.seed)
    slots = {
        start: slice(*np.searchsorted(rows, (start, stop)))
        for start, stop in stretches(source.n_points)
    }
    known = state.measured()
    jobs = [
        MeasureJob(source, start, stop, question.cues, rows[slots[start]])
        for start, stop in stretches(source.n_points)
        if start not in known
    ]
    for job, (moments, sample) in runner.complete("measure", measure, jobs, source.n_points):
        state.add_measured(job.start, moments, slots[job.start].start, sample, len(rows))
    known = state.measured()
    return merge(known[start] for start, _ in stretches(source.n_points))


def decide(
    source: Chunks,
    state: State,
    moments: Moments,
    question: Question,
    clock: StageClock,
    runner: JobRunner,
) -> tuple[Fitted, Decision]:
    """Fit the cut on the sample, or return the one that was."""
    kept = state.fit()
    if kept is not None:
        return kept
    runner.tell("fit", 0, source.n_points)
    sample = state.sample()
    if moments.count == 0 or not (
        question.cues == "color" or np.isfinite(sample["xyz"]).all(1).any()
    ):
        raise broken(source.path, "has (almost) no point with finite coordinates; export it again")
    scene = Scene.from_cloud(sample["xyz"], sample["rgb"])
    with workers() as team:
        fitted, decision = fit(
            scene,
            sample["xyz"],
            moments,
            question.k,
            question.weight,
            question.settings,
            question.cues,
            question.seed,
            team,
            clock,
        )
    state.keep_fit(fitted, decision)
    runner.tell("fit", source.n_points, source.n_points)
    return fitted, decision


def label_all(
    source: Chunks,
    state: State,
    fitted: Fitted,
    targets: dict[Path, tuple[Target, bytes]],
    runner: JobRunner,
) -> list[int]:
    """Label every stretch that was not; returns the points of each segment, and of none last."""
    done = state.labelled()
    starts = [start for start, _ in stretches(source.n_points)]
    parts = [target for target, _ in targets.values()]
    # A file that has lost its temporary name is whole, once all stretches are done.
    whole = len(done) == len(starts) and all(
        target.path.exists() or file.exists() for file, (target, _) in targets.items()
    )
    if not done or not (whole or all(part.path.exists() for part in parts)):
        done = {}
        state.forget_labelled()
        clear_parts(state.folder.parent)
        for target, head in targets.values():
            prepare(target, head, source.n_points)
    jobs = [
        LabelJob(source, start, stop, fitted, tuple(parts))
        for start, stop in stretches(source.n_points)
        if start not in done
    ]
    for job, counts in runner.complete("label", label, jobs, source.n_points):
        state.add_labelled(job.start, counts)
    done = state.labelled()
    return [int(n) for n in np.sum([done[start] for start in starts], axis=0)]


def stretches(n_points: int) -> Iterator[tuple[int, int]]:
    """Yield start and stop of each job's stretch."""
    for start in range(0, n_points, JOB):
        yield start, min(start + JOB, n_points)
