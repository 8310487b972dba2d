"""Word of the loops that have to be compiled, without loading the compiler to hear of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

_listeners: list[Callable[[], None]] = []


@contextmanager
def on_compile(tell: Callable[[], None]) -> Iterator[None]:
    """Call `tell` once, from whichever thread, if a loop is compiled meanwhile.

    Compiled loops are kept on disk, so that only the first run after an installation waits for
    them; later runs are silent.

    Examples
    --------
    >>> with on_compile(lambda: print("a moment, please")):
    ...     announce()
    ...     announce()
    a moment, please
    """
    told = False

    def once() -> None:
        nonlocal told
        if not told:
            told = True
            tell()

    _listeners.append(once)
    try:
        yield
    finally:
        _listeners.remove(once)


def announce() -> None:
    """Tell who listens that a loop is being compiled: the innermost of several."""
    for tell in _listeners[-1:]:
        tell()
