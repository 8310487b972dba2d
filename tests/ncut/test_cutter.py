from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from geohue import Scene
from geohue.ncut.cutter import Cutter
from geohue.prepared import prepare_scene
from geohue.settings import PRESETS

PAPER = PRESETS["paper"]
FEW = replace(PAPER, cut=replace(PAPER.cut, landmarks=12, k_max=5))


def cloud(rare: int, common: int = 990) -> Scene:
    """A grey ball, and a smaller red one apart from it."""
    rng = np.random.default_rng(7)
    red = np.arange(rare + common) < rare
    points = rng.normal(0, 0.02, (len(red), 3)) + np.where(red[:, None], [3.0, 0, 2], [0.0, 0, 2])
    colors = np.where(red[:, None], [200, 30, 30], 90) + rng.integers(0, 6, points.shape)
    return Scene.from_cloud(points, colors.astype(np.uint8))


@pytest.mark.parametrize("seed", range(4))
def test_an_object_that_the_landmarks_miss_is_counted(seed: int) -> None:
    cutter = Cutter(prepare_scene(cloud(rare=10), FEW, seed=seed), 2)
    assert cutter.choose_k(1.0) == 2


def test_draft_cuts_end_where_the_points_span_no_more() -> None:
    cutter = Cutter(prepare_scene(cloud(rare=300), FEW), 7)
    assert [len(np.unique(cut)) for cut in cutter.draft_cuts(1.0, (1, 2, 3))] == [1, 2, 3]
    two = Scene.from_cloud(
        np.repeat([[0.0, 0, 1], [1, 0, 1]], 50, axis=0),
        np.repeat([[9, 9, 9], [200, 0, 0]], 50, axis=0).astype(np.uint8),
    )
    (cut,) = Cutter(prepare_scene(two, FEW), 7).draft_cuts(1.0, (2, 3, 7))
    assert (cut == np.repeat(cut[[0, -1]], 50)).all()
    assert cut[0] != cut[-1]
