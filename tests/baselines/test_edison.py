"""EDISON's edges and regions, and the systems built on them."""

from __future__ import annotations

import numpy as np
import pytest

from geohue.baselines.bleiweiss_werman import segment_image
from geohue.baselines.edges import edge_strength, gradient, gradient_rank
from geohue.baselines.edison import segment_planes
from geohue.baselines.planes import filled
from geohue.baselines.regions import (
    borders,
    connect,
    grow_regions,
    join,
    measure,
    mode_distance,
    prune,
)
from geohue.compute.parallel import workers


def modes_of(rows: list[list[float]]) -> np.ndarray:
    modes = np.zeros((len(rows), len(rows[0]), 5), np.float32)
    modes[..., 0] = rows
    return modes


def test_gradient_sequences() -> None:
    ramp = np.tile(np.arange(9, dtype=np.float32), (9, 1))
    across, down = gradient(ramp, 2)
    assert across[4, 4] == pytest.approx(1.0)
    assert down[4, 4] == 0
    spike = np.zeros((5, 5), np.float32)
    spike[2, 3] = 16 * 8  # smooth 1 4 6 4 1 down, differ -1 -2 0 2 1 across
    assert gradient(spike, 2)[0][2].tolist() == [0, 6, 12, 0, -12]


def test_ranks_by_hand() -> None:
    magnitude = np.array([[0.0, 2.0], [1.0, 2.0]])
    mask = np.ones((2, 2), bool)
    assert gradient_rank(magnitude, mask, 1.0).tolist() == [[0, 0.5], [0.25, 0.5]]
    mask[0, 0] = False
    assert gradient_rank(magnitude, mask, 1.0)[0, 0] == 0


def test_a_weak_step_is_a_sure_edge_and_texture_is_not() -> None:
    step = np.zeros((20, 20), np.float32)
    step[:, 10:] = 0.01
    strength = edge_strength(step, np.ones((20, 20), bool), mixture=0.0)  # the confidence alone
    # Window columns 0 0 0 1 1 (or 0 0 1 1 1) against -0.5 -0.5 0 0.5 0.5:
    # 5 * (2 * 0.5) / sqrt(25 * 6/25 * 5) = 5 / sqrt(30).
    assert strength[10, 9] == pytest.approx(5 / np.sqrt(30), abs=1e-5)
    assert strength[10, 5] == 0
    noise = np.random.default_rng(0).random((20, 20)).astype(np.float32)
    assert edge_strength(noise, np.ones((20, 20), bool), mixture=0.0).mean() < 0.6


def test_a_constant_image_has_no_edges() -> None:
    flat = np.full((8, 9), 0.3, np.float32)
    assert edge_strength(flat, np.ones((8, 9), bool)).max() == 0


def test_connects_from_each_to_the_next() -> None:
    modes = modes_of([[0, 0.1, 0.2, 0.5], [2, 2, 0.3, 0.5]])
    mask = np.ones((2, 4), bool)
    assert connect(modes, mask, 0.15).tolist() == [[0, 0, 0, 1], [2, 2, 0, 1]]
    mask[0, 1] = False
    assert connect(modes, mask, 0.15).tolist() == [[0, -1, 1, 2], [3, 3, 1, 2]]


def test_regions_are_measured_with_depth_by_its_confidence() -> None:
    modes = modes_of([[1, 3, 5]])
    modes[0, :, 3], modes[0, :, 4] = [10, 20, 99], [1, 0.5, 0]
    regions = measure(np.array([[0, 0, 1]], np.int32), modes)
    assert regions.size.tolist() == [2, 1]
    np.testing.assert_allclose(regions.modes[0], [2, 0, 0, 20 / 1.5, 0.75])
    np.testing.assert_allclose(regions.modes[1], [5, 0, 0, 0, 0])
    assert mode_distance(regions, np.array([[0, 1]], np.int32))[0] == pytest.approx(9.0)


def test_borders_and_their_mean_strength() -> None:
    labels = np.array([[0, 1], [0, 2]], np.int32)
    strength = np.array([[0.2, 0.4], [0.6, 1.0]], np.float32)
    pairs, edge = borders(labels, strength)
    assert pairs.tolist() == [[0, 1], [0, 2], [1, 2]]
    np.testing.assert_allclose(edge, [0.3, 0.8, 0.7], atol=1e-6)


def test_an_edge_keeps_close_modes_apart() -> None:
    modes = modes_of([[0, 0, 0.4, 0.4]] * 4)
    mask = np.ones((4, 4), bool)
    none = np.zeros((4, 4), np.float32)
    assert grow_regions(modes, mask, none, 0.3, 1).max() == 0
    assert grow_regions(modes, mask, none + np.float32(0.4), 0.3, 1).max() == 1


def test_joining_goes_on_with_new_modes_until_nothing_changes() -> None:
    # 0 and 0.4 join (0.2, in 2 pixels); 0.2 and 0.65 are then close too; 1.3 is not.
    modes = modes_of([[0, 0.4, 1.3]])
    mask, none = np.ones((1, 3), bool), np.zeros((1, 3), np.float32)
    assert grow_regions(modes, mask, none, 1.0, 1).tolist() == [[0, 0, 1]]


def test_small_regions_join_the_closest_mode() -> None:
    modes = modes_of([[0, 0, 0, 1, 3, 3, 3]])
    labels = np.array([[0, 0, 0, 1, 2, 2, 2]], np.int32)
    none = np.zeros((1, 7), np.float32)
    pruned = prune(measure(labels, modes), none, modes, 2)
    assert pruned.labels.tolist() == [[0, 0, 0, 0, 1, 1, 1]]
    alone = prune(measure(np.array([[0, -1, -1, -1, 1, 1, 1]], np.int32), modes), none, modes, 2)
    assert alone.labels.tolist() == [[0, -1, -1, -1, 1, 1, 1]]  # an island has no one to join


def test_joining_is_transitive() -> None:
    modes = modes_of([[0, 1, 2]])
    regions = measure(np.array([[0, 1, 2]], np.int32), modes)
    assert join(regions, np.array([[0, 1], [1, 2]], np.int32), modes).labels.tolist() == [[0] * 3]


def test_edison_parts_two_noisy_halves() -> None:
    rng = np.random.default_rng(1)
    luv = rng.normal(0, 2, (40, 40, 3)).astype(np.float32)
    luv[:, 20:, 0] += 40
    mask = np.ones((40, 40), bool)
    with workers(1) as team:
        labels = segment_planes(luv / np.float32(6.5), luv[..., 0], mask, team, min_size=200)
    assert labels.max() == 1
    assert (labels[:, :19] == labels[0, 0]).all()
    assert (labels[:, 21:] == labels[0, 39]).all()


def test_bleiweiss_werman_goes_by_depth_where_it_is_trusted() -> None:
    luv = np.zeros((20, 24, 3), np.float32)
    depth = np.full((20, 24), 1.0, np.float32)
    depth[:, 12:] = 2.0
    with workers(1) as team:
        parted = segment_image(luv, depth, team, min_size=5)
        assert parted.max() == 1
        assert (parted[:, :12] == 0).all()
        distrust = np.zeros((20, 24), np.float32)
        assert segment_image(luv, depth, team, distrust, min_size=5).max() == 0
        assert segment_image(luv, depth * np.float32(np.nan), team, min_size=5).max() == 0
        depth[5:9, 3:6] = np.nan
        np.testing.assert_array_equal(segment_image(luv, depth, team, min_size=5), parted)


def test_filling_takes_the_nearest() -> None:
    values = np.array([[1, 2, 9]], np.float32)
    assert filled(values, np.array([[True, False, True]])).tolist() in ([[1, 1, 9]], [[1, 9, 9]])
    assert filled(values, np.zeros((1, 3), bool)).tolist() == [[0, 0, 0]]
