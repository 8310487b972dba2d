"""Numbers written as text, a row a line: the body of ASCII PLY and PCD files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.read.files import broken, reason


def text_lines(body: bytes) -> Iterator[str]:
    r"""Yield the lines that are not blank, whatever ends them.

    Examples
    --------
    >>> list(text_lines(b"1 2\r\n\n 3 4\r5 6"))
    ['1 2', ' 3 4', '5 6']
    """
    start = 0
    if b"\r" in body:
        body = body.replace(b"\r", b"\n")
    while start < len(body):
        end = body.find(b"\n", start)
        end = len(body) if end < 0 else end
        line = body[start:end]
        start = end + 1
        if line and not line.isspace():
            yield line.decode("latin-1")


def read_table(
    lines: Iterator[str], count: int, columns: Sequence[int], width: int, path: str | Path
) -> NDArray[np.float64]:
    """Read `count` rows of `width` numbers and return the chosen columns.

    Parameters
    ----------
    lines : iterator of str
        Lines that are not blank; as many are taken as there are rows.
    count : int
        Rows; the caller has checked that the file can hold so many.
    columns : sequence of int
        Which columns to return.
    width : int
        Numbers that a row has at least.
    path : path-like
        Named in errors.

    Returns
    -------
    (count, len(columns)) float64

    Raises
    ------
    GeohueError
        If there are fewer rows, shorter rows or something that is no number.
    """
    taken = 0

    def rows() -> Iterator[str]:
        nonlocal taken
        for taken, line in enumerate(islice(lines, count), start=1):  # noqa: B007
            yield line

    reading = rows()
    first = next(reading, None)
    if first is None:
        raise broken(path, f"is cut short: 0 of {count} rows; copy or export it again")
    if len(first.split()) < width:
        cause = f"the first row has {len(first.split())} numbers instead of {width}"
        raise broken(path, f"{cause}; export it again")
    try:
        whole = _chain(first, reading)
        table = np.loadtxt(whole, np.float64, comments=None, usecols=tuple(columns), ndmin=2)
    except (ValueError, OverflowError) as error:
        raise broken(path, f"row {taken} is damaged ({reason(error)}); export it again") from error
    if len(table) < count:
        raise broken(path, f"is cut short: {len(table)} of {count} rows; copy or export it again")
    return table


def _chain(first: str, rest: Iterator[str]) -> Iterator[str]:
    yield first
    yield from rest


def as_declared(column: NDArray[np.float64], dtype: np.dtype[Any]) -> NDArray[Any]:
    """Return a column as the integers that its file declares; other types stay float64.

    Examples
    --------
    >>> as_declared(np.array([3.0, 300.0, np.nan]), np.dtype("u1"))
    array([  3, 255,   0], dtype=uint8)
    """
    if dtype.kind == "f" or dtype.itemsize > 4:
        return column
    limits = np.iinfo(dtype)
    return np.clip(np.nan_to_num(column), limits.min, limits.max).astype(dtype)
