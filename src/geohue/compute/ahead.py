"""Loops that a first run will need, compiled meanwhile by other processes.

The compiler works in one thread of a process. Two processes that fill one cache on disk take half
the time: the one that runs compiles what it needs first, a helper what it needs last.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

Loops = Mapping[str, Sequence[str]]
"""Names of loops, "module.function", by the part that they are compiled in."""


class Helper:
    """A process that compiles parts in their order, and prints the name of each that is there."""

    def __init__(self, command: str, parts: Loops) -> None:
        self._owed = {loop: part for part, loops in parts.items() for loop in loops}
        path = f"import sys; sys.path[:] = {sys.path!r}; "
        self._process = subprocess.Popen(
            [sys.executable, "-c", path + command, *parts],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )

    def wait_for(self, loop: str) -> bool:
        """Wait until a loop is there, or the process has ended; False if it is not owed."""
        part = self._owed.get(loop)
        while part in self._owed.values() and self._next():
            pass
        return part is not None

    def _next(self) -> bool:
        """Hear of the next part that is there; False at the end, when nothing more is owed."""
        told = self._process.stdout.readline().strip() if self._process.stdout else ""
        self._owed = {loop: part for loop, part in self._owed.items() if told and part != told}
        return bool(told)

    def finish(self) -> None:
        """Wait until the process has ended."""
        while self._next():
            pass
        self._process.wait()

    def end(self) -> None:
        """End the process, whatever it is at: what it has compiled is kept."""
        self._process.kill()
        self.finish()
        if self._process.stdout is not None:
            self._process.stdout.close()


_helpers: list[Helper] = []


def wait_for(loop: str) -> bool:
    """Wait for the helper that compiles a loop; returns whether there was one."""
    return any(helper.wait_for(loop) for helper in _helpers)


def finish() -> None:
    """Wait for all helpers."""
    for helper in _helpers:
        helper.finish()


@contextmanager
def helped(command: str, shares: Sequence[Loops]) -> Iterator[None]:
    """Let processes compile while the block runs; without them it takes longer, no more.

    Parameters
    ----------
    command : str
        What a process runs; the names of its parts are in ``sys.argv[1:]``. It prints each as a
        line when it is there.
    shares : sequence of dict
        The parts of each process, with the loops in them.
    """
    begun: list[Helper] = []
    try:
        for parts in shares:
            begun.append(Helper(command, parts))
    except OSError:  # no more processes allowed
        pass
    _helpers.extend(begun)
    try:
        yield
    finally:
        for helper in begun:
            _helpers.remove(helper)
            helper.end()
