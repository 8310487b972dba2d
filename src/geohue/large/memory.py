"""How much memory there is, and how many processes fit in what was allowed."""

from __future__ import annotations

import os
import re
from pathlib import Path

from geohue.errors import GeohueError

MB = 10**6

PARENT = 380 * MB
"""Peak of the process that fits the cut, with all libraries in it."""

WORKER = 320 * MB
"""Peak of a process that works on blocks."""

_IN_MEMORY = 180  # bytes a point, readers and `geohue.segment`: 133 seen (benchmarks/growth.py)

_UNITS = {"": 1, "k": 10**3, "m": 10**6, "g": 10**9, "t": 10**12}
_BINARY = {"ki": 2**10, "mi": 2**20, "gi": 2**30, "ti": 2**40}
_GROUPS = ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes")


def parse_memory(text: str | int) -> int:
    """Read an amount of memory.

    Raises
    ------
    GeohueError
        If it is none.

    Examples
    --------
    >>> parse_memory("2GB"), parse_memory("1.5GiB"), parse_memory("500 MB")
    (2000000000, 1610612736, 500000000)
    """
    match = re.fullmatch(r"\s*(\d+(?:\.\d*)?)\s*([kmgt]?i?)b?\s*", str(text).lower())
    factor = (_UNITS | _BINARY).get(match.group(2)) if match else None
    if match is None or factor is None:
        raise GeohueError(f"memory {text!r}: expected an amount such as 2GB, 500MB or 1.5GiB")
    return int(float(match.group(1)) * factor)


def processes_within(memory: int | None, wanted: int) -> int:
    """Return how many processes may work at a time.

    Parameters
    ----------
    memory : int or None
        Bytes for all processes together; None for as many as wanted.
    wanted : int
        Most processes.

    Returns
    -------
    int
        1 means that the calling process does the work itself.

    Raises
    ------
    GeohueError
        If not even one process fits.

    Examples
    --------
    >>> processes_within(parse_memory("2GB"), 2), processes_within(parse_memory("500MB"), 8)
    (2, 1)
    """
    if memory is None:
        return wanted
    if memory < PARENT:
        raise GeohueError(f"memory {memory // MB} MB is too little: give at least {PARENT // MB}MB")
    fitting = (memory - PARENT) // WORKER
    return min(wanted, fitting) if fitting >= 2 else 1


def needed_in_memory(n_points: int) -> int:
    """Return the bytes that reading a cloud whole and `geohue.segment` take."""
    return PARENT + n_points * _IN_MEMORY


def available_memory() -> int | None:
    """Return the bytes that this process may still take, None where the system does not say."""
    limits = []
    try:
        text = Path("/proc/meminfo").read_text(encoding="ascii")
        limits += [int(n) * 1024 for n in re.findall(r"MemAvailable:\s+(\d+) kB", text)]
        limits += [int(t) for g in _GROUPS if (t := _text(g)).isdigit()]
    except OSError:
        if hasattr(os, "sysconf") and "SC_PHYS_PAGES" in os.sysconf_names:
            limits.append(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    return min(limits, default=None)


def _text(path: str) -> str:
    file = Path(path)
    return file.read_text(encoding="ascii").strip() if file.is_file() else ""
