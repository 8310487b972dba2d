"""``geohue superpoints`` for clouds that do not fit in memory."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import typer

from geohue.cli.console import print_json, warn, when_stopped
from geohue.cli.options import SceneOptions
from geohue.cli.pieces import pass_bar
from geohue.errors import GeohueError


def superpoints_pieces(
    given: SceneOptions,
    out: Path,
    counts: Sequence[int],
    size: float | None,
    width: float | None,
    cues: str,
    compactness: float,
    threads: int | None,
    formats: Sequence[str],
    memory: str | None,
    resume: bool,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Split a cloud into superpoints, tile by tile."""
    source, others = given.source, list(given.beside_source())
    if others:
        raise GeohueError(f"{others[0]} has no use for a cloud in pieces: leave it out")
    if source is None or source.is_dir():
        raise GeohueError("--memory and --resume need one cloud: give its file, not a folder")
    if formats:
        raise GeohueError(
            f"--format {formats[0]} writes the whole cloud, and with --memory or --resume it goes "
            "through in pieces: use superpoints.npy, which has its points in their order"
        )
    kept = f"what is done is kept in {out}; the same command with --resume goes on"
    with when_stopped(kept), pass_bar() as progress:
        from geohue.large import superpoints_file

        found = superpoints_file(
            source,
            out,
            counts or None,
            size,
            width,
            cues=cues,
            compactness=compactness,
            memory=memory,
            threads=threads,
            resume=resume,
            overwrite=overwrite,
            progress=progress,
        )
    warn(found.warnings)
    if as_json:
        print_json(found.summary())
        return
    seconds = found.timings["total"]
    typer.echo(f"{found.k} superpoints of {found.n_tiles} tiles, {seconds:.1f} s")
    typer.echo(f"{out}: superpoints.npy, levels.npz, graph.npz, superpoints.json")
