"""How the loops that cannot be array operations are compiled.

The machine code is kept on disk, so that only the first run of a version compiles. Compiled code
holds no lock: threads of `geohue.compute.parallel` run it side by side.
"""

from __future__ import annotations

import gc
import warnings
from collections.abc import Callable
from functools import cache
from hashlib import sha256
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar, cast

from numba import njit
from numba.core import event
from numba.core.caching import FunctionCache
from numba.core.dispatcher import Dispatcher
from numba.core.runtime.nrt import rtsys
from numba.extending import register_jitable

from geohue.compute import ahead
from geohue.compute.first_run import announce
from geohue.errors import GeohueWarning

_F = TypeVar("_F", bound=Callable[..., Any])

_parts: set[Callable[..., Any]] = set()


class _Announcer(event.Listener):
    """Says when a loop is not in the cache and has to be compiled.

    Meanwhile no garbage is looked for: there is next to none among the many objects of a compiler,
    and looking took a twentieth of the time.
    """

    def __init__(self) -> None:
        self._depth, self._collects = 0, False

    def on_start(self, event: event.Event) -> None:  # noqa: ARG002
        announce()
        if self._depth == 0:
            self._collects = gc.isenabled()
            gc.disable()
        self._depth += 1

    def on_end(self, event: event.Event) -> None:  # noqa: ARG002
        self._depth -= 1
        if self._depth == 0 and self._collects:
            gc.enable()


event.register("numba:compile", _Announcer())


class _Cache(FunctionCache):
    """Machine code on disk that other processes may be about to write."""

    def depend_on(self, inlined: str) -> None:
        """Make what is on disk stale when what is compiled into it from other files changes.

        numba looks at the file of the function alone. Its index of a function's machine code is
        used as long as the stamp in it, which gets the hash `inlined` here, is that on disk.
        """
        index = self._cache_file
        index._source_stamp = (index._source_stamp, inlined)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Load the machine code for a signature, None if there is none."""
        found = self._load(sig, target_context)
        if found is None and ahead.wait_for(name_of(self._py_func)):
            found = self._load(sig, target_context)
        return found

    def _load(self, sig: Any, target_context: Any) -> Any:
        """Load what is there without all that numba knows of compiling, as its own method would.

        Machine code needs no more than the runtime to be run; the rest is a fifth of a second of
        imports, and is made up for when something has to be compiled.
        """
        rtsys.initialize(target_context)
        with self._guard_against_spurious_io_errors():
            load: Any = self._load_overload
            return load(sig, target_context)

    def is_empty(self) -> bool:
        """Whether nothing is kept of this version."""
        return not self._cache_file._load_index()


def name_of(loop: Callable[..., Any]) -> str:
    """Return the name that `geohue.compute.ahead` knows a loop by."""
    return f"{loop.__module__}.{loop.__qualname__}"


def is_missing(loop: Any) -> bool:
    """Whether a loop is not kept on disk, but could be."""
    return isinstance(loop._cache, _Cache) and loop._cache.is_empty()


def kept_on_disk(function: _F, **options: Any) -> _F:
    """Compile with numba's `options`; without a folder to write to, at every run anew.

    Left out is what costs time to compile and is of no use here: an entry for C, and the checks
    of every division, which is by 0 nowhere and would give inf or NaN.
    """
    given: dict[str, Any] = {"no_cfunc_wrapper": True, "error_model": "numpy"} | options
    try:
        kept: Any = njit(nogil=True, **given)(function)
        make: Any = _Cache
        kept._cache = make(function)
        kept._cache.depend_on(_inlined(function))
        return cast(_F, kept)
    except RuntimeError:
        warnings.warn(
            "compiled loops cannot be kept, so every run compiles them again: set NUMBA_CACHE_DIR "
            "to a folder that can be written to",
            GeohueWarning,
            stacklevel=1,
        )
        return cast(_F, njit(nogil=True, **given)(function))


def _inlined(function: Callable[..., Any]) -> str:
    """Return a hash of the sources and constants from which a loop may take parts.

    These are the files of the compiled functions that its module names, of those that their modules
    name, and so on, and the modules' constants (names in capitals), which other files may give.
    """
    parts: dict[str, str] = {}
    waiting = [function]
    while waiting:
        current = waiting.pop()
        names = current.__globals__
        file = current.__code__.co_filename
        if file in parts:
            continue
        constants = [(k, repr(v)) for k, v in names.items() if k.isupper() and _is_constant(v)]
        # Numba looks after the function's own file.
        parts[file] = repr(sorted(constants)) + ("" if current is function else _content(file))
        waiting += [value.py_func for value in names.values() if isinstance(value, Dispatcher)]
        waiting += [v for v in names.values() if isinstance(v, FunctionType) and v in _parts]
    return sha256(repr(sorted(parts.items())).encode()).hexdigest()


def _is_constant(value: object) -> bool:
    if isinstance(value, tuple):  # of functions, say, it would differ from run to run
        return all(_is_constant(part) for part in value)
    return isinstance(value, bool | int | float | str)


@cache
def _content(file: str) -> str:
    try:
        return sha256(Path(file).read_bytes()).hexdigest()
    except OSError:  # not a file, as in a notebook: numba keeps nothing of it either
        return ""


def within_loops(function: _F, **options: Any) -> _F:
    """Let a function be compiled into the loops that call it; for Python it stays as it is.

    It gets no entry for Python and no file of its own, which would be a third of the time that it
    takes to compile.
    """
    _parts.add(function)
    given = {"nogil": True, "error_model": "numpy", "no_cpython_wrapper": True}
    return register_jitable(**given, no_cfunc_wrapper=True, **options)(function)


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


def compiled_part(function: _F) -> _F:
    """Compile what loops of `compiled` call, as part of these."""
    return within_loops(function, forceinline=True, _nrt=False)


def vectorized_part(function: _F) -> _F:
    """Compile what loops of `vectorized` call, as part of these."""
    return within_loops(function, forceinline=True, fastmath=True)
