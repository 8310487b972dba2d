"""What a run has done so far, on disk, so that a killed one goes on where it was."""

from __future__ import annotations

import json
import shutil
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.io.atomic import atomic_write
from geohue.io.files import read_bytes
from geohue.jobs.ledger import Ledger
from geohue.large.arrays import from_arrays, to_arrays
from geohue.large.fit import Decision, Fitted
from geohue.large.moments import Moments
from geohue.large.sample import SAMPLE_ROW

STATE = "state"
"""The folder inside that of the results; it goes when the run ends."""


def has_state(out: Path) -> bool:
    """Whether a folder has an unfinished run."""
    return (out / STATE / "run.json").exists()


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
        Whether to go on with a run that is there.

    Raises
    ------
    GeohueError
        If there is an unfinished run and `resume` is not set, or it had other settings.
    """

    def __init__(self, out: Path, settings: dict[str, Any], resume: bool) -> None:
        self.folder = out / STATE
        file = self.folder / "run.json"
        settings = json.loads(json.dumps(settings))
        if file.exists():
            if not resume:
                raise GeohueError(
                    f"{out}: has an unfinished run; go on with --resume, or remove {self.folder}"
                )
            _compare(out, json.loads(read_bytes(file)), settings)
        else:
            with atomic_write(file) as temporary:
                temporary.write_text(json.dumps(settings, indent=2) + "\n", encoding="utf-8")
        self._measured = Ledger(self.folder / "measured.csv", ("start", "moments"), ("start",))
        self._labelled = Ledger(self.folder / "labelled.csv", ("start", "counts"), ("start",))

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
        file = self.folder / "sample.bin"
        if not file.exists():
            with atomic_write(file) as temporary, temporary.open("r+b") as empty:
                empty.truncate(size * SAMPLE_ROW.itemsize)
        with file.open("r+b") as handle:
            handle.seek(slot * SAMPLE_ROW.itemsize)
            handle.write(sample.tobytes())
        numbers = " ".join(repr(float(number)) for number in moments.numbers())
        self._measured.append({"start": start, "moments": numbers})

    def sample(self) -> NDArray[np.void]:
        """Return the whole sample, (m,) `SAMPLE_ROW`."""
        return np.fromfile(self.folder / "sample.bin", SAMPLE_ROW)

    def fit(self) -> tuple[Fitted, Decision] | None:
        """Return what was fitted, if it was."""
        file = self.folder / "fit.npz"
        if not file.exists():
            return None
        with np.load(file) as arrays:
            content = json.loads(str(arrays["decision"]))
            curve = [(weight, value) for weight, value in content.pop("curve")]
            notes = tuple(content.pop("notes"))
            return from_arrays(Fitted, arrays), Decision(**content, curve=curve, notes=notes)

    def keep_fit(self, fitted: Fitted, decision: Decision) -> None:
        """Keep what was fitted."""
        text = np.array(json.dumps(asdict(decision)))
        with atomic_write(self.folder / "fit.npz") as temporary:
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

    def end(self) -> None:
        """Remove the state of a finished run."""
        shutil.rmtree(self.folder)


def _compare(out: Path, before: dict[str, Any], now: dict[str, Any]) -> None:
    for name, value in now.items():
        if before.get(name) != value:
            raise GeohueError(
                f"{out}: the run there has {name} = {before.get(name)}, this one {value}; "
                f"give another folder, or remove {out / STATE}"
            )
