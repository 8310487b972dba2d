"""``geohue compare``: every method on one scene, side by side."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from geohue.cli import options, scenes
from geohue.cli.console import print_json, warn, whole_or_auto
from geohue.cli.groups import with_groups
from geohue.errors import GeohueError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from geohue.studies.compare import Comparison, Result


@with_groups
def compare(
    *,
    given: options.SceneOptions,
    methods: Annotated[
        str,
        typer.Option(
            "--methods",
            "--method",
            metavar="A,B,..",
            help="The rows: best, fast, methods; or all (but fast).",
        ),
    ] = "all",
    cues: Annotated[
        str, typer.Option(metavar="A,B,..", help="The columns: fusion, color, geometry, or all.")
    ] = "all",
    k: Annotated[
        str,
        typer.Option(
            "-k", metavar="auto|INT", help="Number of segments, for methods that take it."
        ),
    ] = "auto",
    gt: Annotated[
        Path | None,
        typer.Option(
            metavar="LABELS",
            help="True labels: PNG (0 = none), NPY or a labelled cloud (-1 = none).",
        ),
    ] = None,
    preset: Annotated[
        str,
        typer.Option(metavar="best|fast|paper", help="Settings of the rows that are methods."),
    ] = "paper",
    seed: options.Seed = 0,
    processes: Annotated[
        int | None, typer.Option(help="Cells at a time; by default one a core, at most 4.")
    ] = None,
    timeout: Annotated[
        float, typer.Option(metavar="SECONDS", help="Longest time for a cell.")
    ] = 600.0,
    out: Annotated[
        Path | None,
        typer.Option(
            "-o", "--out", metavar="DIR", help="Where results go; by default geohue-compare."
        ),
    ] = None,
    overwrite: options.Overwrite = False,
    as_json: options.AsJson = False,
) -> None:
    """Run the default and every method on one scene, and draw the results side by side.

    Scenes are given as to geohue segment. Writes plate.png (rows are methods, columns cues),
    compare.html with the pictures and figures, compare.csv, compare.json and the labels of every
    cell (with --json and without -o, nothing is written). A method that fails stops no other; the
    exit status is then 1.
    """
    wanted_k = whole_or_auto(k, "-k")
    from geohue.features import cue_columns
    from geohue.studies.compare import compare as run
    from geohue.studies.compare.cells import all_rows
    from geohue.studies.names import names_in

    scene = scenes.load_scene(given)
    truth = None if gt is None else _truth(gt)
    with _counter() as count:
        done = run(
            scene,
            names_in(methods, all_rows()),
            names_in(cues, cue_columns()),
            wanted_k,
            truth=truth,
            preset=preset,
            seed=seed,
            processes=processes,
            timeout=timeout,
            progress=count,
        )
    failed = [result for result in done.results if result.status == "failed"]
    if all(result.status != "done" for result in done.results):
        raise GeohueError(f"every method failed; {failed[0].cell.name}: {failed[0].reason}")
    folder = Path("geohue-compare") if out is None and not as_json else out
    files: list[Path] = []
    if folder is not None:
        from geohue.studies.compare.files import write_comparison

        title = f"Comparison: {given.sample or given.source}"
        files = write_comparison(folder, scene, done, truth, title, overwrite=overwrite)
    warn([*done.warnings, *(f"{r.cell.name} failed: {r.reason}" for r in failed)])
    if as_json:
        print_json(done.summary())
    else:
        _print_table(done)
    if files:
        names = ", ".join(file.name for file in files if file.parent == folder)
        typer.echo(f"{folder}: {names}, labels", err=as_json)
    if failed:
        raise typer.Exit(1)


def _truth(path: Path) -> NDArray[np.int32]:
    """Read true labels; returns them with 0 for none."""
    from geohue.read.labels import read_segments

    return read_segments(path) + 1


def _print_table(done: Comparison) -> None:
    scored = done.scored
    head = f"{'method':18} {'cues':9} {'regions':>7} {'time (s)':>8} {'weight':>7} {'Q':>7}"
    typer.echo(head + (f" {'VoI':>6} {'RI':>6}" if scored else ""))
    for result in done.results:
        row = result.row()
        line = f"{row['method']:18} {row['cues']:9} "
        if result.status != "done":
            typer.echo(line + ("not defined" if result.status == "undefined" else "failed"))
            continue
        line += f"{row['regions']:7d} {row['time_s']:8.2f} "
        line += f"{_number(row['weight']):>7} {_number(row['quality']):>7}"
        if scored:
            line += f" {_number(row['voi_bits']):>6} {_number(row['rand']):>6}"
        typer.echo(line)


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.3f}"


@contextmanager
def _counter() -> Iterator[Callable[[int, int, Result], None]]:
    """Tell on standard error what is done: a bar on a terminal, else a line a cell."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeElapsedColumn

    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda done, total, result: typer.echo(
            f"geohue: {done}/{total} {result.cell.name} {result.status}", err=True
        )
        return
    columns = (BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), "{task.description}")
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("starting", total=None)

        def advance(done: int, total: int, result: Result) -> None:
            text = f"{result.cell.name} {result.status}"
            bar.update(task, completed=done, total=total, description=text)

        yield advance
