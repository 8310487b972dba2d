"""Felzenszwalb and Huttenlocher: by hand, against a slow twin, against scikit-image."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter
from skimage.segmentation import felzenszwalb

from geohue import Scene
from geohue.baselines.felzenszwalb import segment_grid, smoothed
from geohue.baselines.graph import cloud_edges, edge_lengths, grid_edges, merge_graph
from geohue.features import Block, Features, extract_features


def same_partition(one: NDArray[np.int32], other: NDArray[np.int32]) -> bool:
    pairs = {(int(a), int(b)) for a, b in zip(one.flat, other.flat, strict=True)}
    return len(pairs) == len({a for a, _ in pairs}) == len({b for _, b in pairs})


def whole_grid(shape: tuple[int, int]) -> Features:
    size = shape[0] * shape[1]
    zeros = np.zeros((size, 3), np.float32)
    blocks = Block("color", "color", zeros), Block("geometry", "geometry", zeros, used=False)
    return Features(blocks, np.arange(size), shape, "color")


def slow_merge(
    n: int, edges: NDArray[np.int32], lengths: NDArray[np.floating], k: float, min_size: int
) -> NDArray[np.int32]:
    """The definition: components as sets, Int(C) as the longest edge within."""
    component = [{i} for i in range(n)]
    internal = [0.0] * n
    lengths = lengths.astype(np.float64)
    order = sorted(range(len(edges)), key=lambda e: (lengths[e], e))
    for small_ones in (False, True):
        for e in order:
            a, b = (int(v) for v in edges[e])
            one, other = component[a], component[b]
            if one is other:
                continue
            bound = min(internal[a] + k / len(one), internal[b] + k / len(other))
            if min(len(one), len(other)) < min_size if small_ones else lengths[e] <= bound:
                union = one | other
                for v in union:
                    component[v] = union
                    internal[v] = float(lengths[e])
    first = [min(c) for c in component]
    return np.unique(first, return_inverse=True)[1].astype(np.int32)


def test_a_chain_by_hand() -> None:
    # 0-1 (1) and 3-4 (1) merge: 1 <= 0 + 4/1. Then Int = 1, |C| = 2: both bounds are 1 + 4/2 = 3.
    # 1-2 (3) merges {0, 1} with {2}: 3 <= min(3, 4). Its bound is now 3 + 4/3 = 4.33.
    # 2-3 (4) does not: {3, 4} allows 3 only.
    edges = np.array([[0, 1], [1, 2], [2, 3], [3, 4]], np.int32)
    lengths = np.array([1, 3, 4, 1], np.float32)
    assert merge_graph(5, edges, lengths, 4.0, 1).tolist() == [0, 0, 0, 1, 1]
    assert merge_graph(5, edges, lengths, 4.0, 3).tolist() == [0, 0, 0, 0, 0]


@pytest.mark.parametrize("min_size", [1, 7])
@pytest.mark.parametrize("k", [0.1, 1.0, 6.0])
def test_equals_the_slow_twin(k: float, min_size: int) -> None:
    rng = np.random.default_rng(3)
    edges = grid_edges(np.arange(120, dtype=np.int32).reshape(10, 12))
    lengths = (rng.integers(0, 12, len(edges)) / 10).astype(np.float32)  # with ties
    fast = merge_graph(120, edges, lengths, k, min_size)
    np.testing.assert_array_equal(fast, slow_merge(120, edges, lengths, k, min_size))


@pytest.mark.parametrize(
    ("sigma", "scale", "min_size"), [(0.0, 40, 1), (0.8, 100, 1), (0.8, 60, 9)]
)
def test_equals_scikit_image_on_colour(sigma: float, scale: float, min_size: int) -> None:
    rng = np.random.default_rng(4)
    image = rng.random((30, 40, 3))
    image[:, 20:] += 1.5
    ours = segment_grid(
        whole_grid((30, 40)),
        image.reshape(-1, 3).astype(np.float32),
        scale / 255,  # as scikit-image scales it, for colours in 0..1
        sigma,
        min_size,
    )
    theirs = felzenszwalb(image, scale=scale, sigma=sigma, min_size=min_size)
    assert 2 <= ours.max() < 1199
    assert same_partition(ours, theirs.astype(np.int32))


def test_smoothing_is_the_gaussian_where_all_take_part_and_spreads_no_gap() -> None:
    values = np.random.default_rng(5).random((9, 8)).astype(np.float32)
    full = smoothed(whole_grid((9, 8)), values.reshape(-1, 1), 0.8)
    np.testing.assert_allclose(full.reshape(9, 8), gaussian_filter(values, 0.8), rtol=1e-5)
    depth = np.ones((9, 8))
    depth[3:5, 2:6] = np.nan
    scene = Scene.from_rgbd(np.zeros((9, 8, 3), np.uint8), depth)
    features = extract_features(scene, "geometry")
    constant = smoothed(features, np.full((len(features), 1), 3, np.float32), 0.8)
    np.testing.assert_allclose(constant, 3, rtol=1e-6)


def test_a_gap_parts_and_no_edge_crosses_it() -> None:
    rows = np.array([[0, -1, 1], [2, -1, 3]], np.int32)
    assert sorted(map(tuple, grid_edges(rows).tolist())) == [(0, 2), (1, 3)]


def test_neighbours_of_a_cloud() -> None:
    assert cloud_edges(np.zeros((1, 3), np.float32)).shape == (0, 2)
    points = np.array([[0, 0, 0], [0, 0, 0], [5, 0, 0]], np.float32)  # two in one place
    assert cloud_edges(points, 8).tolist() == [[0, 1], [0, 2], [1, 2]]
    lengths = edge_lengths(points, cloud_edges(points, 8))
    assert lengths.tolist() == [0, 5, 5]
