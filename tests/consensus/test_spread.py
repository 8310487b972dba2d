"""Labels of a draft carried over to the scene."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geohue import Scene
from geohue.compute.parallel import workers
from geohue.consensus import spread
from geohue.consensus.spread import _two_nearest
from geohue.prepared import prepare_scene
from geohue.settings import Preset
from twins import votes as twin

law = settings(deadline=None, max_examples=40)


@given(st.integers(0, 2**31), st.integers(7, 40))
@law
def test_equals_its_twin(seed: int, kept: int) -> None:
    rng = np.random.default_rng(seed)
    h, w = rng.integers(3, 20, 2)
    scene = Scene.from_rgbd(
        rng.integers(0, 255, (h, w, 3)).astype(np.uint8), rng.uniform(1, 2, (h, w))
    )
    prepared = prepare_scene(scene, Preset(draft_points=kept))
    draft = prepared.positions
    labels = rng.integers(0, 4, draft.shape).astype(np.int32)
    found = spread(labels, prepared)
    assert np.array_equal(found, twin.spread(labels, draft, prepared.features))
    assert np.array_equal(found.reshape(-1)[draft], labels)


def test_a_border_follows_the_colour_between_two_points_of_the_draft() -> None:
    rgb = np.zeros((9, 60, 3), np.uint8)
    rgb[:, 33:] = 200
    scene = Scene.from_rgbd(rgb, np.ones((9, 60)))
    prepared = prepare_scene(scene, Preset(draft_points=6))
    draft = prepared.positions
    labels = (rgb.reshape(-1, 3)[draft][..., 0] > 0).astype(np.int32)
    assert labels.min() < labels.max()
    assert np.array_equal(spread(labels, prepared), (rgb[..., 0] > 0) * 1)


def test_points_in_gaps_of_the_draft_take_the_nearest_label() -> None:
    depth = np.full((20, 20), np.nan)
    depth[::3, ::3] = 1
    depth[:6, :6] = 2
    scene = Scene.from_rgbd(np.zeros((20, 20, 3), np.uint8), depth)
    prepared = prepare_scene(scene, Preset(draft_points=40))
    draft = prepared.positions
    labels = np.where(scene.valid.reshape(-1)[draft], draft % 5, -1).astype(np.int32)
    found = spread(labels, prepared)
    assert np.array_equal(found >= 0, scene.valid)


def test_a_cloud_in_any_order_and_with_any_threads() -> None:
    rng = np.random.default_rng(5)
    points, colors = rng.normal(size=(900, 3)), rng.integers(0, 255, (900, 3)).astype(np.uint8)
    order = rng.permutation(900)
    results = []
    for places in (np.arange(900), order):
        scene = Scene.from_cloud(points[places], colors[places])
        prepared = prepare_scene(scene, Preset(draft_points=100))
        draft = prepared.positions
        labels = (scene.points[draft, 0] > 0).astype(np.int32)
        with workers(3) as team:
            results.append(spread(labels, replace(prepared, workers=team)))
        assert np.array_equal(results[-1], spread(labels, prepared))
        assert np.array_equal(results[-1][draft], labels)
    assert np.array_equal(results[0][order], results[1])


def test_a_draft_of_the_whole_cloud_is_put_in_order() -> None:
    rng = np.random.default_rng(5)
    scene = Scene.from_cloud(rng.normal(size=(50, 3)), rng.integers(0, 255, (50, 3), np.uint8))
    prepared = prepare_scene(scene, Preset(draft_points=50))
    draft = prepared.positions
    labels = np.arange(50, dtype=np.int32)
    found = spread(labels, prepared)
    assert np.array_equal(found[draft], labels)
    assert not np.array_equal(found, labels)


@pytest.mark.parametrize(
    ("n", "kept", "expected"),
    [
        (3, [1], [[0, 0]] * 3),
        (8, [1, 6], [[0, 1]] * 4 + [[1, 0]] * 4),
        (8, [0, 3, 6], [[0, 1], [0, 1], [1, 0], [1, 2], [1, 2], [2, 1], [2, 1], [2, 1]]),
    ],
)
def test_the_two_nearest_rows_by_hand(n: int, kept: list[int], expected: list[list[int]]) -> None:
    assert _two_nearest(n, np.array(kept)).tolist() == expected
