"""``geohue superpoints``: a scene, or every scene of a folder, into many small parts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from geohue.cli import options, scenes
from geohue.cli.console import print_json, stage_bar, warn
from geohue.cli.groups import with_groups
from geohue.cli.superpoints_pieces import superpoints_pieces
from geohue.errors import GeohueError

if TYPE_CHECKING:
    from geohue.scene import Scene


@with_groups
def superpoints(
    *,
    given: options.SceneOptions,
    count: Annotated[
        str | None,
        typer.Option(
            metavar="INT[,INT...]", help="How many superpoints; several for nested levels."
        ),
    ] = None,
    size: Annotated[
        float | None, typer.Option(help="Instead, points of a superpoint on average.")
    ] = None,
    width: Annotated[
        float | None,
        typer.Option(help="Instead, width of a superpoint on average, in the scene's unit."),
    ] = None,
    cues: Annotated[
        str, typer.Option(help="auto (what there is), fusion, color or geometry.")
    ] = "auto",
    compactness: Annotated[
        float, typer.Option(help="0 follows colour and geometry only; more is rounder.")
    ] = 1.0,
    threads: Annotated[int | None, typer.Option(help="Threads; by default one a core.")] = None,
    formats: Annotated[
        list[str] | None,
        typer.Option("--format", help="Write this too: ply, las or laz. Repeatable."),
    ] = None,
    out: Annotated[
        Path, typer.Option("-o", "--out", metavar="DIR", help="Where results go.")
    ] = Path("geohue-out"),
    overwrite: options.Overwrite = False,
    as_json: options.AsJson = False,
    memory: options.Memory = None,
    resume: options.Resume = False,
) -> None:
    """Split a scene into superpoints: small parts that follow colour and geometry.

    Give an image and its depth map, a cloud, or a folder: each of its frames or clouds gets a
    folder in that of -o. Writes the ids of all points (superpoints.npy, .pth), nested levels and
    the graph of neighbours with its features. A cloud with --memory is read in pieces.
    """
    wish = Wish(
        _counts(count), size, width, cues, compactness, threads, tuple(formats or ()), overwrite
    )
    if memory is not None or resume:
        superpoints_pieces(
            given,
            out,
            wish.counts,
            *(size, width, cues, compactness, threads, wish.formats),
            *(memory, resume, overwrite, as_json),
        )
        return
    folder = given.source is not None and given.source.is_dir() and not given.beside_source()
    if not folder:
        from geohue.results.folder import SUPERPOINTS, check_result_folder

        check_result_folder(out, SUPERPOINTS, overwrite=overwrite)
    rows: list[Row] = []
    with stage_bar() as begin:
        begin("loading")
        alone = iter([] if folder else [("", scenes.load_scene(given))])
        for name, scene in _all_scenes(given.source) if folder else alone:
            begin(name or "reading colour and geometry")
            rows.append(_split(wish, name, scene, out / name, begin))
    for row in rows:
        warn([f"{row.name}: {note}" if row.name else note for note in row.summary["warnings"]])
    if as_json:
        every = [{"name": row.name} | row.summary for row in rows]
        print_json(rows[0].summary if not folder else {"scenes": every})
        return
    for row in rows:
        seconds = row.summary["timings_s"]["total"]
        typer.echo(
            f"{row.name}{': ' if row.name else ''}{row.summary['k']} superpoints, {seconds:.2f} s"
        )
    if rows:
        names = ", ".join(file.name for file in rows[-1].files)
        typer.echo(f"{out / rows[-1].name}: {names}")


@dataclass(frozen=True, slots=True)
class Wish:
    """What every scene is split into.

    Attributes
    ----------
    counts, size, width, cues, compactness, threads, formats, overwrite
        As the options say; of several counts the finest first.
    """

    counts: tuple[int, ...]
    size: float | None
    width: float | None
    cues: str
    compactness: float
    threads: int | None
    formats: tuple[str, ...]
    overwrite: bool = False

    def __post_init__(self) -> None:
        given = [wish for wish in (self.counts or None, self.size, self.width) if wish is not None]
        if len(given) != 1:
            raise GeohueError("how fine? give one of --count, --size (points) and --width (metres)")


@dataclass(frozen=True, slots=True)
class Row:
    """What came of a scene: its name in the folder, its summary, its files."""

    name: str
    summary: dict[str, Any]
    files: list[Path]


def _split(wish: Wish, name: str, scene: Scene, folder: Path, begin: Callable[[str], None]) -> Row:
    from geohue.results.superpoints import write_superpoints
    from geohue.superpoint import superpoints as run

    seg = run(
        scene,
        wish.counts[0] if wish.counts else None,
        wish.size,
        wish.width,
        cues=wish.cues,
        compactness=wish.compactness,
        threads=wish.threads,
        progress=begin,
    )
    begin("writing")
    coarser = [count for count in wish.counts[1:] if count < seg.k]
    given = coarser, wish.formats
    files = write_superpoints(folder, seg, *given, overwrite=wish.overwrite)
    return Row(name, seg.summary(), files)


def _all_scenes(folder: Path | None) -> Iterator[tuple[str, Scene]]:
    from geohue.studies.items import find_items

    assert folder is not None
    items, notes = find_items(folder)
    warn(notes)
    for item in items:
        yield item.name, item.read()


def _counts(text: str | None) -> tuple[int, ...]:
    """Read how many superpoints the levels have, the finest first.

    Examples
    --------
    >>> _counts("30,3000,300")
    (3000, 300, 30)
    """
    if text is None:
        return ()
    try:
        counts = [int(part) for part in text.split(",")]
    except ValueError:
        counts = [0]
    if min(counts) < 1:
        raise GeohueError(f"--count {text}: expected whole numbers such as 3000 or 3000,300,30")
    return tuple(sorted(set(counts), reverse=True))
