"""Clouds of simulated things: where their points lie, and their parts."""

from __future__ import annotations

import numpy as np
import pytest

from geohue import GeohueError
from geohue.simulate import patches
from geohue.simulate.branching import BRANCHING, COMPACT, branching_cloud
from geohue.simulate.patches import Patch, box, ellipsoid, ribbon, sample, sheet, tube


@pytest.fixture
def exact(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(patches, "NOISE", 0.0)


@pytest.mark.parametrize("name", sorted(BRANCHING | COMPACT))
def test_a_seed_gives_a_cloud_with_all_its_parts(name: str) -> None:
    points, truth = branching_cloud(name, 6000, 4)
    again, same = branching_cloud(name, 6000, 4)
    np.testing.assert_array_equal(points, again)
    np.testing.assert_array_equal(truth, same)
    assert not np.array_equal(points, branching_cloud(name, 6000, 5)[0])
    assert points.dtype == np.float32
    assert np.isfinite(points).all()
    assert truth.min() == 0
    parts = np.bincount(truth)
    assert name == "room" or (parts > 0).all()  # a room has its cupboard as part 10


@pytest.mark.usefixtures("exact")
def test_points_lie_evenly_on_patches() -> None:
    one = sheet((0, 0, 0), (1, 0, 0), (0, 1, 0), 0)
    three = sheet((5, 0, 0), (3, 0, 0), (0, 1, 0), 1)
    points, part = sample([one, three], 8000, np.random.default_rng(0))
    assert part.mean() == pytest.approx(0.75, abs=0.02)
    assert (points[:, 2] == 0).all()
    inside = points[part == 1]
    assert inside[:, 0].min() >= 5
    assert inside[:, 0].max() <= 8
    assert np.histogram(inside[:, 0], 3)[0].std() < 100


@pytest.mark.usefixtures("exact")
def test_tubes_balls_boxes_and_leaves_have_their_sizes() -> None:
    rng = np.random.default_rng(0)
    path = np.linspace([0, 0, 0], [0, 0, 2], 9)
    points, _ = sample([tube(path, 0.5, 0)], 500, rng)
    away = np.linalg.norm(points[:, :2], axis=1)
    assert 0.48 < away.min() <= away.max() < 0.5001
    points, _ = sample([ellipsoid((1, 2, 3), (1, 2, 3), 0)], 500, rng)
    assert np.linalg.norm((points - [1, 2, 3]) / [1, 2, 3], axis=1) == pytest.approx(1, abs=0.03)
    points, part = sample(box((1, 0, 0), (2, 4, 6), 3), 600, rng)
    away = np.abs((points - np.array([1, 0, 0])) / np.array([1, 2, 3])).max(axis=1)
    assert away == pytest.approx(1, abs=1e-6)
    assert set(part.tolist()) == {3}
    flat = ribbon(path, np.full(9, 0.4), 0, fold=0.0)
    assert np.linalg.norm(flat.corners[0] - flat.corners[-1], axis=1) == pytest.approx(0.4)


def test_noise_grows_with_the_distance_of_points() -> None:
    square = Patch(sheet((0, 0, 0), (10, 0, 0), (0, 10, 0), 0).corners, 0)
    few = sample([square], 100, np.random.default_rng(0))[0][:, 2].std()
    many = sample([square], 10_000, np.random.default_rng(0))[0][:, 2].std()
    assert few / many == pytest.approx(10, rel=0.3)
    assert many == pytest.approx(0.15 * 0.1, rel=0.1)


def test_unknown_names_and_negative_numbers_are_refused() -> None:
    with pytest.raises(GeohueError, match="choose one of maize"):
        branching_cloud("octopus")
    with pytest.raises(GeohueError, match="0 or more"):
        branching_cloud("maize", -1)
    assert branching_cloud("maize", 0)[0].shape == (0, 3)
