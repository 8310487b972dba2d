"""The table of compared systems: what each can work on, and how to run it.

The modules of the systems are imported when one is run: the table costs nothing to look at.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from geohue.compute.parallel import Workers, workers
from geohue.features import CUES, Features
from geohue.plugins import Registry
from geohue.scene import Scene
from geohue.settings import PAPER_METHOD


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """What a system gets to work on; each takes what it is defined on.

    Attributes
    ----------
    scene : Scene
        The scene itself, for systems that go by the pixels.
    features : Features
        Its normalised vectors with the cues in use, for systems that go by p^f.
    weight : float
        The paper's lambda, 0 to infinity.
    k : int
        Number of segments, for systems that are told it.
    seed : int
        The source of chance.
    team : Workers
        Threads; no result depends on their number.
    """

    scene: Scene
    features: Features
    weight: float
    k: int
    seed: int
    team: Workers


@dataclass(frozen=True, slots=True)
class Baseline:
    """A compared system.

    Attributes
    ----------
    name : str
        As in ``method=``.
    cues : tuple of {"fusion", "color", "geometry"}
        What it is defined for.
    module : str or callable
        Where its ``run(job)`` is, which returns the labels; or that function itself.
    needs_grid : bool
        Whether it works on images only.
    uses_weight : bool
        Whether it goes by the vectors p^f with the weight lambda, which Q can then choose.
    uses_k : bool
        Whether the number of segments is given to it; the others find their own.
    prunes : bool
        Whether it has a rule of its own for small regions, which then stands in place of the
        refinement of Sec. III: that one would take away thin parts that it has found.
    """

    name: str
    cues: tuple[str, ...]
    module: str | Callable[[Job], Any]
    needs_grid: bool = False
    uses_weight: bool = False
    uses_k: bool = False
    prunes: bool = False

    def works_on(self, cues: str) -> bool:
        """Whether it is defined for these cues; one that goes by the vectors takes added ones."""
        return cues in self.cues or (self.uses_weight and cues not in CUES)

    def run(
        self,
        scene: Scene,
        features: Features,
        weight: float = 1.0,
        k: int = 2,
        seed: int = 0,
        team: Workers | None = None,
    ) -> NDArray[np.int32]:
        """Segment a scene.

        Parameters
        ----------
        scene : Scene
        features : Features
            Of that scene, with one of `cues` (`extract_features`).
        weight : float
            The paper's lambda; of no effect unless `uses_weight` and the cues are "fusion".
        k : int
            Number of segments; of no effect unless `uses_k`.
        seed : int
            The source of chance.
        team : Workers, optional
            Threads to work with; one a core if not given. The labels do not depend on it.

        Returns
        -------
        (H, W) or (N,) int32
            Labels from 0, in no particular order; -1 where there is none.
        """
        run = self.module if callable(self.module) else import_module(self.module).run
        if team is not None:
            return cast("NDArray[np.int32]", run(Job(scene, features, weight, k, seed, team)))
        with workers() as own:
            return cast("NDArray[np.int32]", run(Job(scene, features, weight, k, seed, own)))


_HOME = "geohue.baselines."

_OWN = {
    baseline.name: baseline
    for baseline in (
        Baseline("kmeans", CUES, _HOME + "kmeans", uses_weight=True, uses_k=True),
        Baseline("meanshift", CUES, _HOME + "meanshift", uses_weight=True),
        Baseline("felzenszwalb", CUES, _HOME + "felzenszwalb", uses_weight=True, prunes=True),
        Baseline("edison", ("color", "geometry"), _HOME + "edison", needs_grid=True, prunes=True),
        Baseline(
            "bleiweiss-werman",
            ("fusion",),
            _HOME + "bleiweiss_werman",
            needs_grid=True,
            prunes=True,
        ),
        Baseline(
            "calderero-marques",
            ("fusion",),
            _HOME + "calderero_marques",
            needs_grid=True,
            uses_k=True,
            prunes=True,
        ),
    )
}

BASELINES: Registry[Baseline] = Registry(
    "methods",
    _OWN,
    lambda value: isinstance(value, Baseline) and value.name != PAPER_METHOD,
    "a Baseline with a new name",
)
"""Every compared system by its name, those of plugins included."""


def register_method(baseline: Baseline) -> Baseline:
    """Let ``method=``, `geohue compare` and `geohue benchmark` take a method by its name.

    Parameters
    ----------
    baseline : Baseline
        Its name must be new.

    Returns
    -------
    Baseline
        The method itself.

    Raises
    ------
    GeohueError
        For a name that is taken.

    Examples
    --------
    >>> import numpy as np, geohue
    >>> def halves(job):
    ...     return np.arange(job.scene.size).reshape(job.scene.shape) * 2 // job.scene.size
    >>> method = register_method(Baseline("halves", CUES, halves))
    >>> scene = geohue.Scene.from_image(np.zeros((8, 4, 3), np.uint8))
    >>> geohue.segment(scene, cues="color", method="halves").labels[:, 0].tolist()
    [0, 0, 0, 0, 1, 1, 1, 1]
    >>> BASELINES.remove("halves")
    """
    BASELINES.add(baseline.name, baseline)
    return baseline
