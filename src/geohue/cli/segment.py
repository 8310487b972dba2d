"""``geohue segment``: one scene into its parts."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from geohue.cli.console import number_or_auto, print_json, stage_bar, warn, whole_or_auto
from geohue.errors import GeohueError

if TYPE_CHECKING:
    from geohue.scene import Scene


def segment(
    source: Annotated[
        Path | None,
        typer.Argument(metavar="COLOR|CLOUD", help="Colour image, or a cloud (.ply, .pcd)."),
    ] = None,
    depth: Annotated[
        Path | None,
        typer.Argument(metavar="[DEPTH]", help="Depth map registered to the image."),
    ] = None,
    sample: Annotated[
        str | None, typer.Option(help="Segment a built-in scene instead: motorcycle.")
    ] = None,
    intrinsics: Annotated[
        str | None, typer.Option(metavar="FILE|fx,fy,cx,cy", help="Camera of the depth map.")
    ] = None,
    depth_scale: Annotated[
        float | None,
        typer.Option(metavar="M_PER_UNIT", help="Metres per unit of the depth map."),
    ] = None,
    k: Annotated[str, typer.Option("-k", metavar="auto|INT", help="Number of segments.")] = "auto",
    weight: Annotated[
        str,
        typer.Option("--lambda", metavar="auto|FLOAT", help="Weight of geometry against colour."),
    ] = "auto",
    cues: Annotated[str, typer.Option(help="fusion, color or geometry.")] = "fusion",
    preset: Annotated[str, typer.Option(help="paper, fast or best.")] = "paper",
    method: Annotated[
        str,
        typer.Option(help="nncsc (the paper's), or a compared system: kmeans, meanshift, ..."),
    ] = "nncsc",
    seed: Annotated[int, typer.Option(help="Source of chance.")] = 0,
    components: Annotated[
        bool, typer.Option("--components", help="Number connected pieces one by one.")
    ] = False,
    fill: Annotated[bool, typer.Option(help="Label pixels without depth too.")] = True,
    threads: Annotated[int | None, typer.Option(help="Threads; by default one a core.")] = None,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", metavar="DIR", help="Where results go [geohue-out]."),
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print result.json on standard output.")
    ] = False,
) -> None:
    """Split a scene into its parts.

    Give an image and its depth map, a coloured cloud, or --sample motorcycle. Labels, pictures,
    the labelled cloud and a summary are written to the folder of -o (with --json and without
    -o, nothing is written).
    """
    wanted_k = whole_or_auto(k, "-k")
    wanted_weight = number_or_auto(weight, "--lambda")
    with stage_bar() as begin:
        begin("loading")
        from geohue.io.results import write_results
        from geohue.segment import segment as run

        scene = _load(source, depth, sample, intrinsics, depth_scale)
        seg = run(
            scene,
            wanted_k,
            wanted_weight,
            preset,
            cues,  # type: ignore[arg-type]  # checked by the library, with the choices named
            method,
            seed,
            components=components,
            fill=fill,
            threads=threads,
            progress=begin,
        )
        folder = Path("geohue-out") if out is None and not as_json else out
        files = [] if folder is None else write_results(folder, scene, seg)
    warn(seg.warnings)
    if as_json:
        print_json(seg.summary())
    else:
        typer.echo(f"{seg.k} segments, weight {seg.weight:.3g}, {seg.timings['total']:.2f} s")
    if files:
        names = ", ".join(file.name for file in files)
        typer.echo(f"{folder}: {names}", err=as_json)


def _load(
    source: Path | None,
    depth: Path | None,
    sample: str | None,
    intrinsics: str | None,
    depth_scale: float | None,
) -> Scene:
    if sample is not None:
        if source is not None:
            raise GeohueError(f"both {source} and --sample {sample} given: choose one")
        from geohue.datasets import load_sample

        return load_sample(sample)
    if source is None:
        raise GeohueError("nothing to segment: give COLOR DEPTH, a cloud, or --sample motorcycle")
    from geohue.io.scenes import read_scene

    return read_scene(source, depth, intrinsics, depth_scale)
