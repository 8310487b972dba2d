"""The arithmetic behind the studies in benchmarks/, on cases worked by hand."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from geohue.scene import Scene
from geohue.weight.quality import QualityMetric

if TYPE_CHECKING:
    from numpy.typing import NDArray


@pytest.fixture(autouse=True)
def _benchmarks_can_be_imported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2]))


@pytest.fixture
def stripes() -> tuple[Scene, NDArray[np.int32]]:
    """Three flat stripes: black at 1 m, grey at 2 m, white at 3 m."""
    part = np.repeat(np.arange(3), 4)[None].repeat(6, 0).astype(np.int32)
    rgb = np.repeat((part * 127)[..., None], 3, axis=2).astype(np.uint8)
    return Scene.from_rgbd(rgb, (part + 1.0).astype(np.float32)), part


def test_q_is_that_of_the_library(three_boxes: tuple[Scene, NDArray[np.int32]]) -> None:
    from benchmarks.criteria import Data, criteria

    scene, truth = three_boxes
    found = criteria(Data(scene), truth)
    assert found is not None
    for norm in ("sum", "euclidean"):
        expected = QualityMetric(scene, norm=norm)(truth)
        assert expected is not None
        assert found[f"Q pairs {norm}"] == pytest.approx(expected.total, abs=1e-6)
    assert criteria(Data(scene), np.zeros_like(truth)) is None


def test_adjacent_pairs_leave_out_the_far_one(stripes: tuple[Scene, NDArray[np.int32]]) -> None:
    from benchmarks.criteria import Data, criteria, parts_of

    scene, part = stripes
    data = Data(scene)
    found, parts = criteria(data, part), parts_of(data, part)
    assert found is not None
    assert parts is not None
    assert parts.borders.tolist() == [[0, 6, 0], [6, 0, 6], [0, 6, 0]]
    # Neighbours differ by 127/255 in three channels and by half of the depth; the ends by twice
    # that. Inside there is no deviation at all.
    step = (3 * 127 / 255 + 3 * 0.5) / 2
    assert found["Q adjacent sum"] == pytest.approx(step)
    assert found["Q border sum"] == pytest.approx(step)
    assert found["Q pairs sum"] == pytest.approx(step * 4 / 3)
    assert found["Q size sum"] == pytest.approx(step * 4 / 3)


def test_contrast_counts_steps_across_borders(stripes: tuple[Scene, NDArray[np.int32]]) -> None:
    from benchmarks.criteria import Data, parts_of

    scene, part = stripes
    parts = parts_of(Data(scene), part)
    assert parts is not None
    # All steps of the picture lie on the borders: 12 of the 6 x 11 + 5 x 12 pixel pairs.
    assert parts.contrast["lab"] == pytest.approx(126 / 12)
    shifted = parts_of(Data(scene), np.roll(part, 1, axis=1))
    assert shifted is not None
    assert shifted.contrast["lab"] < 1e-6


def test_rules_are_judged_by_hand() -> None:
    from benchmarks.lambda_study import GRID, fixed, judge
    from benchmarks.scores import Scores
    from benchmarks.sweep import KS, WEIGHTS

    def frame(best: int) -> Any:
        voi = np.full((2, len(WEIGHTS), len(KS)), 2.0)
        voi[:, 1 + best] = 1.0
        nothing = np.zeros(0)
        return Scores(voi, voi, voi.astype(int), nothing, nothing.astype(str), nothing, nothing)  # type: ignore[arg-type]

    at = GRID.index(1.0)
    result = judge([frame(at), frame(0)], fixed(1.0), 6)
    assert (result.voi, result.regret, result.best, result.near) == (1.5, 0.5, 0.5, 0.5)


def test_edge_error_is_the_shift_of_an_edge() -> None:
    from benchmarks.sensors import edge_error

    truth = np.repeat([0, 1], 20)[None].repeat(3, 0).astype(np.int32)
    exact = np.where(truth == 0, 1.0, 2.0)
    assert edge_error(exact, exact, truth) == (0.0, 0.0)
    assert edge_error(np.roll(exact, 4, axis=1)[:, 4:], exact[:, 4:], truth[:, 4:]) == (4.0, 0.0)
    gap = exact.copy()
    gap[:, 20:26] = np.nan  # the far side is hidden: the edge seems to lie in the middle
    assert edge_error(gap, exact, truth) == (3.0, 0.0)
    assert edge_error(np.full_like(exact, 1.0), exact, truth)[1] == 1.0
