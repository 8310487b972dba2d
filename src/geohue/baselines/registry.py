"""The table of compared systems: what each can work on, and how to run it.

The modules of the systems are imported when one is run: the table costs nothing to look at.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import cast

import numpy as np
from numpy.typing import NDArray

from geohue.compute.parallel import Workers, workers
from geohue.features import CUES, Features
from geohue.scene import Scene


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
    module : str
        Where its ``run(job)`` is.
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
    module: str
    needs_grid: bool = False
    uses_weight: bool = False
    uses_k: bool = False
    prunes: bool = False

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
        run = import_module(self.module).run
        if team is not None:
            return cast("NDArray[np.int32]", run(Job(scene, features, weight, k, seed, team)))
        with workers() as own:
            return cast("NDArray[np.int32]", run(Job(scene, features, weight, k, seed, own)))


_HOME = "geohue.baselines."

BASELINES: dict[str, Baseline] = {
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
"""Every compared system by its name."""
