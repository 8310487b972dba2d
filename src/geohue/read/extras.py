"""Libraries of the optional extras, with the way to install one in the error."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

from geohue.read.files import broken


def optional(module: str, extra: str, path: str | Path) -> Any:
    """Import a library that geohue can do without.

    Parameters
    ----------
    module : str
        What to import.
    extra : str
        The extra of geohue that brings it.
    path : path-like
        The file that needs it, for the message.

    Raises
    ------
    GeohueError
        If it is not installed.

    Examples
    --------
    >>> optional("not_there", "clouds", "a.laz")
    Traceback (most recent call last):
    geohue.errors.GeohueError: a.laz: needs not_there: pip install "geohue[clouds]"
    """
    try:
        return import_module(module)
    except ImportError as error:
        name = module.split(".")[0]
        raise broken(path, f'needs {name}: pip install "geohue[{extra}]"') from error
