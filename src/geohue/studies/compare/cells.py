"""The cells of a plate: which there are, and what became of each."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from geohue._version import __version__
from geohue.features import cue_columns
from geohue.segmentation.clusterers import known_methods
from geohue.segmentation.result import Segmentation
from geohue.settings import PRESETS
from geohue.studies.names import check_columns, check_names

Status = Literal["done", "undefined", "failed"]

SCORES = {"voi_bits": "VoI", "rand": "RI"}
"""What is shown of `geohue.measures.evaluate`, with its name in pictures and tables."""


def merging_presets() -> tuple[str, ...]:
    """Return the presets that merge regions: rows of a plate as the methods are.

    Examples
    --------
    >>> merging_presets()[:2]
    ('best', 'fast')
    """
    found = [name for name, preset in PRESETS.items() if preset.weight.rule == "merge"]
    return tuple(sorted(found, key=lambda name: (name not in PRESETS.own, name)))


def all_rows() -> tuple[str, ...]:
    """Return the rows of a plate, if none are named."""
    return ("best", *known_methods())


@dataclass(frozen=True, slots=True, order=True)
class Cell:
    """A method, or a preset that merges regions, on some cues."""

    method: str
    cues: str

    @property
    def name(self) -> str:
        """Short name, fit for a file."""
        return f"{self.method}-{self.cues}"

    @property
    def merges(self) -> bool:
        """Whether it is a preset that merges regions."""
        return self.method in merging_presets()


@dataclass(frozen=True, slots=True, eq=False)
class Result:
    """What became of a cell.

    Attributes
    ----------
    cell : Cell
    status : {"done", "undefined", "failed"}
        "undefined" where the method does not work on such cues or such a scene.
    reason : str
        Why there is no segmentation; empty if there is one.
    labels : int32, shape of the scene, or None
        0 (the largest segment) to k - 1; -1 where there is none.
    k : int or None
        Number of segments.
    seconds : float or None
        Of the processor, with one thread; libraries were loaded and compiled before.
    weight : float or None
        The paper's lambda: 0 for colour alone, infinity for geometry alone, NaN for a method that
        has none; None where regions were merged.
    quality : float or None
        Q of eq. 17.
    scores : dict of str to float
        Of `geohue.measures.evaluate`; empty without ground truth.
    warnings : tuple of str
        What the method says of the result, beside what is known of the scene.
    """

    cell: Cell
    status: Status
    reason: str = ""
    labels: NDArray[np.int32] | None = None
    k: int | None = None
    seconds: float | None = None
    weight: float | None = None
    quality: float | None = None
    scores: Mapping[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    @classmethod
    def of(
        cls,
        cell: Cell,
        seg: Segmentation,
        seconds: float,
        scores: Mapping[str, float],
        known: Sequence[str] = (),
    ) -> Result:
        """Return the result that a segmentation is; `known` warnings are left out."""
        return cls(
            cell,
            "done",
            "",
            seg.labels,
            seg.k,
            seconds,
            seg.weight if seg.levels is None else None,
            seg.quality,
            scores,
            tuple(text for text in seg.warnings if text not in known),
        )

    def row(self) -> dict[str, Any]:
        """Return a row of the table, ready for JSON (a weight not finite becomes None)."""
        finite = self.weight is not None and math.isfinite(self.weight)
        return {
            "method": self.cell.method,
            "cues": self.cell.cues,
            "status": self.status,
            "regions": self.k,
            "time_s": None if self.seconds is None else round(self.seconds, 3),
            "weight": self.weight if finite else None,
            "quality": self.quality,
            **{name: self.scores.get(name) for name in SCORES},
            "reason": self.reason,
            "warnings": list(self.warnings),
        }


@dataclass(frozen=True, slots=True, eq=False)
class Comparison:
    """All cells of a plate.

    Attributes
    ----------
    results : tuple of Result
        Row by row: the methods in turn, each with all cues.
    k : int
        Number of segments that the methods were told, where they take it.
    k_chosen : bool
        Whether the proposed method chose it.
    preset, seed
        As given.
    warnings : tuple of str
        Guesses and repairs of the scene.
    """

    results: tuple[Result, ...]
    k: int
    k_chosen: bool
    preset: str
    seed: int
    warnings: tuple[str, ...] = ()

    @property
    def methods(self) -> tuple[str, ...]:
        """The rows of the plate."""
        return tuple(dict.fromkeys(result.cell.method for result in self.results))

    @property
    def cues(self) -> tuple[str, ...]:
        """The columns of the plate."""
        return tuple(dict.fromkeys(result.cell.cues for result in self.results))

    @property
    def scored(self) -> bool:
        """Whether there was ground truth."""
        return any(result.scores for result in self.results)

    def at(self, method: str, cues: str) -> Result:
        """Return the result of one cell."""
        return next(r for r in self.results if (r.cell.method, r.cell.cues) == (method, cues))

    def summary(self) -> dict[str, Any]:
        """Return everything but the labels, ready for JSON."""
        return {
            "version": __version__,
            "k": self.k,
            "k_chosen": self.k_chosen,
            "preset": self.preset,
            "seed": self.seed,
            "cells": [result.row() for result in self.results],
            "warnings": list(self.warnings),
        }


def plan_cells(
    methods: Sequence[str] | None = None, cues: Sequence[str] | None = None
) -> list[Cell]:
    """Combine methods and cues, in the order given, each once; all (`all_rows`) if not given.

    Raises
    ------
    GeohueError
        For an unknown name, or none.
    """
    methods = all_rows() if methods is None else methods
    cues = cue_columns() if cues is None else cues
    check_names("methods", methods, (*merging_presets(), *known_methods()))
    check_columns(cues)
    columns = list(dict.fromkeys(cues))
    return [Cell(method, cue) for method in dict.fromkeys(methods) for cue in columns]
