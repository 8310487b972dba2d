"""The Appendix on a prepared scene, by the rule of its settings."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.fill import fill_labels
from geohue.fill.flood import flood_labels
from geohue.prepared import PreparedScene


def fill_gaps(labels: NDArray[np.int32], prepared: PreparedScene) -> NDArray[np.int32]:
    """Give the pixels of a grid that have no label one.

    Parameters
    ----------
    labels : (H, W) int32
        Labels, -1 = none.
    prepared : PreparedScene
        The scene; its settings `fill` count.

    Returns
    -------
    (H, W) int32
        The labels themselves for a cloud, or where nothing is missing.

    Examples
    --------
    >>> from geohue import Preset, Scene
    >>> from geohue.prepared import prepare_scene
    >>> scene = Scene.from_rgbd(np.zeros((2, 3, 3), np.uint8), np.ones((2, 3)))
    >>> labels = np.int32([[0, -1, -1], [0, 0, -1]])
    >>> fill_gaps(labels, prepare_scene(scene, Preset().changed(fill_rule="watershed"))).tolist()
    [[0, 0, 0], [0, 0, 0]]
    """
    if not prepared.scene.is_grid or (labels >= 0).all():
        return labels
    if prepared.settings.fill.rule == "watershed":
        return flood_labels(labels, prepared.scene.colors)
    return fill_labels(labels, prepared.raw.lab)
