"""Import every file of the package, as an environment without extras must be able to.

A file that needs an extra may say so, in the words that tell how to install it.
"""

from __future__ import annotations

import importlib
import pkgutil
import sys

import geohue
from geohue.errors import GeohueError

NEEDS = {"geohue.web": "starlette"}
"""Rooms that nothing imports without their extra, and the library that they may lack."""


def is_expected(name: str, error: Exception) -> bool:
    """Whether a file may fail so: it says how to install what it needs, or its room does."""
    lacks = getattr(error, "name", None)
    room = any(name.startswith(f"{room}.") and lacks == needed for room, needed in NEEDS.items())
    return room or "pip install 'geohue[" in str(error)


def main() -> int:
    """Return 1 if a file cannot be imported."""
    failed = 0
    for found in pkgutil.walk_packages(geohue.__path__, "geohue."):
        if found.name == "geohue.__main__":
            continue
        try:
            importlib.import_module(found.name)
        except (GeohueError, ImportError) as error:
            if not is_expected(found.name, error):
                sys.stderr.write(f"{found.name}: {error}\n")
                failed = 1
    return failed


if __name__ == "__main__":
    sys.exit(main())
