"""One way to segment a frame, and its scores: a cell of the benchmark."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from time import process_time
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from geohue.baselines import BASELINES
from geohue.errors import GeohueError
from geohue.features import CUES
from geohue.measures import evaluate
from geohue.scene import Scene
from geohue.segmentation.driver import segment
from geohue.settings import PAPER_METHOD, preset_named
from geohue.studies.names import check_columns, check_names

OWN = PAPER_METHOD
"""The method that the presets belong to."""

NO_PRESET = "-"
"""In place of a preset for the compared systems, which have none; what they share with the
paper's method (the draft, small regions) is that of the preset "paper"."""


@dataclass(frozen=True, slots=True, order=True)
class Trial:
    """A method with its cues and its preset."""

    method: str
    cues: str
    preset: str

    @property
    def name(self) -> str:
        """Short name, fit for a folder."""
        parts = (self.method, self.cues, self.preset)
        return "-".join(part for part in parts if part != NO_PRESET)


@dataclass(frozen=True, slots=True)
class Conditions:
    """What is the same for all trials of a run.

    Attributes
    ----------
    k : int or "auto"
        Number of segments for the methods that are told it.
    components : bool
        Whether each connected piece counts as a region of its own.
    seed : int
        The source of chance.
    """

    k: int | Literal["auto"] = "auto"
    components: bool = False
    seed: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """Labels, the processor's seconds for them, and what else a method says."""

    labels: NDArray[np.int32]
    seconds: float
    weight: float | None = None
    quality: float | None = None


def plan(
    methods: Sequence[str] = (OWN,),
    cues: Sequence[str] = ("fusion",),
    presets: Sequence[str] = ("best",),
) -> list[Trial]:
    """Combine methods, cues and presets, each method with the cues that it is defined for.

    Raises
    ------
    GeohueError
        For an unknown name, or if nothing is left.

    Examples
    --------
    >>> [trial.name for trial in plan(["nncsc", "edison"], ["fusion", "color"], ["fast"])]
    ['nncsc-fusion-fast', 'nncsc-color-fast', 'edison-color']
    """
    check_columns(cues)
    check_names("methods", methods, (OWN, *BASELINES))
    for preset in presets:
        preset_named(preset)
    trials: list[Trial] = []
    for method in dict.fromkeys(methods):
        own = method == OWN
        order = [*CUES, *(cue for cue in dict.fromkeys(cues) if cue not in CUES)]
        chosen = [c for c in order if c in cues and (own or BASELINES[method].works_on(c))]
        names = tuple(dict.fromkeys(presets)) if own else (NO_PRESET,)
        trials += [Trial(method, cue, preset) for cue in chosen for preset in names]
    if not trials:
        raise GeohueError("no method works on these cues: see the table in docs/evaluation.md")
    return trials


def answer(trial: Trial, scene: Scene, conditions: Conditions) -> Answer:
    """Segment a scene with one thread.

    Parameters
    ----------
    trial : Trial
    scene : Scene
    conditions : Conditions

    Returns
    -------
    Answer
        Labels from 0, the largest segment first; -1 for none.
    """
    start = process_time()
    seg = segment(
        scene,
        conditions.k,
        "auto",
        "paper" if trial.preset == NO_PRESET else trial.preset,
        trial.cues,
        trial.method,
        conditions.seed,
        components=conditions.components,
        threads=1,
    )
    weight = None if math.isnan(seg.weight) else seg.weight
    return Answer(seg.labels, process_time() - start, weight, seg.quality)


def scores(given: Answer, truth: NDArray[np.int32]) -> dict[str, Any]:
    """Measure an answer: all of `geohue.measures.evaluate`, and what the method says of it."""
    return {
        "k": int(given.labels.max(initial=-1)) + 1,
        "weight": given.weight,
        "quality": given.quality,
        "labelled": float((given.labels >= 0).mean()),
        **evaluate(given.labels, truth),
        "seconds": round(given.seconds, 4),
    }
