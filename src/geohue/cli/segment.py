"""``geohue segment``: one scene into its parts."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer

from geohue.cli import options, scenes
from geohue.cli.clock import passed
from geohue.cli.console import print_json, read_json, stage_bar, warn
from geohue.cli.groups import with_groups
from geohue.cli.pieces import segment_pieces, too_large
from geohue.settings import PAPER_METHOD


@with_groups
def segment(
    *,
    given: options.SceneOptions,
    how: options.SegmentOptions,
    threads: Annotated[int | None, typer.Option(help="Threads; by default one a core.")] = None,
    formats: options.Formats = None,
    objects: options.Objects = False,
    lean: options.Lean = False,
    overwrite: options.Overwrite = False,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", metavar="DIR", help="Where results go; by default geohue-out."),
    ] = None,
    as_json: options.AsJson = False,
    memory: options.Memory = None,
    processes: options.Processes = None,
    scheduler: options.Scheduler = None,
    resume: options.Resume = False,
) -> None:
    """Split a scene into its parts.

    Give an image and its depth map, a stereo pair (COLOR --right IMAGE), a coloured cloud, or
    --sample motorcycle. Labels, pictures, the labelled cloud and a summary are written to the
    folder of -o (with --json and without -o, nothing is written). A cloud that does not fit in
    memory, or any with --memory, is read in pieces.
    """
    wishes = {"memory": memory, "processes": processes, "scheduler": scheduler}
    asked = [f"--{name}" for name, wish in wishes.items() if wish is not None]
    asked += ["--resume"] if resume else []
    whole = how.components or how.method != PAPER_METHOD
    note = None if asked or whole else too_large(given.source)
    if asked or note is not None:
        reason = asked[0] if asked else "reading in pieces (the cloud does not fit in memory)"
        scenes.check_pieces(reason, given, how, threads=threads is not None, objects=objects)
        warn([] if note is None else [note])
        names, place = options.names_of(formats), (processes, scheduler)
        segment_pieces(
            given.source, out, how, memory, *place, resume, names, lean, overwrite, as_json
        )
        return
    folder = Path("geohue-out") if out is None and not as_json else out
    if folder is not None:
        from geohue.results.folder import check_result_folder

        check_result_folder(folder, overwrite=overwrite)
    with ExitStack() as stack, stage_bar() as begin:
        begin("loading")
        from geohue.features.color import make_ready

        make_ready()
        from geohue.results.outputs import write_results
        from geohue.segmentation.driver import segment as run
        from geohue.segmentation.warm import compiling_ahead

        chosen = how.arguments()
        stack.enter_context(compiling_ahead(chosen.preset))
        scene = scenes.load_scene(given)
        seg = run(scene, **chosen.as_dict(), threads=threads, progress=begin)
        wanted = [*options.names_of(formats), *(["objects"] if objects else [])]
        wishes_out = {"lean": lean, "overwrite": overwrite}
        files = [] if folder is None else write_results(folder, scene, seg, wanted, **wishes_out)
    warn(seg.warnings)
    if as_json:
        print_json(seg.summary() if folder is None else read_json(folder / "result.json"))
    else:
        typer.echo(f"{seg.in_words()}, {passed():.2f} s")
    if files:
        shown = ", ".join(file.name for file in files)
        typer.echo(f"{folder}: {shown}", err=as_json)
