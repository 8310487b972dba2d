"""The consensus of cuts in the driver: what it finds, and where it is not asked."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue import PRESETS, GeohueError, Scene, segment
from geohue.regions.images import connected_components
from likeness import adjusted_rand_score

LIGHT = PRESETS["fast"].changed(landmarks=60, draft_points=2000)


@pytest.mark.parametrize("preset", ["fast", "best"])
def test_finds_parts_and_their_number(
    three_boxes: tuple[Scene, NDArray[np.int32]], preset: str
) -> None:
    scene, truth = three_boxes
    result = segment(scene, preset=preset)
    assert result.k == 3
    assert adjusted_rand_score(result.labels.ravel(), truth.ravel()) > 0.99
    assert result.weight in PRESETS[preset].merge.panel
    assert result.weight_curve == []
    assert result.warnings == segment(scene, 3).warnings


def test_in_the_preset_paper(three_boxes: tuple[Scene, NDArray[np.int32]]) -> None:
    scene, truth = three_boxes
    result = segment(scene, weight="consensus", preset="paper")
    assert adjusted_rand_score(result.labels.ravel(), truth.ravel()) > 0.99
    assert segment(scene, preset="paper").weight_curve != []


def test_segments_are_connected() -> None:
    """The same box on both sides of another is two parts."""
    rgb = np.full((60, 90, 3), (60, 160, 70), np.uint8)
    rgb[:, 30:60] = (200, 60, 50)
    rng = np.random.default_rng(0)
    rgb = np.clip(rgb + rng.normal(0, 4, rgb.shape), 0, 255).astype(np.uint8)
    scene = Scene.from_rgbd(rgb, 1 + 0.002 * rng.random((60, 90)))
    labels = segment(scene, preset="fast").labels
    assert labels.max() == connected_components(labels).max() == 2


def test_nothing_to_split() -> None:
    rng = np.random.default_rng(0)
    noise = rng.normal(128, 3, (60, 80, 3)).astype(np.uint8)
    wall = Scene.from_rgbd(noise, 2 + 0.002 * rng.normal(size=(60, 80)))
    assert segment(wall, preset="fast").k == 1
    flat = Scene.from_rgbd(np.zeros((20, 30, 3), np.uint8), np.ones((20, 30)))
    assert segment(flat, preset="best").labels.max() == 0


def test_gaps_in_the_depth_part_nothing(three_boxes: tuple[Scene, NDArray[np.int32]]) -> None:
    scene, truth = three_boxes
    assert scene.depth is not None
    depth = scene.depth.copy()
    depth[20:24, 36:88] = np.nan
    depth[np.random.default_rng(0).random(depth.shape) < 0.1] = np.nan
    result = segment(Scene.from_rgbd(scene.colors, depth), preset="best")
    assert result.k == 3
    assert adjusted_rand_score(result.labels.ravel(), truth.ravel()) > 0.97


def test_where_k_the_weight_or_the_cues_are_given_they_count(
    three_boxes: tuple[Scene, NDArray[np.int32]],
) -> None:
    scene, _ = three_boxes
    assert segment(scene, 2, preset="fast").k == 2
    assert len(segment(scene, 2, "agreement", "fast").weight_curve) > 1
    assert segment(scene, weight=2.0, preset="fast").weight == 2.0
    assert segment(scene, cues="color", preset="fast").weight == 0
    kmeans = segment(scene, method="kmeans", preset="fast")
    assert len(kmeans.weight_curve) > 1


@pytest.mark.parametrize(
    ("given_", "message"),
    [
        ({"k": 3}, r'finds the number of segments itself: leave k="auto"'),
        ({"method": "kmeans"}, 'is for method "nncsc"'),
    ],
)
def test_what_it_cannot_go_with(
    three_boxes: tuple[Scene, NDArray[np.int32]], given_: dict[str, object], message: str
) -> None:
    with pytest.raises(GeohueError, match=message):
        segment(three_boxes[0], weight="consensus", **given_)  # type: ignore[arg-type]


@given(st.integers(0, 2**31))
@settings(deadline=None, max_examples=6)
def test_same_seed_same_labels_at_any_number_of_threads(seed: int) -> None:
    rng = np.random.default_rng(seed % 5)
    rgb = np.kron(rng.integers(0, 255, (6, 8, 3)), np.ones((15, 15, 1))).astype(np.uint8)
    depth = np.kron(rng.uniform(1, 3, (3, 4)), np.ones((30, 30)))
    scene = Scene.from_rgbd(rgb, depth + 0.01 * rng.random(depth.shape))
    runs = [segment(scene, seed=seed, preset=LIGHT, threads=n) for n in (1, 2, 4)]
    for run in runs[1:]:
        assert np.array_equal(run.labels, runs[0].labels)
        assert (run.weight, run.quality) == (runs[0].weight, runs[0].quality)


@given(st.integers(0, 99))
@settings(deadline=None, max_examples=6)
def test_permuting_and_scaling_a_cloud_changes_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    part = np.arange(900) % 3
    points = np.array([[0, 0, 0], [4, 0, 1], [0, 5, 2]])[part] + rng.normal(0, 0.35, (900, 3))
    hues = np.array([[220, 40, 40], [40, 200, 60], [50, 60, 230]])[part]
    colors = np.clip(hues + rng.normal(0, 9, (900, 3)), 0, 255).astype(np.uint8)
    order = rng.permutation(900)
    one = segment(Scene.from_cloud(points, colors), "auto", "consensus", LIGHT).labels
    moved = Scene.from_cloud(8 * points[order], colors[order])
    two = segment(moved, "auto", "consensus", LIGHT).labels
    assert adjusted_rand_score(one[order], two) == 1


@pytest.mark.parametrize(("share", "most"), [(0.3, 4), (0.05, 8)])
def test_sparse_depth_does_not_fall_apart(share: float, most: int) -> None:
    """As of a laser scanner seen by a camera."""
    rng = np.random.default_rng(0)
    truth = np.repeat(np.arange(3), 100)[None].repeat(200, 0)
    rgb = np.array([[200, 60, 50], [60, 160, 70], [50, 80, 200]])[truth]
    rgb = np.clip(rgb + rng.normal(0, 4, rgb.shape), 0, 255).astype(np.uint8)
    depth = np.array([1.0, 1.5, 2.2])[truth] + rng.normal(0, 0.004, truth.shape)
    depth[rng.random(depth.shape) > share] = np.nan
    for preset in ("fast", "best"):
        assert 3 <= segment(Scene.from_rgbd(rgb, depth), preset=preset).k <= most


def touching_halves(n: int) -> tuple[Scene, NDArray[np.int32]]:
    """A plane in two colours, more points of it than the draft of LIGHT has."""
    rng = np.random.default_rng(1)
    points = np.c_[rng.uniform(0, 2, (n, 2)), rng.normal(0, 0.002, n)]
    truth = (points[:, 0] > 1).astype(np.int32)
    colors = np.array([[200, 60, 50], [60, 160, 70]])[truth] + rng.normal(0, 3, (n, 3))
    return Scene.from_cloud(points, np.clip(colors, 0, 255).astype(np.uint8)), truth


def test_touching_parts_of_a_cloud_larger_than_its_draft() -> None:
    scene, truth = touching_halves(6000)
    labels = segment(scene, "auto", "consensus", LIGHT).labels
    assert adjusted_rand_score(truth, labels) > 0.95
    order = np.random.default_rng(2).permutation(6000)
    moved = Scene.from_cloud(scene.points[order], scene.colors[order])
    assert (
        adjusted_rand_score(labels[order], segment(moved, "auto", "consensus", LIGHT).labels) == 1
    )


def test_repeated_points_do_not_become_segments() -> None:
    scene, _ = touching_halves(300)
    many = Scene.from_cloud(scene.points.repeat(20, 0), scene.colors.repeat(20, 0))
    assert (
        segment(many, "auto", "consensus", LIGHT).k < 10
    )  # 314 when a place is no neighbour of others


def test_clouds_only_on_request() -> None:
    scene, _ = touching_halves(3000)
    voting = PRESETS["fast"].changed(weight_rule="consensus")
    assert len(segment(scene, preset=voting).weight_curve) > 1
    assert segment(scene, "auto", "consensus", voting).weight_curve == []


def test_two_views() -> None:
    rgb = np.zeros((60, 90, 3), np.uint8)
    rgb[:, 45:] = (30, 200, 90)
    depth = np.where(np.arange(90) < 45, 1.0, 2.0)[None].repeat(60, 0)
    both = replace(Scene.from_rgbd(rgb, depth), second_colors=rgb)
    assert segment(both, preset="best").labels[0, ::30].tolist() == [0, 0, 1]


def test_points_of_a_cloud_without_a_position() -> None:
    rng = np.random.default_rng(3)
    points = np.concatenate([rng.normal(0, 0.3, (600, 3)), rng.normal(4, 0.3, (600, 3))])
    colors = np.repeat([[200, 30, 30], [30, 30, 200]], 600, axis=0).astype(np.uint8)
    points[::7] = np.nan
    result = segment(Scene.from_cloud(points, colors), weight="consensus")
    assert result.k == 2
    assert np.array_equal(result.labels < 0, np.isnan(points[:, 0]))


@given(st.integers(0, 2**20))
@settings(deadline=None, max_examples=25)
def test_strange_scenes_never_give_stray_labels(seed: int) -> None:
    rng = np.random.default_rng(seed)
    h, w = rng.integers(1, 24, 2)
    rgb = rng.integers(0, rng.choice([2, 256]), (h, w, 3)).astype(np.uint8)
    depth = rng.choice([0.0, np.nan, np.inf, 1.0, 1e-30, 1e30, 2.0], (h, w))
    scene = Scene.from_rgbd(rgb, depth)
    if not scene.valid.any():
        return
    result = segment(scene, preset=LIGHT)
    assert set(np.unique(result.labels)) == set(range(result.k))


def test_a_few_points_with_depth_are_enough() -> None:
    """A grid with so little depth that no kept row and column meets a point of it."""
    rng = np.random.default_rng(0)
    rgb = rng.integers(0, 255, (300, 400, 3), np.uint8)
    depth = np.full((300, 400), np.nan)
    depth[1, 1], depth[200, 203], depth[77, 91] = 1, 2, 1.5
    for preset in PRESETS:
        assert segment(Scene.from_rgbd(rgb, depth), preset=preset).n_labelled == rgb[..., 0].size


def test_frees_the_objects_on_a_table(data_dir: Path) -> None:
    """Where Q cuts the table in pieces, and K from eigenvalues leaves the objects on it."""
    import cv2

    from geohue.measures import evaluate
    from geohue.read.scenes.scenes import read_scene

    folder = data_dir / "mosd" / "frames" / "learn3"
    scene = read_scene(folder / "rgb.png", folder / "depth.png", folder / "intrinsics.json")
    truth = cv2.imread(str(folder / "labels_object.png"), cv2.IMREAD_UNCHANGED)
    assert truth is not None
    paper, best = (
        evaluate(segment(scene, preset=preset).labels, truth.astype(np.int32))["voi_bits"]
        for preset in ("paper", "best")
    )
    assert best < 0.6 * paper
