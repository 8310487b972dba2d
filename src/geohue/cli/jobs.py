"""What commands with many jobs share: where they run, and the bar that counts them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from geohue.errors import GeohueError


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
