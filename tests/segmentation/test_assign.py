"""A label for every point: laws, and a slow twin."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue import GeohueError, Scene, segment
from geohue.segmentation.assign import assign_labels

Labels = NDArray[np.int32]


def some(seed: int, n: int = 60) -> tuple[Scene, Labels]:
    rng = np.random.default_rng(seed)
    points, colors = rng.normal(size=(n, 3)), rng.integers(0, 256, (n, 3), np.uint8)
    labels = rng.integers(-1, 4, n).astype(np.int32)
    labels[0] = 0
    return Scene.from_cloud(points, colors), labels


@given(seed=st.integers(0, 99))
@settings(max_examples=20, deadline=None)
def test_labels_are_those_of_a_slow_search(seed: int) -> None:
    scene, labels = some(seed)
    rng = np.random.default_rng(seed + 1)
    points, colors = rng.normal(size=(30, 3)), rng.integers(0, 256, (30, 3), np.uint8)
    known = np.flatnonzero(labels >= 0)
    own = scene.points[known].astype(float)
    between = np.linalg.norm(own[:, None] - own, axis=2)
    np.fill_diagonal(between, np.inf)
    spacing = np.median(between.min(axis=1))
    slow = []
    for point, color in zip(points, colors.astype(float), strict=True):
        away = np.linalg.norm(own - point, axis=1)
        near = np.argsort(away)[:4]
        step = ((scene.colors[known[near]] - color) ** 2).sum(axis=1)
        slow.append(labels[known[near[np.argmin((away[near] / spacing) ** 2 + step / 900)]]])
    assert assign_labels(scene, labels, points, colors).tolist() == slow


@given(seed=st.integers(0, 99))
@settings(max_examples=20, deadline=None)
def test_every_point_gets_a_label_of_the_scene(seed: int) -> None:
    scene, labels = some(seed)
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(5, 8, 3)) * 100
    points[rng.random((5, 8)) < 0.3] = np.nan
    colors = rng.random((5, 8, 3))
    colors[rng.random((5, 8)) < 0.3] = np.nan
    found = assign_labels(scene, labels, points, colors)
    assert found.shape == (5, 8)
    assert np.isin(found, labels[labels >= 0]).all()


def test_labelled_points_keep_their_labels() -> None:
    scene, labels = some(5)
    there = labels >= 0
    assert (assign_labels(scene, labels, scene.points[there]) == labels[there]).all()
    with_colors = assign_labels(scene, labels, scene.points[there], scene.colors[there])
    assert (with_colors == labels[there]).all()


def test_without_a_position_the_colour_counts_and_without_both_the_size() -> None:
    colors = np.array([[250, 0, 0], [0, 0, 250], [0, 0, 250]], np.uint8)
    scene = Scene.from_cloud(np.eye(3), colors)
    labels = np.array([0, 1, 1], np.int32)
    nowhere = np.full((2, 3), np.nan)
    assert assign_labels(scene, labels, nowhere, [[0.9, 0.1, 0], [np.nan] * 3]).tolist() == [0, 1]


def test_colour_decides_between_near_points() -> None:
    scene = Scene.from_cloud(
        np.array([[0, 0, 0], [1.0, 0, 0]]), np.array([[0, 0, 0], [200, 200, 200]], np.uint8)
    )
    labels = np.array([0, 1], np.int32)
    here = [[0.4, 0, 0]]
    assert assign_labels(scene, labels, here).tolist() == [0]
    assert assign_labels(scene, labels, here, np.full((1, 3), 200, np.uint8)).tolist() == [1]


def test_map_coordinates() -> None:
    points = np.array([[5e5, 5e6, 10], [5e5 + 1, 5e6, 10]])
    scene = Scene.from_cloud(points, np.zeros((2, 3), np.uint8))
    assert assign_labels(scene, np.array([0, 1], np.int32), points[::-1]).tolist() == [1, 0]


def test_mistakes_are_named() -> None:
    scene, labels = some(1)
    for points, colors, message in (
        ([1, 2], None, r"shape \(2,\)"),
        (np.zeros((2, 3)), np.zeros((1, 3), np.uint8), r"colors have shape \(1, 3\)"),
        (np.zeros((1, 3)), [[2.0, 0, 0]], "from 0 to 1"),
    ):
        with pytest.raises(GeohueError, match=message):
            assign_labels(scene, labels, points, colors)
    with pytest.raises(GeohueError, match="no point of the scene"):
        assign_labels(scene, np.full(60, -1, np.int32), np.zeros((1, 3)))


def test_thinned_points_get_the_labels_of_the_rest(
    three_boxes: tuple[Scene, NDArray[np.int32]],
) -> None:
    scene, _ = three_boxes
    whole = segment(scene)
    points, colors = scene.points.reshape(-1, 3), scene.colors.reshape(-1, 3)
    found = whole.assign(points, colors).reshape(scene.shape)
    assert (found == whole.labels).mean() > 0.999
    thin = segment(Scene.from_cloud(points[::3], colors[::3]))
    assert len(thin.assign(points)) == len(points)
