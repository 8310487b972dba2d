"""A run of jobs in a folder of its own: begun once, gone on with under the same settings."""

from __future__ import annotations

import json
from collections.abc import Mapping
from itertools import islice
from pathlib import Path
from typing import Any

from geohue.errors import GeohueError
from geohue.io.atomic import atomic_write
from geohue.io.files import broken, read_bytes, reason

SETTINGS = "run.json"
"""The file that says what a folder's run was asked to do."""


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
        If there is a run with at least a row and `resume` is not set, or that run had other
        settings.

    Examples
    --------
    >>> folder = getfixture("tmp_path")
    >>> open_run(folder, "t.csv", {"k": 2}, {}, resume=False)
    >>> open_run(folder, "t.csv", {"k": 2}, {}, resume=True)
    """
    file = folder / SETTINGS
    known = file.exists() or (folder / table).exists()
    # A run that ended before its first row, for want of a scheduler say, may begin again.
    if not known or (not resume and not has_rows(folder / table)):
        with atomic_write(file) as temporary:
            content = dict(settings) | dict(notes)
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
