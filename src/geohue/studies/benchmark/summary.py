"""A run in a few lines: mean, median and spread of each trial."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.jobs.ledger import Row

TRIAL = ("method", "cues", "preset")

SHOWN = {
    "voi_bits": "VoI (bits)",
    "rand": "Rand",
    "covering": "covering",
    "boundary_f": "boundary F",
    "n_pred": "K",
    "seconds": "CPU s",
}
"""The measures of the table, and their headings."""


@dataclass(frozen=True, slots=True)
class Spread:
    """Where the values of a measure lie."""

    mean: float
    median: float
    deviation: float
    low: float
    high: float

    @classmethod
    def of(cls, values: Iterable[float]) -> Spread:
        """Return mean, median, standard deviation and quartiles.

        Examples
        --------
        >>> Spread.of([1.0, 2.0, 6.0])
        Spread(mean=3.0, median=2.0, deviation=2.160246899469287, low=1.5, high=4.0)
        """
        array = np.array(list(values), np.float64)
        low, median, high = np.quantile(array, (0.25, 0.5, 0.75))
        numbers = (array.mean(), median, array.std(), low, high)
        return cls(*(float(number) for number in numbers))


@dataclass(frozen=True, slots=True)
class TrialSummary:
    """All frames of one trial."""

    trial: tuple[str, ...]
    frames: int
    failures: int
    measures: dict[str, Spread]

    @property
    def name(self) -> str:
        """The trial as text."""
        return " ".join(part for part in self.trial if part != "-")


def by_trial(rows: Iterable[Row]) -> dict[tuple[str, ...], list[Row]]:
    """Group rows by method, cues and preset, in the order of their first appearance."""
    groups: dict[tuple[str, ...], list[Row]] = {}
    for row in rows:
        groups.setdefault(tuple(row[key] for key in TRIAL), []).append(row)
    return groups


def column(rows: Iterable[Row], name: str) -> NDArray[np.float64]:
    """Return a measure of the rows that did not fail."""
    return np.array([float(row[name]) for row in rows if not row["error"]], np.float64)


def summarise(rows: Iterable[Row]) -> list[TrialSummary]:
    """Summarise a run.

    Parameters
    ----------
    rows : iterable of dict
        Of ``frames.csv``.

    Returns
    -------
    list of TrialSummary
        Failed frames are counted and left out of the measures.
    """
    summaries = []
    for trial, group in by_trial(rows).items():
        good = [row for row in group if not row["error"]]
        measures = {name: Spread.of(column(good, name)) for name in SHOWN} if good else {}
        summaries.append(TrialSummary(trial, len(good), len(group) - len(good), measures))
    return summaries


def table(summaries: Sequence[TrialSummary]) -> str:
    """Write summaries as a Markdown table: mean, and for VoI the median and the spread too.

    Parameters
    ----------
    summaries : sequence of TrialSummary

    Returns
    -------
    str
    """
    heads = [
        "method",
        "cues",
        "preset",
        "frames",
        "failed",
        "VoI (bits)",
        "sd",
        "median",
        "quartiles",
        *list(SHOWN.values())[1:],
    ]
    lines = [_line(heads), _line(["---"] * 3 + ["--:"] * (len(heads) - 3))]
    for summary in summaries:
        cells = [*summary.trial, str(summary.frames), str(summary.failures)]
        lines.append(_line(cells + _numbers(summary.measures, len(heads) - len(cells))))
    return "\n".join(lines) + "\n"


def _numbers(measures: dict[str, Spread], width: int) -> list[str]:
    if not measures:
        return [""] * width
    voi = measures["voi_bits"]
    spread = [f"{v:.3f}" for v in (voi.mean, voi.deviation, voi.median)]
    digits = {"n_pred": 1, "seconds": 2}
    rest = [f"{measures[name].mean:.{digits.get(name, 3)}f}" for name in list(SHOWN)[1:]]
    return [*spread, f"{voi.low:.2f}-{voi.high:.2f}", *rest]


def _line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"
