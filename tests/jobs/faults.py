"""Jobs that go wrong, importable by the processes that run them."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path
from typing import Any


def work(job: str) -> tuple[str, int]:
    """Do what a job says; returns it with the process that did it."""
    if job == "raise":
        raise KeyError("gone")
    if job == "exit":
        os._exit(3)
    if job == "kill":
        os.kill(os.getpid(), signal.SIGKILL)
    if job == "sleep":
        time.sleep(600)
    if job == "unsendable":
        return lambda: 0, 1  # type: ignore[return-value]
    return job, os.getpid()


def die_once(file: Path) -> int:
    """Die at the first try, return the number of the second."""
    if not file.exists():
        file.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return 2


def _fail() -> None:
    raise RuntimeError("never read")


class Unreadable:
    """A job that can be sent and not received."""

    def __reduce__(self) -> Any:
        return _fail, ()
