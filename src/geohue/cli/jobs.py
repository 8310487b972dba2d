"""What commands with many jobs share: where they run, and the bar that counts them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Annotated

import typer

from geohue.cli import options
from geohue.errors import GeohueError


@dataclass(frozen=True, slots=True, kw_only=True)
class JobOptions:
    """Which frames of a folder, where they are worked on, and whether a run goes on."""

    limit: Annotated[
        int | None, typer.Option(help="Only so many frames, spread evenly over all.")
    ] = None
    processes: Annotated[
        int | None,
        typer.Option(
            help="Processes, each with one thread; by default one a core, for benchmark one."
        ),
    ] = None
    scheduler: options.Scheduler = None
    timeout: Annotated[
        float | None,
        typer.Option(metavar="SECONDS", help="Longest time for a frame, which then has failed."),
    ] = None
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the run in DIR.")] = False

    def check(self) -> None:
        """Raise an error unless at most one option says where to work (`check_place`)."""
        check_place(self.processes, self.scheduler)


def check_place(processes: int | None, scheduler: str | None) -> None:
    """Raise an error unless at most one of the two says where to work."""
    if processes is not None and processes < 1:
        raise GeohueError(f"--processes {processes}: expected at least 1")
    if processes is not None and scheduler is not None:
        raise GeohueError("--processes and --scheduler both say where to work: give one")


@contextmanager
def job_bar() -> Iterator[Callable[[int, int, str], None]]:
    """Show a progress bar on standard error, and every failure as a line above it."""
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )

    name = TextColumn("{task.description}", markup=False)  # which may have brackets
    columns = (BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), name)
    with Progress(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task("starting", total=None)

        def advance(done: int, total: int, text: str) -> None:
            job, _, error = text.partition(": ")
            bar.update(task, completed=done, total=total, description=job)
            if error:
                bar.console.print(
                    f"geohue: warning: {text}", markup=False, highlight=False, soft_wrap=True
                )

        yield advance
