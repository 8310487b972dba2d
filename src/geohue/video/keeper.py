"""The model that is in use, and the one that is being made in the background."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor

from geohue.compute.parallel import Workers
from geohue.scene import Scene
from geohue.settings import Preset
from geohue.video.change import Fit, why_anew
from geohue.video.model import CarriedModel, Pose

DELAY = 5
"""Frames after which a model that is made anew takes over."""

REST = 10
"""Fewest frames from one model's beginning to the next one's."""


class ModelKeeper:
    """Carries a model, and has it made anew where it no longer fits.

    Parameters
    ----------
    behind : ThreadPoolExecutor
        The thread in the background.
    seed : int
        The source of chance.
    delay : int
        Frames from the test that asks for a new model to its use.
    live : bool
        Whether it is used as soon as it is there instead, and never waited for.
    """

    def __init__(self, behind: ThreadPoolExecutor, seed: int, delay: int, live: bool) -> None:
        self._behind, self._seed, self._delay, self._live = behind, seed, delay, live
        self.model: CarriedModel | None = None
        self.models: list[tuple[int, str]] = []
        self._first: Fit | None = None
        self._coming: tuple[int, Future[CarriedModel]] | None = None

    def begin(
        self,
        frame: int,
        why: str,
        draft: Scene,
        pose: Pose | None,
        settings: Preset,
        team: Workers,
    ) -> CarriedModel:
        """Make a model on the spot and return it."""
        self._drop()
        self.model = CarriedModel.fit(draft, settings, pose, self._seed, team)
        self._first = None
        self.models.append((frame, why))
        return self.model

    def current(self, frame: int) -> CarriedModel:
        """Return the model for a frame: the one in use, or the new one if its time has come."""
        assert self.model is not None
        if self._coming is not None:
            begun, future = self._coming
            due = future.done() if self._live else frame >= begun + self._delay
            if due:
                self.model, self._first, self._coming = future.result(), None, None
        return self.model

    def watch(
        self, frame: int, fit: Fit, draft: Scene, pose: Pose | None, settings: Preset
    ) -> None:
        """Have a new model made if the one in use no longer fits (`why_anew`)."""
        if self._first is None:
            self._first = fit
        if self._coming is not None or frame - self.models[-1][0] < REST:
            return
        why = why_anew(self._first, fit)
        if why is None:
            return
        make = CarriedModel.fit
        self._coming = frame, self._behind.submit(make, draft, settings, pose, self._seed)
        self.models.append((frame, why))

    def _drop(self) -> None:
        if self._coming is not None:
            self._coming[1].cancel()
        self._coming = None


def chosen_cut(scene: Scene, settings: Preset, seed: int) -> tuple[Preset, float]:
    """Choose K and lambda on one frame, as the paper does, and settings that carry both.

    Returns
    -------
    settings : Preset
        One cut votes: that of lambda into K segments.
    weight : float
        Lambda.
    """
    from geohue.segmentation.driver import segment

    cues = "fusion" if scene.valid.any() else "color"
    found = segment(scene, preset=settings, cues=cues, seed=seed, fill=False)
    weight = found.weight if found.weight == found.weight else 1.0
    return settings.changed(panel=(weight,), counts=(max(found.k, 2),)), weight
