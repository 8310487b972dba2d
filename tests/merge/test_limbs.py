"""Limbs: known shapes, laws, the slow twins, and real plants."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from geohue import GeohueError
from geohue.measures import evaluate, segmentation_covering
from geohue.merge.branching import near_pairs
from geohue.merge.limb_spans import BANDS, Spans
from geohue.merge.limb_surface import Surface
from geohue.merge.limb_sweep import CLOSED, sweep_inwards
from geohue.merge.limb_trunk import Paths
from geohue.merge.limbs import SMALL, find_limbs
from geohue.read.clouds.cloud import read_cloud
from geohue.simulate.branching import branching_cloud
from geohue.simulate.patches import sample, sheet
from twins import limbs as twin

Floats = NDArray[np.float64]
law = settings(deadline=None, max_examples=25)


def strip(x: tuple[int, int], y: tuple[int, int]) -> Floats:
    """Lattice points of a rectangle, both ends included."""
    a, b = np.meshgrid(np.arange(x[0], x[1] + 1), np.arange(y[0], y[1] + 1))
    return np.stack([a.ravel(), b.ravel(), 0 * a.ravel()], axis=1).astype(np.float64)


def lattice_plant() -> tuple[Floats, NDArray[np.int64]]:
    """A stem three points wide with leaves at both sides; the leaves from 1, the stem 0."""
    parts = [strip((-1, 1), (0, 80))]
    parts += [strip((2, 40), (at, at + 2)) for at in (18, 46)]
    parts += [strip((-40, -2), (at, at + 2)) for at in (32, 60)]
    parts += [strip((2, 30), (78, 80)), strip((-30, -2), (78, 80))]
    return np.concatenate(parts), np.repeat(np.arange(7), [len(part) for part in parts])


def lattice_pairs(points: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pair points at a distance of 1."""
    away = np.linalg.norm(points[:, None] - points[None], axis=2)
    one, other = np.nonzero(np.triu(away == 1))
    return one, other


def test_a_plant_of_lattice_points_is_parted_into_stem_and_leaves() -> None:
    points, truth = lattice_plant()
    limbs = find_limbs(points, *lattice_pairs(points), 1.0)
    for leaf in range(1, 7):
        outer = (truth == leaf) & (np.abs(points[:, 0]) > 5)
        assert len(set(limbs.labels[outer].tolist())) == 1
    assert len(limbs.sizes) == 7
    assert limbs.trunk.sum() == 1
    stem = (truth == 0) & (points[:, 1] < 60)
    assert limbs.trunk[limbs.labels[stem]].mean() > 0.95
    assert segmentation_covering(limbs.labels, truth, ignore=None) > 0.85
    assert (limbs.slimness[~limbs.trunk] > 5).all()


def test_the_foot_of_the_stem_is_no_limb() -> None:
    points, truth = lattice_plant()
    labels = find_limbs(points, *lattice_pairs(points), 1.0).labels
    foot = labels[(truth == 0) & (points[:, 1] < 10)]
    middle = labels[(truth == 0) & (points[:, 1] > 36) & (points[:, 1] < 44)]
    assert set(foot.tolist()) == set(middle.tolist())


def test_the_thick_foot_of_a_tree_is_no_limb() -> None:
    found = []
    for seed in range(6):
        points, truth = branching_cloud("tree", 6000, seed)
        limbs = find_limbs(points, *near_pairs(points))
        foot = (truth == 0) & (points[:, 2] < 1)
        found.append(limbs.trunk[limbs.labels[foot]].mean())
    assert np.mean(found) > 0.6


def test_leaves_that_touch_on_their_way_are_told_apart_to_the_stem() -> None:
    """Two leaves side by side touch half-way; further in they are two all the same."""
    leaves = [(2, 18, 3), (2, 32, 3), (2, 46, 3), (2, 50, 3), (-2, 25, -3), (-2, 60, -3)]
    patches = [sheet((-2, 0, 0), (4, 0, 0), (0, 70, 0), 0)]
    for leaf, (x, y, side) in enumerate(leaves, 1):
        patches.append(sheet((x, y, 0), (7 * side, 0, 0), (0, 3, 0), leaf))
        patches.append(
            sheet((x + 7 * side, y, 0), (5 * side, 0, (9, -9)[leaf % 2]), (0, 3, 0), leaf)
        )
    patches += [sheet((at, 49, 0), (2, 0, 0), (0, 1, 0), 3) for at in (12, 20)]
    points, truth = sample(patches, 12_000, np.random.default_rng(0))
    labels = find_limbs(points, *near_pairs(points)).labels
    inner = (points[:, 0] > 9) & (points[:, 0] < 20)
    lower, upper = (np.bincount(labels[inner & (truth == leaf)], minlength=12) for leaf in (3, 4))
    assert lower.argmax() != upper.argmax()
    assert min(lower.max() / lower.sum(), upper.max() / upper.sum()) > 0.6


@given(st.integers(0, 50), st.sampled_from(["maize", "tree", "cables", "animal"]))
@law
def test_pose_scale_and_order_change_nothing(seed: int, name: str) -> None:
    points, _ = branching_cloud(name, 900, seed)
    rng = np.random.default_rng(seed)
    one, other, spacing = near_pairs(points)
    limbs = find_limbs(points.astype(np.float64), one, other, spacing)
    scale = float(rng.uniform(0.001, 1000))
    turned = Rotation.random(rng=rng).apply(points.astype(np.float64)) * scale + rng.normal(size=3)
    order = rng.permutation(len(points))
    place = np.argsort(order)
    flip = rng.random(len(one)) < 0.5
    one, other = place[np.where(flip, other, one)], place[np.where(flip, one, other)]
    again = find_limbs(turned[order], one, other, spacing * scale)
    assert segmentation_covering(again.labels, limbs.labels[order], ignore=None) > 0.999
    np.testing.assert_allclose(again.reach / scale, limbs.reach[order], rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(np.sort(again.slimness), np.sort(limbs.slimness), rtol=1e-3)


@pytest.mark.parametrize("part", [2, 4])
def test_fewer_points_give_nearly_the_same_limbs(part: int) -> None:
    found = []
    for seed in range(4):
        points, _ = branching_cloud("maize", 8000, seed)
        whole = find_limbs(points, *near_pairs(points)).labels
        few = points[::part]
        labels = find_limbs(few, *near_pairs(few)).labels
        found.append(segmentation_covering(labels, whole[::part], ignore=None))
    assert np.mean(found) > 0.85


@given(st.integers(0, 2**31), st.floats(0, 6), st.floats(0, 4))
@settings(deadline=None, max_examples=150)
def test_the_compiled_sweep_equals_sets_of_points(seed: int, shortest: float, cell: float) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 40))
    one, other = rng.integers(0, n, (2, int(rng.integers(0, 3 * n))))
    height = rng.permutation(n).astype(np.float64)
    surface = Surface.of(rng.random((n, 3)), one, other, np.inf)
    parent, size, state = np.full(n, -1, np.int32), np.zeros(n, np.int64), np.zeros(n, np.int8)
    sweep_inwards(
        np.argsort(-height),
        height,
        surface.graph.indptr.astype(np.int32),
        surface.graph.indices.astype(np.int32),
        shortest,
        cell,
        np.empty(n, np.int32),
        parent,
        size,
        state,
    )
    limbs: dict[int, set[int]] = {}
    for v in range(n):
        root = v
        while parent[root] != root:
            root = int(parent[root])
        if state[root] == CLOSED:
            limbs.setdefault(root, set()).add(v)
            assert height[root] >= height[v]
    pairs = list(zip(one.tolist(), other.tolist(), strict=True))
    slow = twin.sweep(height.tolist(), pairs, shortest, cell)
    assert {frozenset(limb) for limb in limbs.values()} == slow
    assert all(size[root] == len(limb) for root, limb in limbs.items())


@given(st.integers(0, 2**31))
@law
def test_widths_and_paths_equal_their_twins(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(20, 60))
    points, reach = rng.random((n, 3)), rng.random(n)
    owner = np.concatenate([[0, 1, 2], rng.integers(-1, 3, n - 3)])
    spans = Spans.of(points, owner, reach)
    for limb in range(3):
        inside = owner == limb
        assert spans.lengths[limb] == np.ptp(reach[inside])
        assert spans.widths[limb] == pytest.approx(twin.width(points[inside], reach[inside], BANDS))
    place, limbs = rng.choice(n, 15, replace=False), rng.integers(0, 4, 15)
    radius = float(rng.uniform(0, 0.8))
    slow = twin.limbs_beside(points, place.tolist(), limbs.tolist(), radius)
    assert Paths(place, limbs).limbs_beside(points, radius).tolist() == slow


def ring(n: int = 200) -> Floats:
    turn = np.linspace(0, 2 * np.pi, n, endpoint=False)
    return np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)


RNG = np.random.default_rng(0)
SINGLE = {
    "one point": np.ones((1, 3)),
    "two points": np.eye(3)[:2],
    "three points": np.eye(3),
    "all in one place": np.ones((50, 3)),
    "many in few places": np.repeat(strip((0, 6), (0, 6)), 20, axis=0),
    "a line": np.arange(100.0)[:, None] * [[1, 2, 3]],
    "a strip": strip((0, 80), (0, 3)),
    "a plane": strip((0, 29), (0, 29)),
    "a ring": ring(),
    "two rings that touch": np.concatenate([ring(), ring() + np.array([2, 0, 0])]),
    "a ball": RNG.normal(size=(500, 3)),
    "a cube": RNG.random((500, 3)),
}


@pytest.mark.parametrize("name", SINGLE)
def test_what_does_not_branch_is_one_segment(name: str) -> None:
    points = SINGLE[name]
    limbs = find_limbs(points, *near_pairs(points))
    assert limbs.labels.tolist() == [0] * len(points)
    assert limbs.trunk.tolist() == [True]
    assert limbs.slimness.tolist() == [0]


def test_no_points_have_no_limbs() -> None:
    limbs = find_limbs(np.zeros((0, 3)), *near_pairs(np.zeros((0, 3))))
    assert limbs.labels.shape == (0,)
    assert limbs.sizes.shape == (0,)


def test_two_things_far_apart_have_a_trunk_each_and_crumbs_go_to_the_nearest() -> None:
    points, _ = branching_cloud("cables", 2000, 3)
    crumbs = RNG.normal([40, 0, 0], 1e-3, (20, 3))
    both = np.concatenate([points, points + np.array([50, 0, 0]), crumbs])
    assert len(crumbs) < SMALL * len(both)
    one, other, spacing = near_pairs(both)
    limbs = find_limbs(both, one, other, spacing)
    alone = find_limbs(points, *near_pairs(points))
    assert limbs.trunk.sum() == 2
    assert len(limbs.sizes) == 2 * len(alone.sizes)
    assert segmentation_covering(limbs.labels[:2000], alone.labels, ignore=None) > 0.95
    assert set(limbs.labels[:2000].tolist()).isdisjoint(limbs.labels[2000:].tolist())
    assert limbs.sizes.tolist() == np.bincount(limbs.labels).tolist()
    assert sorted(limbs.sizes.tolist(), reverse=True) == limbs.sizes.tolist()


@pytest.mark.parametrize("points", [np.zeros((4, 2)), np.full((4, 3), np.nan)])
def test_other_points_are_refused(points: Floats) -> None:
    none = np.zeros(0, np.int64)
    with pytest.raises(GeohueError, match="finite numbers"):
        find_limbs(points, none, none, 1.0)


def test_real_plants_fall_into_stem_and_leaves(data_dir: Path) -> None:
    rows = []
    for path in sorted((data_dir / "maize").glob("*.ply")):
        cloud = read_cloud(path)
        assert cloud.labels is not None
        labels = find_limbs(cloud.points, *near_pairs(cloud.points)).labels
        found = evaluate(labels, cloud.labels)
        rows.append([found["voi_bits"], found["rand"], found["covering"]])
    if not rows:
        pytest.skip("no plants")
    voi, rand, covering = np.mean(rows, axis=0)
    assert voi < 0.95
    assert rand > 0.93
    assert covering > 0.78
