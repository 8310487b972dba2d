"""Checks of settings: one error that names the setting, its value and what is expected."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from numbers import Integral, Real

from geohue.errors import GeohueError


def is_whole(value: object) -> bool:
    """Whether a value is a whole number, NumPy's included; True and False are not.

    Examples
    --------
    >>> is_whole(3), is_whole(3.0), is_whole(True)
    (True, False, False)
    """
    return isinstance(value, Integral) and not isinstance(value, bool)


def is_number(value: object) -> bool:
    """Whether a value is a real number and not NaN; True and False are not numbers."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return False
    return not math.isnan(value)


def check_whole(name: str, value: object, least: int) -> None:
    """Raise `GeohueError` unless a setting is a whole number of at least `least`.

    Examples
    --------
    >>> check_whole("landmarks", -1, 1)
    Traceback (most recent call last):
    geohue.errors.GeohueError: landmarks is -1: expected a whole number of at least 1
    """
    if not (is_whole(value) and value >= least):  # type: ignore[operator]
        raise GeohueError(f"{name} is {value!r}: expected a whole number of at least {least}")


def check_share(name: str, value: object) -> None:
    """Raise `GeohueError` unless a setting is a share, from 0 to 1."""
    if not (is_number(value) and 0 <= value <= 1):  # type: ignore[operator]
        raise GeohueError(f"{name} is {value!r}: expected a number from 0 to 1")


def check_positive(name: str, value: object) -> None:
    """Raise `GeohueError` unless a setting is a finite number above 0."""
    if not (is_number(value) and 0 < value < math.inf):  # type: ignore[operator]
        raise GeohueError(f"{name} is {value!r}: expected a finite number above 0")


def check_choice(name: str, value: object, known: Sequence[str]) -> None:
    """Raise `GeohueError` unless a setting is one of the known names.

    Examples
    --------
    >>> check_choice("fit", "some", ("all", "draft"))
    Traceback (most recent call last):
    geohue.errors.GeohueError: fit 'some': choose one of all, draft
    """
    if value not in known:
        raise GeohueError(f"{name} {value!r}: choose one of {', '.join(known)}")


def check_steps(name: str, values: object) -> None:
    """Raise `GeohueError` unless a setting is a tuple of finite numbers above 0."""
    if not isinstance(values, tuple):
        raise GeohueError(f"{name} is {values!r}: expected a tuple of numbers")
    for value in values:
        check_positive(f"a number of {name}", value)


def check_weights(name: str, values: object) -> None:
    """Raise `GeohueError` unless a setting is one or more positive weights in increasing order.

    Examples
    --------
    >>> check_weights("compared", (1.0, -0.5))
    Traceback (most recent call last):
    geohue.errors.GeohueError: a number of compared is -0.5: expected a finite number above 0
    """
    check_steps(name, values)
    weights: tuple[float, ...] = values  # type: ignore[assignment]
    if not weights or any(a >= b for a, b in pairwise(weights)):
        raise GeohueError(f"{name} is {values!r}: expected one or more weights in increasing order")
