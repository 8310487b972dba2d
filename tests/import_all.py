"""Import every file of the package, as an environment without extras must be able to.

A file that needs an extra may say so, in the words that tell how to install it.
"""

from __future__ import annotations

import importlib
import pkgutil
import sys

import geohue
from geohue.errors import GeohueError


def main() -> int:
    """Return 1 if a file cannot be imported."""
    failed = 0
    for found in pkgutil.walk_packages(geohue.__path__, "geohue."):
        if found.name == "geohue.__main__":
            continue
        try:
            importlib.import_module(found.name)
        except (GeohueError, ImportError) as error:
            if "pip install 'geohue[" not in str(error):
                sys.stderr.write(f"{found.name}: {error}\n")
                failed = 1
    return failed


if __name__ == "__main__":
    sys.exit(main())
