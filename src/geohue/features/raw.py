"""The values of a scene from which cues are made, each derived once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.features.color import lab_of
from geohue.scene import Scene


class Raw:
    """A scene and what several stages derive from it.

    Attributes
    ----------
    scene : Scene
        The scene.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self._lab: NDArray[np.float32] | None = None
        # The Appendix goes by the same colours, where a grid has gaps; else they are let go.
        self._kept = scene.is_grid and not bool(scene.valid.all())

    @property
    def lab(self) -> NDArray[np.float32]:
        """CIELab of the colours (eq. 1), (H, W, 3) or (N, 3) float32."""
        if self._lab is not None:
            return self._lab
        lab = lab_of(self.scene.colors)
        if self._kept:
            self._lab = lab
        return lab
