"""The simulated sequence: its motion is exact, and its script is kept."""

from __future__ import annotations

import numpy as np
import pytest

from geohue import GeohueError, Intrinsics
from geohue.simulate.moving import ENTERING, HIDDEN, MOVING, moving_scene, moving_world
from geohue.simulate.world import render

CAMERA = Intrinsics(131.25, 131.25, 79.5, 59.5, 160, 120)


def test_one_thing_is_hidden_for_ten_frames_and_one_enters() -> None:
    small = Intrinsics(66.0, 66.0, 39.5, 29.5, 80, 60)
    seen = {}
    for frame in (*range(30, 50), 0, 89):
        labels = render(moving_world(frame)[0], small, samples=1).labels
        seen[frame] = set(np.unique(labels).tolist())
    views = [render(moving_world(i)[0], CAMERA, samples=1) for i in range(31, 47)]
    hidden = [not (view.labels == HIDDEN).any() for view in views]
    assert sum(hidden) == 10
    assert ENTERING not in seen[0]
    assert ENTERING in seen[49]
    assert all(MOVING in found for found in seen.values())
    assert HIDDEN in seen[0]
    assert HIDDEN in seen[89]


def test_the_motion_is_exact() -> None:
    one, other = moving_scene(2, CAMERA, start=60)
    assert one.places[MOVING, 0] < other.places[MOVING, 0]
    world = one.scene.points.astype(float) @ one.pose[:3, :3].T + one.pose[:3, 3]
    world += (other.places - one.places)[one.truth]
    there = (world - other.pose[:3, 3]) @ other.pose[:3, :3]
    u = np.rint(CAMERA.fx * there[..., 0] / there[..., 2] + CAMERA.cx).astype(int)
    v = np.rint(CAMERA.fy * there[..., 1] / there[..., 2] + CAMERA.cy).astype(int)
    inside = (u >= 0) & (v >= 0) & (u < 160) & (v < 120)
    same = other.truth[v[inside], u[inside]] == one.truth[inside]
    assert same.mean() > 0.985
    ball = inside & (one.truth == MOVING)
    assert other.scene.depth is not None
    away = np.abs(other.scene.depth[v[ball], u[ball]] - there[ball][:, 2])
    assert np.median(away) < 0.002


def test_cameras_and_sensors_that_cannot_be() -> None:
    with pytest.raises(GeohueError, match="sensor"):
        next(moving_scene(1, CAMERA, "radar"))
    with pytest.raises(GeohueError, match="size"):
        next(moving_scene(1, Intrinsics(1.0, 1.0, 0.0, 0.0)))
