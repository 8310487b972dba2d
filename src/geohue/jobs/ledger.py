"""A table on disk that grows by whole rows and survives a kill at any moment."""

from __future__ import annotations

import csv
import errno
import io
import os
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TypeAlias

from geohue.errors import GeohueError
from geohue.read.files import broken, reason
from geohue.results.atomic import atomic_write

Row: TypeAlias = dict[str, str]

_BREAKS = re.compile(r"[\r\n]+")
_APPEND = os.O_WRONLY | os.O_APPEND | getattr(os, "O_BINARY", 0)  # Windows would change line ends


class Ledger:
    """An append-only CSV file.

    A row is one write and is on the disk when `append` returns. What a kill cut off in the last
    line is dropped on opening, so that every row that is read is whole.

    Parameters
    ----------
    path : str or Path
        The file; made with its header if it does not exist.
    fields : sequence of str
        The columns.
    keys : sequence of str
        The columns that name a row; of several rows with one name the last counts.

    Raises
    ------
    GeohueError
        If the file cannot be written or has other columns.

    Examples
    --------
    >>> path = getfixture("tmp_path") / "table.csv"
    >>> Ledger(path, ["frame", "voi"], ["frame"]).append({"frame": "7", "voi": 1.5})
    >>> Ledger(path, ["frame", "voi"], ["frame"]).rows()
    {('7',): {'frame': '7', 'voi': '1.5'}}
    """

    def __init__(self, path: str | Path, fields: Sequence[str], keys: Sequence[str]) -> None:
        self.path = Path(path)
        self.fields = tuple(fields)
        self.keys = tuple(keys)
        header = _line(self.fields)
        if not self.path.exists():
            with atomic_write(self.path) as temporary:
                temporary.write_bytes(header)
            return
        self._drop_torn_line()
        if not self.path.read_bytes().startswith(header):
            raise broken(path, "has other columns; give another folder for this run")

    def rows(self) -> dict[tuple[str, ...], Row]:
        """Return the rows by their names, in the order of their first appearance."""
        with self.path.open(newline="", encoding="utf-8") as file:
            return {tuple(row[key] for key in self.keys): row for row in csv.DictReader(file)}

    def append(self, values: Mapping[str, object]) -> None:
        """Add a row; columns that are not given stay empty."""
        line = _line([_text(values.get(field)) for field in self.fields])
        try:
            handle = os.open(self.path, _APPEND)
            try:
                if os.write(handle, line) < len(line):
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
                os.fsync(handle)
            finally:
                os.close(handle)
        except OSError as error:
            raise GeohueError(
                f"{self.path}: cannot be written ({reason(error)}); make space and resume"
            ) from error

    def sort(self, place: Callable[[tuple[str, ...]], object]) -> None:
        """Write the file anew, each row once, in the order of ``place(name)``."""
        rows = self.rows()
        lines = [_line(self.fields)]
        for name in sorted(rows, key=place):  # type: ignore[arg-type]  # whatever compares
            lines.append(_line([rows[name][field] for field in self.fields]))
        with atomic_write(self.path) as temporary:
            temporary.write_bytes(b"".join(lines))

    def _drop_torn_line(self) -> None:
        content = self.path.read_bytes()
        whole = content.rfind(b"\n") + 1
        if whole < len(content):
            with self.path.open("r+b") as file:
                file.truncate(whole)


def _line(values: Sequence[str]) -> bytes:
    text = io.StringIO()
    # One line a row: a line break inside a value would make a torn row look whole.
    csv.writer(text, lineterminator="\n").writerow([_BREAKS.sub(" ", v) for v in values])
    return text.getvalue().encode()


def _text(value: object) -> str:
    if value is None:
        return ""
    return repr(float(value)) if isinstance(value, float) else str(value)
