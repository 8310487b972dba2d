"""The time that a command takes, from the key press on as far as it can be known."""

from __future__ import annotations

from time import perf_counter

LOADED = perf_counter()
"""When this file was imported: before the libraries, a few hundredths of a second after the start
of Python."""

_begun = {"command": LOADED}


def begin(when: float | None = None) -> None:
    """Say that a command begins now, or began at a reading of `time.perf_counter`."""
    _begun["command"] = perf_counter() if when is None else when


def passed() -> float:
    """Return the seconds since the command began.

    Examples
    --------
    >>> begin()
    >>> 0 <= passed() < 1
    True
    """
    return perf_counter() - _begun["command"]
