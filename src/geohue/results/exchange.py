"""Two folders change places in one step, where the system can do that."""

from __future__ import annotations

import os
import sys
from pathlib import Path

_HERE = -100  # AT_FDCWD: names are relative to the working folder
_EXCHANGE = 2  # RENAME_EXCHANGE of Linux, RENAME_SWAP of macOS


def exchange(one: Path, other: Path) -> bool:
    """Exchange two folders of one disk; returns whether that was possible.

    Nothing has happened where it was not: not every system and file system can do it, and none can
    where one of the folders is the root of a disk.

    Examples
    --------
    >>> folder = getfixture("tmp_path")
    >>> exchange(folder / "not there", folder / "nor this")
    False
    """
    import ctypes

    if sys.platform == "win32":
        return False
    library = ctypes.CDLL(None, use_errno=True)
    a, b = os.fsencode(one), os.fsencode(other)
    if hasattr(library, "renameat2"):
        return bool(library.renameat2(_HERE, a, _HERE, b, _EXCHANGE) == 0)
    if hasattr(library, "renamex_np"):
        return bool(library.renamex_np(a, b, _EXCHANGE) == 0)
    return False
