"""The commands, and the one place where errors become a line and an exit status."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Sequence
from typing import Annotated, NoReturn

import typer

from geohue.cli import clock
from geohue.cli.batch import batch
from geohue.cli.benchmark import benchmark
from geohue.cli.calibrate import calibrate
from geohue.cli.compare import compare
from geohue.cli.console import StoppedError, when_stopped
from geohue.cli.evaluate import evaluate
from geohue.cli.examples import help_of
from geohue.cli.info import info
from geohue.cli.names import Command, Group, warnings_as_lines
from geohue.cli.register import register
from geohue.cli.segment import segment
from geohue.cli.serve import serve
from geohue.cli.superpoints import superpoints
from geohue.cli.video import video
from geohue.cli.warm import warm
from geohue.cli.words import of_options
from geohue.compute.first_run import on_compile
from geohue.errors import GeohueError, SceneWarning

app = typer.Typer(
    cls=Group,
    help="Split scenes into their parts from colour and geometry together.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
COMMANDS = (
    *(segment, superpoints, batch, video, serve, compare, register),
    *(calibrate, evaluate, benchmark, info, warm),
)
for command in COMMANDS:
    stopped = when_stopped("no results were written")(command)
    app.command(cls=Command, help=help_of(command))(stopped)


def _show_version(wanted: bool) -> None:
    if wanted:
        from geohue._version import __version__

        typer.echo(f"geohue {__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version."),
    ] = False,
) -> None:
    """Split scenes into their parts from colour and geometry together."""


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line; exit with 0, 2 for bad input or usage, or 130 when interrupted."""
    sys.exit(run(arguments, clock.LOADED))


def run(arguments: Sequence[str] | None = None, began: float | None = None) -> int:
    """Run the command line and return the exit status; `began` is as of `clock.begin`."""
    clock.begin(began)
    try:
        # What a scene warns of is printed from its `warnings`, a line each.
        with warnings_as_lines(), on_compile(_tell_of_compiling), warnings.catch_warnings():
            warnings.simplefilter("ignore", SceneWarning)
            status = app(args=arguments, standalone_mode=False)
    except GeohueError as error:
        return _fail(of_options(str(error)))
    except StoppedError as stop:
        return _fail(f"interrupted: {stop}", 130)
    except (KeyboardInterrupt, typer.Abort):
        return _fail("interrupted", 130)
    except BrokenPipeError:
        sys.stderr.close()  # the reader has gone; there is nobody to tell
        return 1
    except MemoryError:
        return _fail("out of memory: give a smaller scene, or read a cloud in pieces with --memory")
    except OSError as error:
        # What no reader or writer has foreseen, such as a disk that is full at a bad moment.
        where = f"{error.filename}: " if error.filename else ""
        return _fail(f"{where}{error.strerror or error}; check the disk and the permissions")
    except Exception as error:
        # Usage errors of the argument parser, whose classes moved between versions of typer.
        describe = getattr(error, "format_message", None)
        if describe is None:
            raise
        text = describe()
        return 0 if not text else _fail(f"{text} Try 'geohue --help'.")
    return status if isinstance(status, int) else 0


def _tell_of_compiling() -> None:
    typer.echo(
        "geohue: compiling its loops, which only a first run does (5 to 10 seconds)", err=True
    )


def _fail(message: str, status: int = 2) -> int:
    typer.echo("geohue: error: " + " ".join(message.split()), err=True)
    return status
