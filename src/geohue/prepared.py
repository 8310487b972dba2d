"""What every stage works on, made once: a scene, its features, its draft and the settings."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from geohue.compute.parallel import Workers
from geohue.features import Features, Raw, extract_features
from geohue.scene import Scene
from geohue.settings import Preset


@dataclass(frozen=True, slots=True, eq=False)
class PreparedScene:
    """A scene that is ready to be split.

    Build one with `prepare_scene`, or with `of` for features that are there already.

    Attributes
    ----------
    scene : Scene
        The whole scene.
    raw : Raw
        What is derived from it.
    features : Features
        Its vectors (eq. 1-5, 19).
    positions : (h, w) or (m,) int64
        The draft: flat positions of the few points on which K and the weight are chosen
        (`Scene.thinning`).
    draft : Scene
        The scene at these positions.
    draft_features : Features
        Its vectors, normalised over the whole scene.
    settings : Preset
        The settings of every stage.
    workers : Workers
        Threads to use.
    seed : int
        The source of chance.
    """

    scene: Scene
    raw: Raw
    features: Features
    positions: NDArray[np.int64]
    draft: Scene
    draft_features: Features
    settings: Preset
    workers: Workers
    seed: int

    @classmethod
    def of(
        cls,
        raw: Raw,
        features: Features,
        settings: Preset,
        seed: int = 0,
        workers: Workers | None = None,
    ) -> PreparedScene:
        """Choose the draft of a scene whose features are there already.

        Parameters
        ----------
        raw : Raw
            The scene.
        features : Features
            Its features.
        settings : Preset
            The settings; `draft_points` counts here.
        seed : int
            The source of chance.
        workers : Workers, optional
            Threads to use; by default the calling one.

        Returns
        -------
        PreparedScene
        """
        scene = raw.scene
        positions = scene.thinning(settings.draft_points, np.random.default_rng(seed))
        return cls(
            scene,
            raw,
            features,
            positions,
            scene.take(positions),
            features.at(positions),
            settings,
            workers or Workers(None),
            seed,
        )

    def at(self, positions: NDArray[np.int64]) -> PreparedScene:
        """Return the same scene with another draft."""
        return replace(
            self,
            positions=positions,
            draft=self.scene.take(positions),
            draft_features=self.features.at(positions),
        )


def prepare_scene(
    scene: Scene,
    settings: Preset | None = None,
    cues: str = "fusion",
    seed: int = 0,
    workers: Workers | None = None,
) -> PreparedScene:
    """Sec. II: represent the points of a scene, and choose the few that stand for it.

    Parameters
    ----------
    scene : Scene
        The scene.
    settings : Preset, optional
        The settings; by default those of the paper.
    cues : str
        What to go by (`extract_features`).
    seed : int
        The source of chance.
    workers : Workers, optional
        Threads to use; by default the calling one.

    Returns
    -------
    PreparedScene

    Raises
    ------
    GeohueError
        For unknown cues, or if no point has them.

    Examples
    --------
    >>> scene = Scene.from_rgbd(np.zeros((40, 60, 3), np.uint8), np.ones((40, 60)))
    >>> prepared = prepare_scene(scene, Preset(draft_points=600))
    >>> prepared.draft.shape, len(prepared.draft_features)
    ((20, 30), 600)
    """
    raw = Raw(scene)
    features = extract_features(scene, cues, raw, workers)
    return PreparedScene.of(raw, features, settings or Preset(), seed, workers)
