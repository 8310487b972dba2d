"""What every command tells the user on standard error, and how numbers are read."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import typer

from geohue.cli.words import of_options
from geohue.errors import GeohueError
from geohue.segmentation.stages import STAGES

if TYPE_CHECKING:
    from geohue.camera import Intrinsics
    from geohue.merge.levels import Detail
    from geohue.segmentation.arguments import Weight
    from geohue.stereo.rig import StereoRig

_WEIGHT_WORDS: tuple[Literal["auto", "quality", "agreement", "consensus"], ...] = (
    "auto",
    "quality",
    "agreement",
    "consensus",
)

_DETAIL_WORDS: tuple[Literal["coarse", "auto", "fine"], ...] = ("coarse", "auto", "fine")
_MOST_STAGES = 8  # of one run, the reading included


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


class StoppedError(Exception):
    """Ctrl-C, with what is kept; the argument parser would end on a KeyboardInterrupt silently."""


@contextmanager
def when_stopped(kept: str) -> Iterator[None]:
    """Say what Ctrl-C leaves behind, and how to go on."""
    try:
        yield
    except KeyboardInterrupt as stop:
        raise StoppedError(kept) from stop


def warn(messages: Iterable[str]) -> None:
    """Print warnings, a line each."""
    for message in messages:
        typer.echo(f"geohue: warning: {' '.join(of_options(message).split())}", err=True)


def read_camera(file: str | None) -> Intrinsics | None:
    """Read ``--intrinsics``, and warn of what its file has that is left out."""
    if file is None:
        return None
    from geohue.read.cameras.intrinsics import read_intrinsics
    from geohue.read.files import with_notes

    camera, notes = with_notes(read_intrinsics, file)
    warn(notes)
    return camera


def read_pair_calibration(file: str | None) -> StereoRig | None:
    """Read ``--calib`` of a stereo pair, and warn of what is guessed."""
    if file is None:
        return None
    from geohue.read.cameras.stereo_calibration import read_stereo_calibration
    from geohue.read.files import with_notes

    rig, notes = with_notes(read_stereo_calibration, file)
    warn(notes)
    return rig


def print_json(content: Mapping[str, Any]) -> None:
    """Print a JSON object on standard output."""
    typer.echo(json.dumps(content, indent=2))


def read_json(file: Path) -> dict[str, Any]:
    """Read a JSON object that was just written."""
    content: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return content


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


def whole_or_auto(text: str, option: str) -> int | Literal["auto"]:
    """Read a whole number or the word auto."""
    if text == "auto":
        return "auto"
    try:
        return int(text)
    except ValueError:
        raise GeohueError(f'{option} {text}: expected "auto" or a whole number') from None
