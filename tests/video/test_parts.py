"""The parts of video segmentation: model, borders, held levels, motion, tracks, change, cloud."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue import PRESETS, GeohueError, Intrinsics, Scene
from geohue.compute.parallel import Workers
from geohue.features import Raw
from geohue.merge.tree import MergeTree
from geohue.ncut.cutter import Cutter
from geohue.prepared import PreparedScene
from geohue.read import read_cloud
from geohue.simulate.moving import MovingFrame
from geohue.video.borders import carry_borders
from geohue.video.change import CUT, Fit, Look, why_anew
from geohue.video.fused import FusedCloud
from geohue.video.held import held_level
from geohue.video.model import CarriedModel
from geohue.video.motion import agreeing, reprojected
from geohue.video.tracks import Sighting, Tracker, sightings
from twins import video as twin

FAST = PRESETS["fast"]


def ints(rows: list[list[int]]) -> NDArray[np.int32]:
    return np.array(rows, np.int32)


def test_the_model_votes_as_the_cuts_it_was_made_from(film: list[MovingFrame]) -> None:
    scene = film[0].scene
    draft = scene.take(scene.thinning(1500, np.random.default_rng(0)))
    model = CarriedModel.fit(draft, FAST)
    features = model.features(draft)
    whole = PreparedScene.of(Raw(draft), features, FAST)
    cutter = Cutter(whole, max(FAST.merge.counts))
    wanted = [m for w in FAST.merge.panel for m in cutter.draft_cuts(float(w), FAST.merge.counts)]
    found = model.maps(features, Workers(None))
    assert len(found) == len(wanted) == 9
    for one, other in zip(found, wanted, strict=True):
        np.testing.assert_array_equal(one, other)
    assert model.strangers(features) < 0.1


def test_a_pose_brings_points_to_where_the_model_was_made(film: list[MovingFrame]) -> None:
    scene, pose = film[0].scene, film[0].pose
    draft = scene.take(scene.thinning(1500, np.random.default_rng(0)))
    way = np.eye(4)
    way[:3, 3] = 0.2, -0.1, 0.3
    moved = replace(draft, points=(draft.points - way[:3, 3]).astype(np.float32))
    model = CarriedModel.fit(draft, FAST, pose)
    here, there = model.features(draft, pose), model.features(moved, pose @ way)
    np.testing.assert_allclose(here.geometry, there.geometry, atol=1e-5)


def test_strangers_are_far_from_all_landmarks(film: list[MovingFrame]) -> None:
    scene = film[0].scene
    draft = scene.take(scene.thinning(1500, np.random.default_rng(0)))
    model = CarriedModel.fit(draft, FAST)
    colors = draft.colors.copy()
    colors[:, : colors.shape[1] // 2] = (255, 0, 255)
    share = model.strangers(model.features(replace(draft, colors=colors)))
    assert share == pytest.approx(0.5, abs=0.03)


def test_names_cannot_vote(film: list[MovingFrame]) -> None:
    scene = film[0].scene
    draft = scene.take(scene.thinning(500, np.random.default_rng(0)))
    with pytest.raises(GeohueError, match="only weights"):
        CarriedModel.fit(draft, FAST.changed(panel=(1.0, "kmeans")))


def test_borders_are_those_of_the_slow_twin() -> None:
    rng = np.random.default_rng(3)
    truth = np.zeros((42, 56), np.int32)
    truth[10:30, 20:47], truth[25:, :17] = 1, 2
    colors = np.array([[90, 90, 90], [130, 80, 80], [60, 120, 60]])[truth]
    depth = np.array([2.0, 1.9, 1.7])[truth] + rng.normal(0, 0.02, truth.shape)
    depth[5:12, 15:30] = np.nan
    noisy = np.clip(colors + rng.normal(0, 9, colors.shape), 0, 255).astype(np.uint8)
    scene = Scene.from_rgbd(noisy, depth, Intrinsics(50.0, 50.0, 28.0, 21.0))
    positions = scene.thinning(100, rng)
    rough = truth.reshape(-1)[np.minimum(positions + 2, truth.size - 1)]
    found = carry_borders(rough, positions, scene, Workers(None))
    np.testing.assert_array_equal(found, twin.carry_borders(rough, positions, scene))
    assert (found == truth).mean() > 0.93


trees = st.integers(2, 8).flatmap(
    lambda n: st.tuples(
        st.just(n), st.permutations(range(n)), st.lists(st.floats(-3, 3), min_size=n, max_size=n)
    )
)


@settings(max_examples=60, deadline=None)
@given(trees, st.floats(-2, 2))
def test_without_a_past_the_level_is_that_of_the_tree(
    drawn: tuple[int, list[int], list[float]], threshold: float
) -> None:
    n, order, scores = drawn
    merges = np.array([(order[0], other) for other in order[1:]], np.int64).reshape(-1, 2)
    tree = MergeTree(n, merges, np.array(scores[: n - 1]))
    for shares in (np.zeros((n, 0)), np.zeros((n, 3))):
        np.testing.assert_array_equal(held_level(tree, shares, threshold), tree.at(threshold))
    same = held_level(tree, np.ones((n, 1)), threshold, together=0.7)
    np.testing.assert_array_equal(same, tree.at(threshold + 0.7))
    apart = held_level(tree, np.eye(n), threshold, apart=0.7)
    assert apart.max() >= tree.at(threshold).max()
    two = MergeTree(2, np.array([[0, 1]]), np.array([-0.5]))
    assert held_level(two, np.eye(2), apart=0.4).tolist() == [0, 0]
    assert held_level(two, np.eye(2), apart=0.6).tolist() == [0, 1]


def test_labels_follow_the_camera() -> None:
    camera = Intrinsics(20.0, 20.0, 9.5, 7.5, 20, 16)
    depth = np.full((16, 20), 2.0)
    scene = Scene.from_rgbd(np.zeros((16, 20, 3), np.uint8), depth, camera)
    positions = scene.thinning(80, np.random.default_rng(0))
    points = scene.take(positions).points
    labels = np.arange(80, dtype=np.int32).reshape(8, 10)
    here, far = reprojected(labels, points, np.eye(4), camera, positions, (16, 20))
    np.testing.assert_array_equal(here, labels)
    assert far == pytest.approx(2.0)
    way = np.eye(4)
    way[0, 3] = 0.4  # two metres away 0.4 m are 4 pixels, two columns of the draft
    there, _ = reprojected(labels, points, way, camera, positions, (16, 20))
    np.testing.assert_array_equal(there[:, 2:], labels[:, :-2])
    assert (there[:, :2] == -1).all()


def test_what_is_nearer_hides_what_is_behind() -> None:
    camera = Intrinsics(10.0, 10.0, 0.0, 0.0, 1, 1)
    points = np.array([[[0, 0, 1.0], [0, 0, 3.0], [0, 0, np.nan], [0, 0, -1.0]]])
    one, far = reprojected(
        ints([[7, 8, 9, 5]]), points, np.eye(4), camera, np.zeros((1, 1), np.int64), (1, 1)
    )
    assert (one.tolist(), far.tolist()) == ([[7]], [[1.0]])
    depth = np.array([[1.0, 2.0, np.nan]])
    kept = agreeing(ints([[1, 1, 1]]), np.array([[1.04, 1.5, 1.0]]), depth)
    assert kept.tolist() == [[1, -1, 1]]


def sighting(frame: int, x: float = 0.0, color: float = 50.0, size: int = 100) -> Sighting:
    center = np.array([x, 0.0, 2.0])
    return Sighting(
        -1,
        frame,
        size,
        np.array([color, 0, 0]),
        center,
        center - 0.1,
        center + 0.1,
        np.array([0.5, 0.5 + x]),
    )


def test_a_lost_thing_is_known_again_by_its_color_and_place() -> None:
    for frame, x, color, same in (
        (10, 0.1, 52.0, True),
        (10, 2.0, 50.0, False),
        (10, 0.1, 150.0, False),
        (40, 0.0, 50.0, False),
    ):
        tracker = Tracker(memory=20)
        tracker.identify([sighting(0), sighting(0, 5.0, 90.0)], np.zeros((0, 2)))
        tracker.identify([sighting(1, 5.0, 90.0)], np.array([[0.0], [0.9]]))
        nothing = np.zeros((len(tracker.tracks), 1))
        (found,) = tracker.identify([sighting(frame, x, color)], nothing)
        assert (found.track == 0) is same


def test_overlap_decides_between_things_alike() -> None:
    tracker = Tracker()
    tracker.identify([sighting(0), sighting(0, 0.05)], np.zeros((0, 2)))
    found = tracker.identify(
        [sighting(1, 0.02), sighting(1, 0.03)], np.array([[0.1, 0.8], [0.7, 0.1]])
    )
    assert [one.track for one in found] == [1, 0]
    assert tracker.tracks[0].n_frames == 2
    assert tracker.following == 2


def test_sightings_say_where_and_what_a_segment_is() -> None:
    labels = ints([[0, 0], [1, 1]])
    lab = np.array([[[10, 0, 0], [20, 0, 0]], [[0, 5, 0], [0, 5, 0]]], float)
    points = np.full((2, 2, 3), np.nan)
    points[0] = [[0, 0, 2], [1, 0, 2]]
    one, other = sightings(labels, lab, points, 4, scale=3.0)
    assert (one.size, one.frame, one.color.tolist()) == (6, 4, [15, 0, 0])
    assert one.center is not None
    assert one.low is not None
    assert one.high is not None
    assert (one.center.tolist(), one.low[0], one.high[0]) == ([0.5, 0, 2], 0, 1)
    assert other.center is None
    assert other.place.tolist() == [0.75, 0.5]


def test_a_model_is_made_anew_by_the_stated_tests() -> None:
    first = Fit(0.004, 0.8)
    assert why_anew(first, first) is None
    assert why_anew(first, Fit(0.013, 0.61)) is None
    assert why_anew(first, Fit(0.015, 0.8)) == "new"
    assert why_anew(first, Fit(0.004, 0.59)) == "votes"
    assert why_anew(first, Fit(0.004, 0.8, unused_depth=True)) == "depth"


def test_a_cut_changes_color_and_depth(film: list[MovingFrame]) -> None:
    scene = film[0].scene
    look = Look.of(scene)
    assert look.change(look) == 0
    darker = Look.of(replace(scene, colors=scene.colors // 2))
    other = Look.of(replace(scene, points=scene.points * 4, colors=255 - scene.colors))
    assert look.change(darker) < 0.3
    assert look.change(other) > CUT
    blind = Look.of(Scene.from_image(scene.colors))
    assert blind.depth is None
    assert look.change(blind) < 0.05


def test_voxels_have_the_mean_color_and_the_label_of_most(tmp_path: Path) -> None:
    camera = Intrinsics(10.0, 10.0, 0.0, 0.0, 1, 1)
    cloud = FusedCloud(0.5)
    for grey, label in ((10, 3), (20, 3), (60, 8)):
        scene = Scene.from_rgbd(np.full((1, 1, 3), grey, np.uint8), [[1.2]], camera)
        cloud.add(scene, ints([[label]]), np.eye(4))
    cloud.add(scene, ints([[1]]), None)
    pose = np.eye(4)
    pose[0, 3] = 3.0
    cloud.add(scene, ints([[1]]), pose)
    assert len(cloud) == 2
    cloud.write(tmp_path / "cloud.ply")
    found = read_cloud(tmp_path / "cloud.ply")
    assert found.points.tolist() == [[0, 0, pytest.approx(1.2)], [3, 0, pytest.approx(1.2)]]
    assert found.colors is not None
    assert found.colors[0].tolist() == [30] * 3
    assert found.labels is not None
    assert found.labels.tolist() == [3, 1]


def test_the_cloud_stays_within_its_bound() -> None:
    camera = Intrinsics(60.0, 60.0, 31.5, 31.5, 64, 64)
    scene = Scene.from_rgbd(np.zeros((64, 64, 3), np.uint8), np.full((64, 64), 1.0), camera)
    cloud = FusedCloud(0.01, most=200)
    labels = np.zeros((64, 64), np.int32)
    for _ in range(3):
        cloud.add(scene, labels, np.eye(4))
        assert len(cloud) <= 200
    assert cloud.size == 0.08
    with pytest.raises(GeohueError, match="above 0"):
        FusedCloud(0)
