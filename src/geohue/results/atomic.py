"""Files that appear whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from secrets import token_hex

from geohue.read.files import broken, reason


@contextmanager
def atomic_write(path: str | Path) -> Iterator[Path]:
    """Give a temporary path that becomes `path` when the block ends without an exception.

    Parameters
    ----------
    path : path-like
        The file to write. Missing parent folders are made; an existing file is replaced.

    Yields
    ------
    Path
        An empty file in the same folder and with the same suffix, to be written by the block.

    Raises
    ------
    GeohueError
        If the folder cannot be made or written to, or if the disk is full. Whatever happens, no
        temporary file stays behind and an existing file is left as it was.

    Examples
    --------
    >>> folder = getfixture("tmp_path")
    >>> with atomic_write(folder / "new" / "labels.txt") as temporary:
    ...     _ = temporary.write_text("1 2 3")
    >>> [file.name for file in (folder / "new").iterdir()]
    ['labels.txt']
    """
    target = Path(path)
    temporary: Path | None = None
    try:
        if target.is_dir():
            raise broken(path, "is a folder; name a file in it")
        target.parent.mkdir(parents=True, exist_ok=True)
        temporary = _empty_file_beside(target)
        yield temporary
        temporary.replace(target)
    except OSError as error:
        cause = f"cannot be written ({reason(error)}); choose a folder with space and permission"
        raise broken(path, cause) from error
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)


def check_folder(folder: str | Path) -> None:
    """Raise an error, before the work is done, if files could not be written to a folder.

    Parameters
    ----------
    folder : path-like
        Need not exist, nor its parents; nothing is made.

    Raises
    ------
    GeohueError
        If it is a file, lies under one, or may not be written to.
    """
    there = Path(folder).absolute()
    while not there.exists() and there != there.parent:
        there = there.parent
    if not there.is_dir():
        raise broken(folder, f"cannot be made ({there} is a file); choose another folder")
    if not os.access(there, os.W_OK):
        raise broken(folder, "cannot be written to; choose a folder with space and permission")


def _empty_file_beside(target: Path) -> Path:
    """Make the temporary file, readable by whom a plain new file would be readable."""
    while True:
        # `tempfile` makes files that the owner alone reads, and `umask`, which says what others may
        # do, can only be asked by changing it for all threads: so the system applies it to this.
        temporary = target.with_name(f".{target.stem[:40]}-{token_hex(8)}{target.suffix}")
        try:
            temporary.touch(exist_ok=False)
        except FileExistsError:
            continue
        return temporary
