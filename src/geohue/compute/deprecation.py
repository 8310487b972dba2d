"""How public names change: the old one works with a warning for two minor versions."""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable
from typing import ParamSpec, TypeVar

from geohue.errors import GeohueError

P = ParamSpec("P")
R = TypeVar("R")


def deprecated(since: str, gone: str, instead: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Mark a public function that will go.

    Parameters
    ----------
    since, gone : str
        The versions in which the warning begins, and in which the function is no longer there.
    instead : str
        What to write in its place.

    Returns
    -------
    callable
        A decorator. What it decorates warns with a FutureWarning, which Python shows to everyone.

    Examples
    --------
    >>> @deprecated(since="1.1", gone="1.3", instead="new()")
    ... def old() -> int:
    ...     return 3
    >>> with warnings.catch_warnings(record=True) as seen:
    ...     warnings.simplefilter("always")
    ...     old()
    3
    >>> print(seen[0].message)
    old() goes in geohue 1.3 (deprecated since 1.1): write new() instead
    """

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        @functools.wraps(function)
        def warned(*args: P.args, **kwargs: P.kwargs) -> R:
            _warn(f"{function.__name__}()", since, gone, instead)
            return function(*args, **kwargs)

        return warned

    return decorate


def renamed_argument(
    old: str, new: str, since: str, gone: str
) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Let a public function take an argument by its old name too, with a warning.

    Parameters
    ----------
    old, new : str
        The names of the argument.
    since, gone : str
        The versions in which the warning begins, and in which the old name is an error.

    Returns
    -------
    callable
        A decorator. The function raises GeohueError if it is given both names.

    Examples
    --------
    >>> @renamed_argument("n", "count", since="1.1", gone="1.3")
    ... def double(count: int) -> int:
    ...     return 2 * count
    >>> with warnings.catch_warnings(record=True) as seen:
    ...     warnings.simplefilter("always")
    ...     double(n=2)
    4
    >>> print(seen[0].message)
    double(n=...) goes in geohue 1.3 (deprecated since 1.1): write double(count=...) instead
    """

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        name = function.__name__

        @functools.wraps(function)
        def accepting(*args: P.args, **kwargs: P.kwargs) -> R:
            if old in kwargs:
                if new in kwargs:
                    raise GeohueError(f"{name} got both {old} and {new}: leave out {old}")
                _warn(f"{name}({old}=...)", since, gone, f"{name}({new}=...)")
                kwargs[new] = kwargs.pop(old)
            return function(*args, **kwargs)

        return accepting

    return decorate


def _warn(what: str, since: str, gone: str, instead: str) -> None:
    text = f"{what} goes in geohue {gone} (deprecated since {since}): write {instead} instead"
    warnings.warn(text, FutureWarning, stacklevel=3)
