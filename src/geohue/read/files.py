"""Reading a file's bytes, with every failure as one GeohueError that starts with the path."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from geohue.errors import GeohueError, GeohueWarning

Source = TypeVar("Source")
Content = TypeVar("Content")


def broken(path: str | Path, cause: str) -> GeohueError:
    """Return the error for a file: the path, then the cause and the mend, on one line."""
    return GeohueError(f"{path}: {' '.join(cause.split())}")


def reason(error: BaseException) -> str:
    """Return an exception's text as one short line."""
    text = " ".join(str(getattr(error, "strerror", None) or error).split()) or type(error).__name__
    return text if len(text) <= 160 else text[:157] + "..."


def with_notes(
    read: Callable[[Source], Content], source: Source
) -> tuple[Content, tuple[str, ...]]:
    """Call a reader; returns what it read and the texts of the `GeohueWarning`s it gave."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", GeohueWarning)
        content = read(source)
    return content, tuple(str(warning.message) for warning in caught)


def check_file(path: str | Path) -> None:
    """Raise `GeohueError` unless a path names a regular file that is there."""
    file = Path(path)
    if file.is_dir():
        raise broken(path, "is a folder; name a file in it")
    if not file.exists():
        raise broken(path, "no such file; check the name and the folder")
    if not file.is_file():
        raise broken(path, "is not a regular file; save the data to a file first")


def read_bytes(path: str | Path, limit: int | None = None) -> bytes:
    """Read a whole regular file.

    Parameters
    ----------
    path : path-like
        The file.
    limit : int, optional
        Most bytes that a sensible file of this kind has.

    Returns
    -------
    bytes
        The content, at least one byte.

    Raises
    ------
    GeohueError
        If the file is missing, a folder, a device, unreadable, empty or larger than `limit`.
    """
    file = Path(path)
    try:
        check_file(path)
        if limit is not None and file.stat().st_size > limit:
            raise broken(path, f"is larger than {limit} bytes, too large for a file of this kind")
        data = file.read_bytes()
    except (OSError, MemoryError) as error:
        raise broken(path, f"cannot be read ({reason(error)}); check its permissions") from error
    except ValueError as error:
        if isinstance(error, GeohueError):
            raise
        raise broken(path, f"is not a file name ({reason(error)})") from error
    if not data:
        raise broken(path, "is empty (0 bytes); copy or export it again")
    return data
