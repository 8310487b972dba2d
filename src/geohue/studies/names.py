"""Names of methods and cues, as lists of them are given to a study."""

from __future__ import annotations

from collections.abc import Sequence

from geohue.errors import GeohueError
from geohue.features import check_cues, known_cues


def check_names(what: str, given: Sequence[str], known: Sequence[str]) -> None:
    """Raise `GeohueError` unless one or more names are given, all of them known.

    Examples
    --------
    >>> check_names("methods", ["magic"], ["kmeans", "edison"])
    Traceback (most recent call last):
    geohue.errors.GeohueError: methods 'magic': choose among kmeans, edison
    """
    for name in given:
        if name not in known:
            raise GeohueError(f"{what} {name!r}: choose among {', '.join(known)}")
    if not given:
        raise GeohueError(f"no {what} given: choose among {', '.join(known)}")


def check_columns(cues: Sequence[str]) -> None:
    """Raise `GeohueError` unless one or more choices of cues are given, as ``cues=`` takes them."""
    if not cues:
        raise GeohueError(f"no cues given: choose among {', '.join(known_cues())}")
    for name in cues:
        check_cues(name)


def names_in(text: str, known: Sequence[str]) -> tuple[str, ...]:
    """Return the names of a list with commas between, or all that are known.

    Examples
    --------
    >>> names_in("fusion, color", ()), names_in("all", ("best", "fast"))
    (('fusion', 'color'), ('best', 'fast'))
    """
    if text == "all":
        return tuple(known)
    return tuple(name for part in text.split(",") if (name := part.strip()))
