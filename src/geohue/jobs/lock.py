"""One run at a time in a folder."""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from geohue.errors import GeohueError
from geohue.read.files import broken, reason

LOCK = "running.lock"
"""The file that says who works in a folder: its process and machine."""

_HELD: set[Path] = set()  # by this process: others with its number, in a container say, have ended


@contextmanager
def only_run(folder: Path) -> Iterator[None]:
    """Keep other runs out of a folder, which is made if it does not exist.

    What a killed process of this machine has left does not count.

    Raises
    ------
    GeohueError
        If another run works there, or the folder cannot be written to.

    Examples
    --------
    >>> folder = getfixture("tmp_path") / "out"
    >>> with only_run(folder):
    ...     [file.name for file in folder.iterdir()]
    ['running.lock']
    >>> list(folder.iterdir())
    []
    """
    file = folder.absolute() / LOCK
    handle = _take(file)
    _HELD.add(file.resolve())
    try:
        yield
    finally:
        _HELD.discard(file.resolve())
        os.close(handle)
        with suppress(OSError):  # the next run sees that this one has ended
            file.unlink(missing_ok=True)


def _take(file: Path) -> int:
    """Make the lock; returns its handle, which stays open: Windows then keeps the file."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with suppress(FileExistsError):
            return _made(file)
        owner = file.read_text(encoding="utf-8").strip() if file.exists() else ""
        if not _has_ended(file, owner):
            raise _taken(file, owner)
        try:
            file.unlink(missing_ok=True)
            return _made(file)
        except (FileExistsError, PermissionError):  # somebody was faster, or it is open
            raise _taken(file, owner) from None
    except OSError as error:
        cause = f"cannot be written ({reason(error)}); choose a folder with space and permission"
        raise broken(file.parent, cause) from error


def _made(file: Path) -> int:
    handle = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL)
    try:
        os.write(handle, f"{os.getpid()} {platform.node()}\n".encode())
    except OSError:
        os.close(handle)
        file.unlink()
        raise
    return handle


def _has_ended(file: Path, owner: str) -> bool:
    """Whether the process that made a lock is known to be gone."""
    number, _, machine = owner.partition(" ")
    if not number.isdecimal() or machine != platform.node():
        return False
    if int(number) == os.getpid():
        return file.resolve() not in _HELD
    if sys.platform == "win32":  # where no signal asks; one that runs keeps its file open
        return True
    try:
        os.kill(int(number), 0)
    except (ProcessLookupError, OverflowError):
        return True
    except PermissionError:  # somebody else's
        return False
    return False


def _taken(file: Path, owner: str) -> GeohueError:
    number, _, machine = owner.partition(" ")
    who = f"process {number} on {machine}" if machine else "it has just begun"
    return GeohueError(
        f"{file.parent}: another run works there ({who}); wait for its end, give another folder "
        f"or, if there is none, remove {file.name}"
    )
