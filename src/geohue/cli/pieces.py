"""``geohue segment`` for clouds that do not fit in memory."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from geohue.cli.clock import passed
from geohue.cli.console import print_json, warn, when_stopped
from geohue.cli.jobs import check_place
from geohue.cli.options import SegmentOptions
from geohue.errors import GeohueError
from geohue.segmentation.words import told
from geohue.settings import PAPER_METHOD

if TYPE_CHECKING:
    from geohue.large.stages import Progress

_STAGES = {
    "measure": "measuring",
    "fit": "splitting a sample",
    "label": "labelling",
    "sort": "sorting into tiles",
    "split": "splitting tiles",
}


def too_large(source: Path | None) -> str | None:
    """Return what to tell the user of a cloud that would not fit in memory, else None."""
    if source is None or not source.is_file():
        return None
    from geohue.read.clouds.chunks import CHUNKED_SUFFIXES, open_chunks

    if source.suffix.lower() not in CHUNKED_SUFFIXES:
        return None
    from geohue.large.memory import MB, available_memory, needed_in_memory

    available = available_memory()
    # Most files are small: those need no second look.
    if available is None or needed_in_memory(source.stat().st_size) < available:
        return None
    try:
        n_points = open_chunks(source).n_points
    except GeohueError:
        return None  # the usual reader says what is wrong, or reads it
    needed = needed_in_memory(n_points)
    if needed < available:
        return None
    return (
        f"{source}: {n_points} points would take {needed // MB} MB and {available // MB} MB are "
        "free: reading it in pieces, as --memory does"
    )


def segment_pieces(
    source: Path | None,
    out: Path | None,
    how: SegmentOptions,
    memory: str | None,
    processes: int | None,
    scheduler: str | None,
    resume: bool,
    formats: tuple[str, ...],
    lean: bool,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Split a cloud in two passes over its file."""
    check_place(processes, scheduler)
    wanted = how.values()
    if source is None:
        raise GeohueError("no cloud: --memory, --processes, --scheduler and --resume need one")
    if as_json and out is None:
        raise GeohueError("--json with --memory: give the folder of the labels with -o")
    folder = out or Path("geohue-out")
    kept = f"what is done is kept in {folder}; the same command with --resume goes on"
    with when_stopped(kept), pass_bar() as progress:
        from geohue.large import segment_file

        found = segment_file(
            source,
            folder,
            **{name: wanted[name] for name in ("k", "weight", "preset", "cues", "seed", "detail")},
            memory=memory,
            processes=processes,
            scheduler=scheduler,
            resume=resume,
            formats=formats,
            lean=lean,
            overwrite=overwrite,
            progress=progress,
        )
    warn(found.warnings)
    if as_json:
        print_json(found.summary())
    else:
        merged = found.levels is not None
        line = told(found.k, found.weight, PAPER_METHOD, how.cues, merged=merged)
        typer.echo(f"{line}, {passed():.1f} s")
    names = ", ".join(sorted(file.name for file in folder.iterdir() if file.is_file()))
    typer.echo(f"{folder}: {names}", err=as_json)


@contextmanager
def pass_bar() -> Iterator[Progress]:
    """Show a progress bar for each pass on standard error."""
    from rich.console import Console
    from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bars

    columns = (
        TextColumn("{task.description:18}"),
        BarColumn(),
        TaskProgressColumn(),
        TextColumn("of {task.total:,.0f} points"),
        TimeRemainingColumn(),
    )
    bars = Bars(*columns, console=Console(stderr=True))
    tasks: dict[str, Any] = {}

    def advance(stage: str, done: int, total: int) -> None:
        bars.start()
        if stage not in tasks:
            tasks[stage] = bars.add_task(_STAGES[stage], total=total)
        bars.update(tasks[stage], completed=done)

    try:
        yield advance
    finally:
        if tasks:
            bars.stop()
