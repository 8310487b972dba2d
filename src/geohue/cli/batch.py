"""``geohue batch``: every frame of a folder."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from geohue.cli import options
from geohue.cli.console import print_json, read_camera, warn
from geohue.cli.groups import with_groups
from geohue.cli.jobs import JobOptions, job_bar

if TYPE_CHECKING:
    from geohue.jobs.ledger import Row


@with_groups
def batch(
    *,
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
    how: options.SegmentOptions,
    formats: options.Formats = None,
    lean: options.Lean = False,
    jobs: JobOptions,
    as_json: options.AsJson = False,
) -> None:
    """Segment every frame of a folder.

    Each frame's results go to DIR/NAME, as those of 'geohue segment', and a row to DIR/batch.csv. A
    frame that fails is named there and stops nothing; the exit status is then 1. A run that was
    killed goes on with --resume.
    """
    jobs.check()
    values = how.values()
    from geohue.compute.parallel import cores
    from geohue.studies.batch import Settings, find_items
    from geohue.studies.batch import batch as run

    settings = Settings(**values, formats=tuple(formats or ()), lean=lean)
    items, notes = find_items(
        folder,
        layout,
        intrinsics=read_camera(intrinsics),
        depth_scale=depth_scale,
        pictures=how.cues == "color",
        limit=jobs.limit,
    )
    warn(notes)
    camera = {"layout": layout, "intrinsics": intrinsics, "depth_scale": depth_scale}
    with job_bar() as count:
        rows = run(
            items,
            out,
            settings,
            source={"folder": str(folder.absolute()), **camera},
            processes=jobs.processes or min(cores(), len(items)),
            scheduler=jobs.scheduler,
            timeout=jobs.timeout,
            resume=jobs.resume,
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
