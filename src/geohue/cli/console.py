"""What every command tells the user on standard error, and how numbers are read."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any, Literal

import typer

from geohue.errors import GeohueError
from geohue.segmentation.stages import STAGES

if TYPE_CHECKING:
    from geohue.camera import Intrinsics
    from geohue.merge.levels import Detail
    from geohue.segmentation.choice import Weight

_WEIGHT_WORDS: tuple[Literal["auto", "quality", "agreement", "consensus"], ...] = (
    "auto",
    "quality",
    "agreement",
    "consensus",
)

_DETAIL_WORDS: tuple[Literal["coarse", "auto", "fine"], ...] = ("coarse", "auto", "fine")
_MOST_STAGES = 8  # of one run, the reading included
_ALONE = {"color": "colour alone", "geometry": "geometry alone"}


@contextmanager
def stage_bar() -> Iterator[Any]:
    """Show a progress bar on a terminal's standard error; yields what `segment` calls."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda _: None
        return
    columns = (TextColumn("{task.description:32}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task("starting", total=_MOST_STAGES)
        done = iter(range(_MOST_STAGES))

        def begin(stage: str) -> None:
            progress.update(task, description=STAGES.get(stage, stage), completed=next(done, 0))

        yield begin


def warn(messages: Iterable[str]) -> None:
    """Print warnings, a line each."""
    for message in messages:
        typer.echo(f"geohue: warning: {' '.join(message.split())}", err=True)


def read_camera(file: str | None) -> Intrinsics | None:
    """Read ``--intrinsics``, and warn of what its file has that is left out."""
    if file is None:
        return None
    from geohue.read.cameras.intrinsics import read_intrinsics
    from geohue.read.files import with_notes

    camera, notes = with_notes(read_intrinsics, file)
    warn(notes)
    return camera


def print_json(content: Mapping[str, Any]) -> None:
    """Print a JSON object on standard output."""
    typer.echo(json.dumps(content, indent=2))


def read_weight(text: str) -> Weight:
    """Read a weight: a number, or what chooses it.

    Examples
    --------
    >>> read_weight("0.5"), read_weight("auto")
    (0.5, 'auto')
    >>> read_weight("x")
    Traceback (most recent call last):
    geohue.errors.GeohueError: --lambda x: expected auto, quality, agreement, consensus or a number
    """
    for word in _WEIGHT_WORDS:
        if text == word:
            return word
    try:
        return float(text)
    except ValueError:
        message = f"--lambda {text}: expected {', '.join(_WEIGHT_WORDS)} or a number"
        raise GeohueError(message) from None


def read_detail(text: str) -> Detail:
    """Read a degree of detail: a number, or a name for one.

    Examples
    --------
    >>> read_detail("0.5"), read_detail("fine")
    (0.5, 'fine')
    >>> read_detail("high")
    Traceback (most recent call last):
    geohue.errors.GeohueError: --detail high: expected coarse, auto, fine or a number
    """
    for word in _DETAIL_WORDS:
        if text == word:
            return word
    with suppress(ValueError):
        if math.isfinite(number := float(text)):
            return number
    raise GeohueError(f"--detail {text}: expected {', '.join(_DETAIL_WORDS)} or a number")


def told(k: int, weight: float, method: str, cues: str, merged: bool = False) -> str:
    """Return in words how many segments were found, and what they go by.

    Examples
    --------
    >>> told(17, math.inf, "nncsc", "fusion", merged=True)
    '17 segments, regions merged'
    >>> told(1, math.inf, "nncsc", "geometry")
    '1 segment, by geometry alone'
    >>> told(40, math.nan, "edison", "color")
    '40 segments, by edison'
    >>> told(4, 2.0, "nncsc", "fusion")
    '4 segments, weight 2'
    """
    return f"{k} segment{'' if k == 1 else 's'}, {_way(weight, method, cues, merged)}"


def _way(weight: float, method: str, cues: str, merged: bool) -> str:
    if merged:
        return "regions merged" + ("" if cues == "fusion" else f" by {_ALONE[cues]}")
    if math.isnan(weight):
        return f"by {method}"
    ends = {0.0: "color", math.inf: "geometry"}
    return f"by {_ALONE[ends[weight]]}" if weight in ends else f"weight {weight:.3g}"


def whole_or_auto(text: str, option: str) -> int | Literal["auto"]:
    """Read a whole number or the word auto."""
    if text == "auto":
        return "auto"
    try:
        return int(text)
    except ValueError:
        raise GeohueError(f'{option} {text}: expected "auto" or a whole number') from None
