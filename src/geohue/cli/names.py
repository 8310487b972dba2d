"""Help that names what plugins bring, and warnings as lines of the command line."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TextIO

from typer.core import TyperCommand, TyperGroup

from geohue.cli.console import warn
from geohue.errors import GeohueWarning
from geohue.plugins import KINDS, plugins_of

_KIND_OF = {
    "method": "methods",
    "methods": "methods",
    "cues": "cues",
    "preset": "presets",
    "presets": "presets",
    "source": "clouds",
    "layout": "layouts",
    "depth_scale": "sensors",
}
"""Which plugins an option can name."""


class Command(TyperCommand):
    """A command whose help says which names plugins add to its options."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help; nothing of a plugin is imported."""
        for param in self.params:
            names = plugins_of(_KIND_OF.get(param.name or "", ""))
            if names and hasattr(param, "help"):
                param.help = f"{param.help or ''} Plugins: {', '.join(names)}."
        super().format_help(ctx, formatter)


class Group(TyperGroup):
    """All commands; the help ends with what plugins there are."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help; nothing of a plugin is imported."""
        found = {kind: ", ".join(plugins_of(kind)) for kind in KINDS if plugins_of(kind)}
        if found:
            lines = "; ".join(f"{kind}: {names}" for kind, names in found.items())
            self.epilog = f"Plugins. {lines}."
        super().format_help(ctx, formatter)


@contextmanager
def warnings_as_lines() -> Iterator[None]:
    """Show a `GeohueWarning` as one line on standard error."""
    before = warnings.showwarning

    def show(
        message: Warning | str,
        category: type[Warning],
        filename: str,
        lineno: int,
        file: TextIO | None = None,
        line: str | None = None,
    ) -> None:
        if issubclass(category, GeohueWarning):
            warn([str(message)])
        else:
            before(message, category, filename, lineno, file, line)

    warnings.showwarning = show
    try:
        yield
    finally:
        warnings.showwarning = before
