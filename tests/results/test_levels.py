"""The levels on disk, and the picture of all borders."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue import GeohueError, Scene, segment
from geohue.merge.levels import Levels
from geohue.merge.tree import MergeTree
from geohue.read import read_color, read_levels
from geohue.results.borders import border_map, paint_borders
from geohue.results.levels import write_levels
from geohue.results.outputs import write_results

RELAXED = settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)

Boxes = tuple[Scene, NDArray[np.int32]]


def some_levels(shape: tuple[int, ...], n_regions: int, n_merges: int, seed: int) -> Levels:
    """Random regions and a random tree over them."""
    rng = np.random.default_rng(seed)
    alive, merges = list(range(n_regions)), []
    for _ in range(min(n_merges, n_regions - 1)):
        kept, gone = rng.choice(alive, 2, replace=False).tolist()
        merges.append((kept, gone))
        alive.remove(gone)
    tree = MergeTree(
        n_regions,
        np.array(merges, np.int64).reshape(-1, 2),
        rng.normal(0, 2, len(merges)),
    )
    return Levels(rng.integers(-1, n_regions, shape).astype(np.int32), tree)


levels_of_grids = st.builds(
    some_levels,
    st.tuples(st.integers(1, 12), st.integers(1, 12)),
    st.integers(1, 9),
    st.integers(0, 9),
    st.integers(0, 9999),
)
levels_of_clouds = st.builds(
    some_levels,
    st.tuples(st.integers(1, 60)),
    st.integers(1, 9),
    st.integers(0, 9),
    st.integers(0, 9999),
)


@RELAXED
@given(levels=st.one_of(levels_of_grids, levels_of_clouds))
def test_levels_come_back_whole(tmp_path: Path, levels: Levels) -> None:
    file = tmp_path / "levels.npz"
    write_levels(file, levels)
    again = read_levels(file)
    for ours, theirs in (
        (levels.regions, again.regions),
        (levels.tree.merges, again.tree.merges),
        (levels.tree.scores, again.tree.scores),
        (levels.tree.heights, again.tree.heights),
    ):
        np.testing.assert_array_equal(ours, theirs, strict=True)
    assert again.tree.n_regions == levels.tree.n_regions
    with np.load(file) as arrays:  # as another program would
        assert set(arrays) == {"regions", "n_regions", "merges", "scores", "heights"}
        np.testing.assert_array_equal(arrays["heights"], levels.tree.heights)


@RELAXED
@given(levels=levels_of_grids, detail=st.floats(-5, 5))
def test_the_count_is_that_of_the_labels(levels: Levels, detail: float) -> None:
    labels = levels.at(detail)
    assert levels.count(detail) == len(np.unique(labels[labels >= 0]))


def slow_border_map(levels: Levels) -> NDArray[np.float64]:
    """As `border_map`: the first level, from fine to coarse, in which a border is gone."""
    strength = np.zeros(levels.regions.shape)
    heights = [float(h) for h in levels.tree.heights]
    for y, x in np.ndindex(*levels.regions.shape):
        for v, u in ((y, x + 1), (y + 1, x)):
            if v >= levels.regions.shape[0] or u >= levels.regions.shape[1]:
                continue
            one, other = int(levels.regions[y, x]), int(levels.regions[v, u])
            if min(one, other) < 0 or one == other:
                continue
            score = np.inf
            for i in range(len(heights)):
                segments = levels.tree.after(i + 1)
                if segments[one] == segments[other]:
                    score = heights[i]
                    break
            strength[y, x] = max(strength[y, x], 1 / (1 + np.exp(-score)))
    return strength


@RELAXED
@given(levels=levels_of_grids)
def test_borders_are_as_strong_as_the_merge_that_ends_them(levels: Levels) -> None:
    np.testing.assert_allclose(border_map(levels), slow_border_map(levels), atol=1e-6)


@RELAXED
@given(levels=levels_of_grids)
def test_borders_of_a_half_are_those_of_detail_auto(levels: Levels) -> None:
    labels = np.where(levels.regions < 0, -1, levels.at("auto"))
    parted = np.zeros(labels.shape, bool)
    for one, other, here in (
        (labels[:, :-1], labels[:, 1:], parted[:, :-1]),
        (labels[:-1], labels[1:], parted[:-1]),
    ):
        here |= (one != other) & (one >= 0) & (other >= 0)
    np.testing.assert_array_equal(border_map(levels) >= 0.5, parted)


def test_the_picture_by_hand() -> None:
    tree = MergeTree(3, np.array([[0, 1], [0, 2]]), np.array([0.0, 40.0]))
    levels = Levels(np.repeat(np.array([[0, 1, 2]], np.int32), 4, axis=1), tree)
    drawn = paint_borders(np.full((1, 12, 3), 55, np.uint8), levels)[0]
    faded, ink = 0.75 * 255 + 0.25 * 55, np.array([120, 0, 60])
    np.testing.assert_array_equal(drawn[[0, 5, 11]], np.full((3, 3), round(faded)))
    np.testing.assert_allclose(drawn[3], (faded + ink) / 2, atol=0.51)  # even odds
    np.testing.assert_array_equal(drawn[7], ink)


def test_lines_are_wider_in_large_pictures() -> None:
    regions = np.zeros((900, 20), np.int32)
    regions[:, 10:] = 1
    shapes = {900: np.repeat(regions, 50, axis=1), 300: np.repeat(regions[:300], 20, axis=1)}
    tree = MergeTree(2, np.array([[0, 1]]), np.array([9.0]))
    for height, width in ((900, 3), (300, 1)):
        wide = shapes[height]
        drawn = paint_borders(np.full((*wide.shape, 3), 255, np.uint8), Levels(wide, tree))
        assert (drawn[5, :, 1] < 200).sum() == width


def test_real_levels_of_a_result(tmp_path: Path, three_boxes: Boxes) -> None:
    scene, _ = three_boxes
    seg = segment(scene)
    assert seg.levels is not None
    files = write_results(tmp_path, scene, seg)
    assert [f.name for f in files] == [
        "labels.png",
        "overlay.png",
        "segmented.ply",
        "borders.png",
        "levels.npz",
        "result.json",
    ]
    again = read_levels(tmp_path / "levels.npz")
    assert again.regions.shape == scene.shape
    np.testing.assert_array_equal(again.at(), seg.labels)
    np.testing.assert_array_equal(again.at("fine"), segment(scene, detail="fine").labels)
    np.testing.assert_array_equal(again.with_segments(2), segment(scene, 2).labels)
    drawn = read_color(tmp_path / "borders.png")
    np.testing.assert_array_equal(drawn, paint_borders(scene.colors, seg.levels))
    lean = write_results(tmp_path / "lean", scene, seg, lean=True)
    assert [f.name for f in lean] == ["labels.png", "result.json"]


def test_a_cloud_has_levels_and_no_picture_of_borders(tmp_path: Path, three_boxes: Boxes) -> None:
    grid, _ = three_boxes
    scene = Scene.from_cloud(grid.points.reshape(-1, 3), grid.colors.reshape(-1, 3))
    seg = segment(scene, preset="fast")
    names = [file.name for file in write_results(tmp_path, scene, seg)]
    assert names == ["labels.npy", "overlay.png", "segmented.ply", "levels.npz", "result.json"]
    np.testing.assert_array_equal(read_levels(tmp_path / "levels.npz").at(), seg.labels)


GOOD: dict[str, Any] = {
    "regions": np.array([[0, 1], [2, -1]], np.int32),
    "n_regions": np.int64(3),
    "merges": np.array([[0, 2], [1, 0]]),
    "scores": np.array([-1.0, 2.0]),
}


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"regions": np.array([[0, 3]])}, "names regions beyond its 3"),
        ({"regions": np.array([[0, -2]])}, "names regions beyond its 3"),
        ({"regions": np.zeros((2, 2, 2), int)}, "holds no levels"),
        ({"regions": np.zeros((2, 2))}, "holds no levels"),
        ({"n_regions": np.array([3])}, "holds no levels"),
        ({"n_regions": np.int64(2)}, "names regions beyond its 2"),
        ({"merges": np.array([0, 2])}, "holds no levels"),
        ({"merges": np.array([[0, 2]])}, "holds no levels"),
        ({"merges": np.array([[0, 2], [0, 2]])}, "merges a region twice"),
        ({"merges": np.array([[0, 2], [2, 1]])}, "merges a region twice"),
        ({"merges": np.array([[0, 2], [1, 1]])}, "merges a region twice"),
        ({"scores": np.array([-1.0])}, "holds no levels"),
        ({"scores": np.array([-1.0, np.nan])}, "has no scores"),
        ({"scores": None}, "has no array named 'scores'"),
    ],
)
def test_levels_that_contradict_themselves(
    tmp_path: Path, wrong: dict[str, Any], says: str
) -> None:
    file = tmp_path / "levels.npz"
    np.savez(file, **GOOD)
    assert read_levels(file).at(3.0).tolist() == [[0, 1], [2, -1]]
    content = {name: array for name, array in (GOOD | wrong).items() if array is not None}
    np.savez(file, **content)
    with pytest.raises(GeohueError, match=says):
        read_levels(file)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.95])
def test_a_file_that_is_cut_short(tmp_path: Path, share: float) -> None:
    file = tmp_path / "levels.npz"
    write_levels(file, some_levels((9, 9), 5, 4, 0))
    data = file.read_bytes()
    file.write_bytes(data[: int(share * len(data))])
    with pytest.raises(GeohueError, match="is not a whole NPZ file"):
        read_levels(file)
