"""``geohue segment``: one scene into its parts."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from geohue.cli import options
from geohue.cli.console import (
    print_json,
    read_detail,
    read_weight,
    stage_bar,
    told,
    warn,
    whole_or_auto,
)
from geohue.cli.pieces import segment_pieces, too_large
from geohue.settings import PAPER_METHOD


def segment(
    source: options.Source = None,
    depth: options.Depth = None,
    sample: options.Sample = None,
    intrinsics: options.Intrinsics = None,
    depth_scale: options.DepthScale = None,
    right: options.Right = None,
    disparity: options.Disparity = None,
    disparity_scale: options.DisparityScale = None,
    calib: options.Calib = None,
    views: options.Views = 2,
    cameras: options.Cameras = None,
    frame: options.Frame = 0,
    k: options.Count = "auto",
    weight: options.Weight = "auto",
    cues: options.Cues = "fusion",
    preset: options.Preset = "best",
    detail: options.Detail = "auto",
    method: options.Method = PAPER_METHOD,
    seed: options.Seed = 0,
    components: options.Components = False,
    fill: options.Fill = True,
    threads: Annotated[int | None, typer.Option(help="Threads; by default one a core.")] = None,
    formats: options.Formats = None,
    objects: options.Objects = False,
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
    memory, or any with --memory, is read in pieces, by the paper's cut under every preset.
    """
    wanted_k = whole_or_auto(k, "-k")
    wanted_weight, wanted_detail = read_weight(weight), read_detail(detail)
    options.check_detail(detail, k, weight, preset, method)
    wishes = {"memory": memory, "processes": processes, "scheduler": scheduler}
    asked = [f"--{name}" for name, wish in wishes.items() if wish is not None]
    asked += ["--resume"] if resume else []
    note = None if asked or components or method != PAPER_METHOD else too_large(source)
    if asked or note is not None:
        options.check_pieces(
            asked[0] if asked else "reading in pieces (the cloud does not fit in memory)",
            method,
            components,
            DEPTH=depth,
            sample=sample,
            intrinsics=intrinsics,
            depth_scale=depth_scale,
            right=right,
            disparity=disparity,
            disparity_scale=disparity_scale,
            calib=calib,
            views=views != 2,
            camera=cameras,
            frame=frame,
            threads=threads is not None,
            no_fill=not fill,
            objects=objects,
            detail=detail != "auto",
        )
        warn([] if note is None else [note])
        segment_pieces(
            source,
            out,
            wanted_k,
            wanted_weight,
            preset,
            cues,
            seed,
            memory,
            processes,
            scheduler,
            resume,
            formats,
            as_json,
        )
        return
    folder = Path("geohue-out") if out is None and not as_json else out
    if folder is not None:
        from geohue.results.atomic import check_folder

        check_folder(folder)
    with stage_bar() as begin:
        begin("loading")
        from geohue.results.outputs import write_results
        from geohue.segmentation.driver import segment as run

        scene = options.load_scene(
            source,
            depth,
            sample,
            intrinsics=intrinsics,
            depth_scale=depth_scale,
            right=right,
            disparity=disparity,
            disparity_scale=disparity_scale,
            calib=calib,
            views=views,
            cameras=cameras,
            frame=frame,
        )
        seg = run(
            scene,
            wanted_k,
            wanted_weight,
            preset,
            cues,  # checked by the library, with the choices named
            method,
            seed,
            detail=wanted_detail,
            components=components,
            fill=fill,
            threads=threads,
            progress=begin,
        )
        files = [] if folder is None else write_results(folder, scene, seg, formats or ())
        if folder is not None and objects:
            from geohue.results.objects import write_objects

            files += write_objects(folder, seg.segments)
    warn(seg.warnings)
    if as_json:
        print_json(seg.summary())
    else:
        found = told(seg.k, seg.weight, method, cues, merged=seg.levels is not None)
        typer.echo(f"{found}, {seg.timings['total']:.2f} s")
    if files:
        names = ", ".join(file.name for file in files)
        typer.echo(f"{folder}: {names}", err=as_json)
