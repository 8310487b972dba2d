"""Which points lie side by side, on grids and in clouds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from geohue import Scene
from geohue.regions.adjacency import adjacent_points, link_pieces, nearest_known


def cloud(points: np.ndarray[tuple[int, ...], np.dtype[np.floating]]) -> Scene:
    return Scene.from_cloud(points, np.zeros((len(points), 3), np.uint8))


def all_pairs(scene: Scene) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    one, other = adjacent_points(scene)
    more = link_pieces(scene, one, other)
    return np.concatenate([one, more[0]]), np.concatenate([other, more[1]])


def pieces(scene: Scene) -> int:
    one, other = all_pairs(scene)
    valid = np.flatnonzero(scene.valid.reshape(-1))
    assert np.isin(one, valid).all()
    assert np.isin(other, valid).all()
    assert (one != other).all()
    n = scene.size
    found, piece = connected_components(coo_array((np.ones(len(one)), (one, other)), shape=(n, n)))
    return len(np.unique(piece[valid]))


@given(st.integers(0, 2**31), st.integers(1, 300))
@settings(deadline=None, max_examples=60)
def test_a_cloud_is_connected_and_no_point_is_beside_itself(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(n, 3)) + 50 * rng.integers(0, 4, (n, 1))
    points = points[rng.integers(0, n, n)]  # some twice, some not at all
    points[rng.random(n) < 0.1] = np.nan
    if np.isfinite(points).any():
        assert pieces(cloud(points)) == 1


def test_scan_lines_are_linked() -> None:
    along = np.linspace(0, 10, 2000)
    lines = [np.c_[along, np.full(2000, y), np.zeros(2000)] for y in (0.0, 1.0, 2.0)]
    one, other = all_pairs(cloud(np.concatenate(lines)))
    across = np.abs(one // 2000 - other // 2000)
    assert pieces(cloud(np.concatenate(lines))) == 1
    assert np.count_nonzero(across) < 20  # a few links, not a new neighbourhood


def test_the_nearest_come_in_pairs() -> None:
    points = np.random.default_rng(0).normal(size=(80, 3))
    one, other = adjacent_points(cloud(points))
    for i in range(80):
        away = np.linalg.norm(points - points[i], axis=1)
        assert set(np.argsort(away)[1:6].tolist()) <= set(other[one == i].tolist())


@pytest.mark.parametrize("copies", [2, 50])
def test_points_in_one_place(copies: int) -> None:
    points = np.repeat(np.random.default_rng(0).normal(size=(30, 3)), copies, axis=0)
    assert pieces(cloud(points)) == 1
    assert pieces(cloud(np.ones((copies, 3)))) == 1


def test_gaps_of_a_grid_have_no_neighbours() -> None:
    depth = np.ones((3, 3))
    depth[1, 1] = np.nan
    one, other = adjacent_points(Scene.from_rgbd(np.zeros((3, 3, 3), np.uint8), depth))
    assert len(one) == 8
    assert 4 not in np.concatenate([one, other])


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1))
def test_the_nearest_known_pixel_is_that_of_scipy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    known = rng.random(rng.integers(1, 16, 2)) < rng.choice([0.05, 0.2, 0.6])
    known.flat[rng.integers(known.size)] = True
    y, x = distance_transform_edt(~known, return_distances=False, return_indices=True)
    assert nearest_known(known).tolist() == (y * known.shape[1] + x).tolist()
