"""How the loops that cannot be array operations are compiled.

The machine code is kept on disk, so that only the first run of a version compiles. Compiled code
holds no lock: threads of `geohue.compute.parallel` run it side by side.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit
from numba.core import event

from geohue.compute.first_run import announce
from geohue.errors import GeohueWarning

_F = TypeVar("_F", bound=Callable[..., Any])


class _Announcer(event.Listener):
    """Says when a loop is not in the cache and has to be compiled."""

    def on_start(self, event: event.Event) -> None:  # noqa: ARG002
        announce()

    def on_end(self, event: event.Event) -> None:
        pass


event.register("numba:compile", _Announcer())


def kept_on_disk(function: _F, **options: Any) -> _F:
    """Compile with numba's `options`; without a folder to write to, at every run anew."""
    try:
        return cast(_F, njit(cache=True, nogil=True, **options)(function))
    except RuntimeError:
        warnings.warn(
            "compiled loops cannot be kept, so every run compiles them again: set NUMBA_CACHE_DIR "
            "to a folder that can be written to",
            GeohueWarning,
            stacklevel=1,
        )
        return cast(_F, njit(nogil=True, **options)(function))


def compiled(function: _F) -> _F:
    """Compile a loop whose sums round as written.

    The arrays come from the caller and none is made inside, so their references are not counted
    (``_nrt``): counting every array of a tuple at every call took a third of the fill's time.
    """
    return kept_on_disk(function, forceinline=True, _nrt=False)


def vectorized(function: _F) -> _F:
    """Compile a loop whose sums may be reordered into vector code.

    The order is fixed when the loop is compiled: a machine gives the same sums at every call, and
    machines with other vector lengths may differ in the last digit. NaN and infinity must not
    reach it.
    """
    return kept_on_disk(function, forceinline=True, fastmath=True)
