"""How the loops of the fill are compiled."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

_F = TypeVar("_F", bound=Callable[..., Any])


def compiled(function: _F) -> _F:
    """Compile, keep the code on disk, and let other Python threads run meanwhile.

    The arrays come from the caller and none is made inside, so their references are not counted
    (``_nrt``): counting every array of a tuple at every call took a third of the time. No
    fast-math, so that sums round as written.
    """
    options: dict[str, Any] = {"cache": True, "nogil": True, "forceinline": True, "_nrt": False}
    return cast(_F, njit(**options)(function))
