"""What a run has done so far, on disk, so that a killed one goes on where it was."""

from __future__ import annotations

import json
import os
import shutil
from dataclasses import asdict
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.jobs.ledger import Ledger
from geohue.jobs.run import has_rows
from geohue.large.arrays import from_arrays, to_arrays
from geohue.large.fit import Decision, Fitted
from geohue.large.moments import Moments
from geohue.large.sample import SAMPLE_ROW
from geohue.read.files import broken, read_bytes, reason
from geohue.results.atomic import atomic_write

STATE = "state"
"""The folder inside that of the results; it goes when the run ends."""

_SETTINGS = "run.json"
_MEASURED, _LABELLED, _SAMPLE, _FIT = "measured.csv", "labelled.csv", "sample.bin", "fit.npz"
_FILES = (_MEASURED, _LABELLED, _SAMPLE, _FIT)
_FITTING = ("k", "weight", "settings")  # settings on which the first pass does not depend
_WRITING = ("formats",)  # nor does the cut


def has_state(out: Path) -> bool:
    """Whether a folder has an unfinished run."""
    return (out / STATE / _SETTINGS).exists()


class State:
    """The state of one run.

    Parameters
    ----------
    out : Path
        Folder of the results.
    settings : dict
        What makes this run this one: the input, its size and age, and every setting that the
        labels depend on.
    resume : bool
        Whether to go on with a run that is there. What was measured is kept for another k, weight,
        preset or format; what these change is done again.

    Raises
    ------
    GeohueError
        If there is an unfinished run and `resume` is not set, or it was of another input, version,
        seed or other cues.
    """

    def __init__(self, out: Path, settings: dict[str, Any], resume: bool) -> None:
        self.folder = out / STATE
        file = self.folder / _SETTINGS
        settings = json.loads(json.dumps(settings))
        # A run that ended before its first stretch, for want of a scheduler say, may begin again.
        if file.exists() and (resume or has_rows(self.folder / _MEASURED)):
            if not resume:
                raise GeohueError(
                    f"{out}: has an unfinished run; go on with --resume, or remove {self.folder}"
                )
            changed = _compare(out, _settings_of(file), settings)
            stale = {_LABELLED} if changed else set()
            stale |= {_FIT} if changed & set(_FITTING) else set()
        else:
            stale = set(_FILES)  # perhaps of a run whose end was cut off
        for name in stale:
            (self.folder / name).unlink(missing_ok=True)
        if stale:
            with atomic_write(file) as temporary:
                temporary.write_text(json.dumps(settings, indent=2) + "\n", encoding="utf-8")
        self._measured = Ledger(self.folder / _MEASURED, ("start", "moments"), ("start",))
        self._labelled = Ledger(self.folder / _LABELLED, ("start", "counts"), ("start",))

    def measured(self) -> dict[int, Moments]:
        """Return the moments of the stretches that were measured, by their first points."""
        rows = self._measured.rows()
        return {
            int(start): Moments.from_numbers(map(float, row["moments"].split()))
            for (start,), row in rows.items()
        }

    def add_measured(
        self, start: int, moments: Moments, slot: int, sample: NDArray[np.void], size: int
    ) -> None:
        """Keep what was measured of a stretch: its part of the sample first, then its row."""
        file = self.folder / _SAMPLE
        if not file.exists():
            with atomic_write(file) as temporary, temporary.open("r+b") as empty:
                empty.truncate(size * SAMPLE_ROW.itemsize)
        with file.open("r+b") as handle:
            handle.seek(slot * SAMPLE_ROW.itemsize)
            handle.write(sample.tobytes())
            handle.flush()
            os.fsync(handle.fileno())
        numbers = " ".join(repr(float(number)) for number in moments.numbers())
        self._measured.append({"start": start, "moments": numbers})

    def sample(self) -> NDArray[np.void]:
        """Return the whole sample, (m,) `SAMPLE_ROW`."""
        return np.fromfile(self.folder / _SAMPLE, SAMPLE_ROW)

    def fit(self) -> tuple[Fitted, Decision] | None:
        """Return what was fitted, if it was."""
        file = self.folder / _FIT
        if not file.exists():
            return None
        try:
            with file.open("rb") as handle, np.load(handle) as arrays:
                content = json.loads(str(arrays["decision"]))
                curve = [(weight, value) for weight, value in content.pop("curve")]
                notes = tuple(content.pop("notes"))
                return from_arrays(Fitted, arrays), Decision(**content, curve=curve, notes=notes)
        except (ValueError, KeyError, TypeError, EOFError, OSError, BadZipFile) as error:
            raise broken(file, f"is damaged ({reason(error)}); remove it and resume") from error

    def keep_fit(self, fitted: Fitted, decision: Decision) -> None:
        """Keep what was fitted."""
        text = np.array(json.dumps(asdict(decision)))
        with atomic_write(self.folder / _FIT) as temporary:
            np.savez(temporary, decision=text, **to_arrays(fitted))  # type: ignore[arg-type]

    def labelled(self) -> dict[int, list[int]]:
        """Return the counts of the stretches that were labelled, by their first points."""
        rows = self._labelled.rows()
        return {int(s): [int(n) for n in row["counts"].split()] for (s,), row in rows.items()}

    def add_labelled(self, start: int, counts: list[int]) -> None:
        """Keep that a stretch was labelled."""
        self._labelled.append({"start": start, "counts": " ".join(map(str, counts))})

    def forget_labelled(self) -> None:
        """Begin the second pass again."""
        self._labelled.path.unlink()
        self._labelled = Ledger(self._labelled.path, ("start", "counts"), ("start",))

    def fresh_folder(self) -> Path:
        """Return an empty folder for files that are to appear at the end."""
        folder = self.folder / "whole"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        return folder

    def end(self) -> None:
        """Remove the state of a finished run, first what says that there is one."""
        (self.folder / _SETTINGS).unlink()
        shutil.rmtree(self.folder)


def _settings_of(file: Path) -> dict[str, Any]:
    try:
        return dict(json.loads(read_bytes(file)))
    except (TypeError, ValueError) as error:
        if isinstance(error, GeohueError):
            raise
        cause = f"is damaged ({reason(error)}); remove {file.parent} to begin again"
        raise broken(file, cause) from error


def _compare(out: Path, before: dict[str, Any], now: dict[str, Any]) -> set[str]:
    """Return which settings differ; an error if what was measured is of no use with one of them."""
    differing = {name for name, value in now.items() if before.get(name) != value}
    for name, value in now.items():
        if name in differing - {*_FITTING, *_WRITING}:
            raise GeohueError(
                f"{out}: the run there has {name} = {before.get(name)}, this one {value}; "
                f"give another folder, or remove {out / STATE}"
            )
    return differing
