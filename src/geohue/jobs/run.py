"""A run of jobs in a folder of its own: begun once, gone on with under the same settings."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, Protocol, TypeVar

from geohue._version import __version__
from geohue.errors import GeohueError
from geohue.jobs.ledger import Ledger, Row
from geohue.jobs.lock import only_run
from geohue.jobs.machine import describe_machine
from geohue.jobs.pool import check_timeout, run_jobs
from geohue.read.files import broken, read_bytes, reason
from geohue.results.atomic import atomic_write

SETTINGS = "run.json"
"""The file that says what a folder's run was asked to do."""

Progress = Callable[[int, int, str], None]
"""Called with the number of jobs done, their number in all, and a line about the last."""

_TABLE = "table"  # what tells runs of different commands apart


class Keyed(Protocol):
    """A job that has a row."""

    @property
    def key(self) -> tuple[str, ...]:
        """The name of its row: the key columns."""


KeyedJob = TypeVar("KeyedJob", bound=Keyed)


@dataclass(frozen=True, slots=True)
class Table:
    """The table of a run (`Ledger`).

    Attributes
    ----------
    name : str
        Of the file.
    fields : tuple of str
        The columns; ``error`` is one.
    keys : tuple of str
        Those that name a row.
    """

    name: str
    fields: tuple[str, ...]
    keys: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Place:
    """Where the jobs run, and how long each may take: as of `run_jobs`."""

    processes: int = 1
    scheduler: str | None = None
    timeout: float | None = None

    def __post_init__(self) -> None:
        check_timeout(self.timeout, self.scheduler)


def run_table(
    folder: Path,
    table: Table,
    settings: Mapping[str, Any],
    function: Callable[[KeyedJob], Mapping[str, Any]],
    jobs: Sequence[KeyedJob],
    place: Place,
    *,
    resume: bool = False,
    progress: Progress | None = None,
) -> list[Row]:
    """Run every job that has no row yet, each a row of a folder's table as it ends.

    Parameters
    ----------
    folder : Path
        Receives the table and `SETTINGS`, in which the version and the machine stand, too.
    table : Table
    settings : mapping
        What must not change within a run, beside the version; ready for JSON.
    function : callable
        Returns the cells of a job's row but for its key and error.
    jobs : sequence of Keyed
    place : Place
    resume : bool
        Go on with what is in `folder`: rows are kept, failures tried once more.
    progress : callable, optional
        See `Progress`.

    Returns
    -------
    list of dict of str to str
        The rows, in the order of `jobs`; ``error`` is not empty where one failed.

    Raises
    ------
    GeohueError
        As `open_run`, `only_run` and `run_jobs` do.
    """
    with only_run(folder):
        asked, notes = {"version": __version__, **settings}, {"machine": describe_machine()}
        open_run(folder, table.name, asked, notes, resume)
        ledger = Ledger(folder / table.name, table.fields, table.keys)
        done = {key for key, row in ledger.rows().items() if not row["error"]}
        todo = [job for job in jobs if job.key not in done]
        outcomes = run_jobs(function, todo, place.processes, place.scheduler, place.timeout)
        for count, outcome in enumerate(outcomes, start=len(jobs) - len(todo) + 1):
            key, error = outcome.job.key, outcome.error or ""
            named = dict(zip(table.keys, key, strict=True))
            ledger.append(named | dict(outcome.result or {}) | {"error": error})
            if progress is not None:
                text = " ".join(part for part in key if part != "-")
                progress(count, len(jobs), f"{text}: {error}" if error else text)
        order = {job.key: i for i, job in enumerate(jobs)}
        # Rows of an earlier, larger run stay, at the end.
        ledger.sort(lambda key: (order.get(key, len(order)), key))
        rows = ledger.rows()
        return [rows[job.key] for job in jobs]


def open_run(
    folder: Path,
    table: str,
    settings: Mapping[str, Any],
    notes: Mapping[str, Any],
    resume: bool,
) -> None:
    """Begin a run in a folder, or make sure that the one there is the same.

    Parameters
    ----------
    folder : Path
        Made if it does not exist.
    table : str
        The name of the run's table.
    settings : mapping
        What must not change within a run; ready for JSON.
    notes : mapping
        What is written down beside it and may change, such as the machine.
    resume : bool
        Whether to go on with a run that is there.

    Raises
    ------
    GeohueError
        If there is a run with at least a row and `resume` is not set, that run had other
        settings, or was one of another command.

    Examples
    --------
    >>> folder = getfixture("tmp_path")
    >>> open_run(folder, "t.csv", {"k": 2}, {}, resume=False)
    >>> open_run(folder, "t.csv", {"k": 2}, {}, resume=True)
    """
    file = folder / SETTINGS
    other = _table_of(file)
    if other not in (None, table) and has_rows(folder / other):
        raise GeohueError(f"{folder}: has a run of another command ({other}); give another folder")
    known = file.exists() or (folder / table).exists()
    # A run that ended before its first row, for want of a scheduler say, may begin again.
    if not known or (not resume and not has_rows(folder / table)):
        with atomic_write(file) as temporary:
            content = dict(settings) | dict(notes) | {_TABLE: table}
            temporary.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
        return
    if not resume:
        raise GeohueError(f"{folder}: has a run already; use --resume, or give another folder")
    before = _settings_of(file)
    for name, value in json.loads(json.dumps(dict(settings))).items():
        if before.get(name) != value:
            raise GeohueError(
                f"{folder}: the run there has {name} = {before.get(name)}, this one {value}; "
                "give another folder"
            )


def has_rows(table: Path) -> bool:
    """Whether a table (`Ledger`) is there and has more than its header."""
    if not table.exists():
        return False
    with table.open("rb") as file:
        return len(list(islice(file, 2))) == 2


def _table_of(file: Path) -> str | None:
    """Return the name of the table of a folder's run, None if it has none or does not say."""
    try:
        name = _settings_of(file).get(_TABLE) if file.exists() else None
    except GeohueError:  # said where it matters
        return None
    return Path(name).name if isinstance(name, str) else None


def _settings_of(file: Path) -> dict[str, Any]:
    try:
        content = json.loads(read_bytes(file))
    except ValueError as error:
        if isinstance(error, GeohueError):
            raise
        raise broken(file, f"is damaged ({reason(error)}); give another folder") from error
    if not isinstance(content, dict):
        raise broken(file, "has no settings; give another folder")
    return content
