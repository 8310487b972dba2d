"""How the loops that cannot be array operations are compiled.

The machine code is kept on disk, so that only the first run of a version compiles. Compiled code
holds no lock: threads of `geohue.parallel` run it side by side.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

_F = TypeVar("_F", bound=Callable[..., Any])


def compiled(function: _F) -> _F:
    """Compile a loop whose sums round as written.

    The arrays come from the caller and none is made inside, so their references are not counted
    (``_nrt``): counting every array of a tuple at every call took a third of the fill's time.
    """
    options: dict[str, Any] = {"cache": True, "nogil": True, "forceinline": True, "_nrt": False}
    return cast(_F, njit(**options)(function))


def vectorized(function: _F) -> _F:
    """Compile a loop whose sums may be reordered into vector code.

    The order is fixed when the loop is compiled: a machine gives the same sums at every call, and
    machines with other vector lengths may differ in the last digit. NaN and infinity must not
    reach it.
    """
    options: dict[str, Any] = {"cache": True, "nogil": True, "forceinline": True, "fastmath": True}
    return cast(_F, njit(**options)(function))
