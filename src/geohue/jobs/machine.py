"""What figures were measured on: processor and versions, nothing that names the computer."""

from __future__ import annotations

import platform
import re
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from geohue.compute.parallel import cores

PACKAGES = ("numpy", "scipy", "scikit-image", "opencv-python-headless", "numba")


def describe_machine() -> dict[str, str]:
    """Return the processor, the system and the versions of what computes.

    Examples
    --------
    >>> sorted(describe_machine())[:3]
    ['cpu', 'numba', 'numpy']
    """
    return {"cpu": _cpu(), "system": f"{platform.system()} {platform.machine()}"} | {
        "python": platform.python_version(),
        **{name: _version(name) for name in PACKAGES},
    }


def _cpu() -> str:
    try:
        found = re.search(r"model name\s*:\s*(.+)", Path("/proc/cpuinfo").read_text("utf-8"))
    except OSError:
        found = None
    name = found.group(1).strip() if found else platform.processor() or platform.machine()
    return f"{cores()} core(s), {' '.join(name.split())}"


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
