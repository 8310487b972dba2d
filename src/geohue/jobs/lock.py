"""One run at a time in a folder."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from filelock import FileLock, Timeout

from geohue.errors import GeohueError
from geohue.read.files import broken, reason

LOCK = "running.lock"
"""The file that is locked while a run works in a folder; it names the run's process and machine."""


@contextmanager
def only_run(folder: Path) -> Iterator[None]:
    """Keep other runs out of a folder, which is made if it does not exist.

    The operating system holds the lock and ends it with the process. The file stays in the folder
    and keeps nobody out when it is not locked.

    Raises
    ------
    GeohueError
        If another run works there, or the folder cannot be written to.

    Examples
    --------
    >>> folder = getfixture("tmp_path") / "out"
    >>> with only_run(folder):
    ...     (folder / "running.lock").read_text().split()[0] == str(os.getpid())
    True
    """
    file = folder.absolute() / LOCK
    lock = FileLock(file, timeout=0)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        lock.acquire()
    except Timeout:
        raise _taken(file) from None
    except OSError as error:
        cause = f"cannot be written ({reason(error)}); choose a folder with space and permission"
        raise broken(file.parent, cause) from error
    try:
        with suppress(OSError):  # Windows lets nobody write to a locked file: it stays empty there
            file.write_text(f"{os.getpid()} {platform.node()}\n", encoding="utf-8")
        yield
    finally:
        with suppress(OSError):  # the next owner has written nothing yet when it is asked for
            file.write_text("")
        # The file stays. Another run may have it open: had it gone, that one would lock a file
        # without a name, and a third one a new file beside it.
        lock.release()


def _taken(file: Path) -> GeohueError:
    owner = ""
    with suppress(OSError):
        owner = file.read_text(encoding="utf-8", errors="replace").strip()
    number, _, machine = owner.partition(" ")
    who = f" (process {number} on {machine})" if machine else ""
    return GeohueError(
        f"{file.parent}: another run works there{who}; wait for its end, or give another folder"
    )
