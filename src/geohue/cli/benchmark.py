"""``geohue benchmark``: methods over a folder of labelled frames."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from geohue.cli import options
from geohue.cli.console import whole_or_auto
from geohue.cli.groups import with_groups
from geohue.cli.jobs import JobOptions, job_bar
from geohue.errors import GeohueError
from geohue.settings import PAPER_METHOD

if TYPE_CHECKING:
    from geohue.studies.benchmark.trials import Trial


@with_groups
def benchmark(
    *,
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="Frames: rgb, depth, labels, intrinsics.")
    ],
    out: Annotated[Path, typer.Option("-o", "--out", metavar="DIR", help="Where results go.")],
    methods: Annotated[
        str, typer.Option(help="Methods, with commas between; all for every one.")
    ] = PAPER_METHOD,
    cues: Annotated[str, typer.Option(help="fusion, color, geometry, or all.")] = "fusion",
    presets: Annotated[
        str, typer.Option(metavar="A,B,..", help="best, fast, paper, or all.")
    ] = "best",
    k: options.Count = "auto",
    components: Annotated[
        bool, typer.Option("--components", help="Each connected piece is a region.")
    ] = False,
    seed: options.Seed = 0,
    protocol: Annotated[
        str | None, typer.Option(help="nyu: the valid crop of NYU Depth V2.")
    ] = None,
    crop: Annotated[
        str | None,
        typer.Option(metavar="TOP,BOTTOM,LEFT,RIGHT", help="Use this part of each frame."),
    ] = None,
    jobs: JobOptions,
    plots: Annotated[bool, typer.Option(help="Draw plots and pictures.")] = True,
) -> None:
    """Measure methods on a folder of labelled frames.

    Writes frames.csv (a row a frame), summary.md, the labels and plots to DIR. A run that was
    killed goes on with --resume. A frame that fails is named there and stops nothing; the exit
    status is then 1.
    """
    wanted_k = whole_or_auto(k, "-k")
    window = _crop(protocol, crop)
    jobs.check()
    from geohue.results.atomic import atomic_write
    from geohue.studies.benchmark.frames import find_frames
    from geohue.studies.benchmark.run import benchmark as run
    from geohue.studies.benchmark.summary import summarise, table
    from geohue.studies.benchmark.trials import Conditions

    trials = _plan(methods, cues, presets)
    with job_bar() as count:
        rows = run(
            folder,
            out,
            trials,
            Conditions(wanted_k, components, seed),
            crop=window,
            limit=jobs.limit,
            processes=jobs.processes or 1,
            scheduler=jobs.scheduler,
            timeout=jobs.timeout,
            resume=jobs.resume,
            progress=count,
        )
    text = table(summarise(rows))
    with atomic_write(out / "summary.md") as temporary:
        temporary.write_text(text, encoding="utf-8")
    if plots:
        from geohue.studies.benchmark.plots import draw_run

        draw_run(out, rows, find_frames(folder, jobs.limit), window)
    typer.echo(text, nl=False)
    if any(row["error"] for row in rows):
        raise typer.Exit(1)


def _plan(methods: str, cues: str, presets: str) -> list[Trial]:
    from geohue.baselines import BASELINES
    from geohue.features import cue_columns
    from geohue.settings import PRESETS
    from geohue.studies.benchmark.trials import OWN, plan
    from geohue.studies.names import names_in

    return plan(
        names_in(methods, (OWN, *BASELINES)),
        names_in(cues, cue_columns()),
        names_in(presets, tuple(PRESETS)),
    )


def _crop(protocol: str | None, crop: str | None) -> tuple[int, int, int, int] | None:
    from geohue.measures.crop import PROTOCOLS

    if protocol is not None and crop is not None:
        raise GeohueError("--protocol and --crop both name a part of the frame: give one")
    if protocol is not None:
        if protocol not in PROTOCOLS:
            raise GeohueError(f"--protocol {protocol}: choose one of {', '.join(PROTOCOLS)}")
        return PROTOCOLS[protocol]
    if crop is None:
        return None
    try:
        top, bottom, left, right = (int(part) for part in crop.split(","))
    except ValueError:
        raise GeohueError(
            f"--crop {crop}: expected four whole numbers TOP,BOTTOM,LEFT,RIGHT"
        ) from None
    return top, bottom, left, right
