"""``geohue batch``: every frame of a folder."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from geohue.cli import options
from geohue.cli.console import (
    print_json,
    read_camera,
    read_detail,
    read_weight,
    warn,
    whole_or_auto,
)
from geohue.cli.jobs import check_place, job_bar
from geohue.settings import PAPER_METHOD

if TYPE_CHECKING:
    from geohue.jobs.ledger import Row


def batch(
    folder: Annotated[
        Path,
        typer.Argument(metavar="FOLDER", help="A data set or recording, or a folder of clouds."),
    ],
    out: Annotated[Path, typer.Option("-o", "--out", metavar="DIR", help="Where results go.")],
    layout: Annotated[
        str | None, typer.Option(help="Layout of the data set, if it is not to be guessed.")
    ] = None,
    intrinsics: options.Intrinsics = None,
    depth_scale: options.DepthScale = None,
    k: options.Count = "auto",
    weight: options.Weight = "auto",
    cues: options.Cues = "fusion",
    preset: options.Preset = "best",
    detail: options.Detail = "auto",
    method: options.Method = PAPER_METHOD,
    seed: options.Seed = 0,
    components: options.Components = False,
    fill: options.Fill = True,
    formats: options.Formats = None,
    lean: Annotated[
        bool,
        typer.Option("--lean", help="Write labels and result.json only, no pictures, no levels."),
    ] = False,
    limit: Annotated[
        int | None, typer.Option(help="Only so many frames, spread evenly over all.")
    ] = None,
    processes: Annotated[
        int | None,
        typer.Option(help="Processes, each with one thread; by default one a core."),
    ] = None,
    scheduler: options.Scheduler = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the run in DIR.")] = False,
    as_json: options.AsJson = False,
) -> None:
    """Segment every frame of a folder.

    Each frame's results go to DIR/NAME, as those of 'geohue segment', and a row to DIR/batch.csv. A
    frame that fails is named there and stops nothing; the exit status is then 1. A run that was
    killed goes on with --resume.
    """
    wanted_k, wanted_weight = whole_or_auto(k, "-k"), read_weight(weight)
    wanted_detail = read_detail(detail)
    options.check_detail(detail, k, weight, preset, method)
    check_place(processes, scheduler)
    from geohue.compute.parallel import cores
    from geohue.studies.batch import Settings, find_items
    from geohue.studies.batch import batch as run

    settings = Settings(
        wanted_k,
        wanted_weight,
        preset,
        cues,  # checked there, with the choices named
        method,
        seed,
        components,
        fill,
        tuple(formats or ()),
        lean,
        wanted_detail,
    )
    items, notes = find_items(
        folder,
        layout,
        intrinsics=read_camera(intrinsics),
        depth_scale=depth_scale,
        pictures=cues == "color",
        limit=limit,
    )
    warn(notes)
    camera = {"layout": layout, "intrinsics": intrinsics, "depth_scale": depth_scale}
    with job_bar() as count:
        rows = run(
            items,
            out,
            settings,
            source={"folder": str(folder.absolute()), **camera},
            processes=processes or min(cores(), len(items)),
            scheduler=scheduler,
            resume=resume,
            progress=count,
        )
    raise typer.Exit(_report(rows, out, as_json))


def _report(rows: list[Row], out: Path, as_json: bool) -> int:
    """Print what became of a batch; returns the exit status."""
    failed = {row["name"]: row["error"] for row in rows if row["error"]}
    times = sorted(float(row["seconds"]) for row in rows if not row["error"])
    middle = times[len(times) // 2] if times else None
    if as_json:
        facts: dict[str, Any] = {
            "n_frames": len(rows),
            "n_failed": len(failed),
            "median_seconds": middle,
            "table": str(out / "batch.csv"),
            "failed": failed,
        }
        print_json(facts)
    else:
        pace = "" if middle is None else f", {middle:.2f} s a frame (median)"
        typer.echo(f"{len(times)} of {len(rows)} frame(s) segmented{pace}: {out / 'batch.csv'}")
        if failed:
            typer.echo(f"{len(failed)} failed: their column error says why")
    return 1 if failed else 0
