"""From a draft to all points of a scene."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue import Scene
from geohue.compute.parallel import workers
from geohue.features import lab_of
from geohue.merge.borders import draw_borders
from geohue.merge.carry import carry
from geohue.merge.score import Cues


def carried(
    scene: Scene, draft: NDArray[np.int64], regions: NDArray[np.int32], cues: Cues = "fusion"
) -> NDArray[np.int32]:
    segments = np.arange(int(regions.max()) + 1, dtype=np.int32)
    with workers(2) as team:
        return carry(regions, segments, draft, scene, team, cues)


@given(st.integers(0, 2**20), st.integers(1, 40))
@settings(deadline=None, max_examples=25)
def test_points_of_a_cloud(seed: int, m: int) -> None:
    """Nearest in space and colour among the four nearest points of the draft."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(80, 3)).astype(np.float32)
    points[::9] = np.nan
    colors = rng.integers(0, 256, (80, 3)).astype(np.uint8)
    scene = Scene.from_cloud(points, colors)
    draft = rng.choice(np.flatnonzero(scene.valid), m, replace=False)
    regions = np.arange(m, dtype=np.int32)
    found = carried(scene, draft, regions)
    places = points[draft].astype(float)
    apart = np.linalg.norm(places[:, None] - places, axis=2)
    np.fill_diagonal(apart, np.inf)
    spacing = np.median(apart.min(axis=1)) if m > 1 else 1.0
    for i in range(80):
        if not scene.valid[i]:
            assert found[i] == -1
            continue
        away = np.linalg.norm(places - points[i].astype(float), axis=1)
        color = ((colors[draft].astype(float) - colors[i]) ** 2).sum(axis=1)
        near = np.argsort(away)[:4]
        assert found[i] == near[((away / spacing) ** 2 + color / 900)[near].argmin()]


def test_one_place() -> None:
    scene = Scene.from_cloud(np.ones((5, 3)), np.zeros((5, 3), np.uint8))
    assert carried(scene, np.array([1, 3]), np.array([0, 0], np.int32)).tolist() == [0] * 5


def test_grids_by_colour_and_the_logarithm_of_depth() -> None:
    rng = np.random.default_rng(0)
    rgb = rng.integers(0, 255, (24, 32, 3)).astype(np.uint8)
    depth = rng.uniform(1, 3, (24, 32))
    depth[5:9, 3:20] = np.nan
    scene = Scene.from_rgbd(rgb, depth)
    draft = scene.thinning(60, rng)
    regions = rng.integers(0, 4, draft.shape).astype(np.int32)
    organised = Scene(scene.colors, scene.points)  # no depth map: z takes its place
    values = np.dstack([lab_of(rgb), np.log(depth)]).astype(np.float32)
    segments = np.arange(4, dtype=np.int32)
    with workers(1) as team:
        full = draw_borders(regions, segments, draft[:, 0] // 32, draft[0] % 32, values, team)
    expected = np.where(np.isnan(depth), -1, full)
    assert np.array_equal(carried(scene, draft, regions), expected)
    assert np.array_equal(carried(organised, draft, regions), expected)


def test_an_image_alone_is_labelled_everywhere() -> None:
    scene = Scene.from_image(np.zeros((9, 12, 3), np.uint8))
    draft = scene.thinning(30, np.random.default_rng(0))
    assert (carried(scene, draft, np.zeros(draft.shape, np.int32), "color") == 0).all()


def test_a_cue_that_takes_no_part_draws_no_border() -> None:
    rng = np.random.default_rng(1)
    rgb, more = rng.integers(0, 255, (2, 24, 32, 3)).astype(np.uint8)
    depth, other = rng.uniform(1, 3, (2, 24, 32))
    other[3:9] = np.nan
    scenes = [Scene.from_rgbd(c, d) for c, d in ((rgb, depth), (rgb, other), (more, depth))]
    draft = scenes[0].thinning(60, rng)
    regions = rng.integers(0, 4, draft.shape).astype(np.int32)
    by_color = [carried(scene, draft, regions, "color") for scene in scenes]
    by_depth = [carried(scene, draft, regions, "geometry") for scene in scenes]
    assert np.array_equal(by_color[0], by_color[1])
    assert not np.array_equal(by_color[0], by_color[2])
    assert np.array_equal(by_depth[0], by_depth[2])
    assert not np.array_equal(by_depth[0], np.where(np.isnan(other), by_depth[0], by_depth[1]))


def test_colours_of_a_cloud_count_unless_geometry_is_alone() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0.4, 0, 0]])
    colors = np.array([[0, 0, 0], [200, 0, 0], [200, 0, 0]], np.uint8)
    scene, draft = Scene.from_cloud(points, colors), np.array([0, 1])
    two = np.array([0, 1], np.int32)
    assert carried(scene, draft, two).tolist() == [0, 1, 1]
    assert carried(scene, draft, two, "geometry").tolist() == [0, 1, 0]
