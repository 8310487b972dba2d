"""Superpoints of a cloud in tiles: no seams, nothing lost, and the same after a kill."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from typer.testing import CliRunner

import geohue
from geohue import GeohueError, Scene, superpoints_file
from geohue.cli.app import app
from geohue.large import superpoints as runs
from geohue.large.tile_graph import with_crumbs
from geohue.large.tile_regions import split_tile
from geohue.large.tiles import Tiles
from geohue.measures import adjusted_rand_index, superpoint_scores
from geohue.regions.groups import connected_groups
from geohue.simulate import scene as simulated
from geohue.superpoint.nodes import near_pairs
from geohue.superpoint.opened import merge_inside
from geohue.superpoint.ward import COLUMNS, SIZE, Regions, merge_regions
from geohue.superpoint.weights import merging_weights

N, TILE = 30_000, 5_000
Labels = NDArray[np.int64]


def _plane(n: int, seed: int = 0) -> NDArray[np.float64]:
    """Rows of a plane far from the origin with soft colours, in random order."""
    rng = np.random.default_rng(seed)
    xyz = rng.random((n, 3)) * [4, 4, 0] + rng.normal(0, 0.002, (n, 3)) * [0, 0, 1]
    waves = 120 + 30 * np.sin(3 * xyz[:, [0]]) * np.cos(2 * xyz[:, [1]])
    rgb = (waves + rng.normal(0, 8, (n, 3))).clip(0, 255).round()
    return np.hstack([xyz + np.array([3000, -500, 20]), rgb])


@pytest.fixture(scope="module")
def plane(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plane, two of whose points have no place."""
    rows = _plane(N)
    rows[[3, N - 5], 0] = np.nan
    file = tmp_path_factory.mktemp("plane") / "plane.npy"
    np.save(file, rows)
    return file


@pytest.fixture
def small_tiles(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runs, "TILE", TILE)


@pytest.fixture(scope="module")
def split(plane: Path) -> tuple[runs.FileSuperpoints, Labels, Tiles]:
    """The plane in tiles, and the tiles."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(runs, "TILE", TILE)
        seen: list[Tiles] = []
        before = split_tile

        def watched(*given: Any) -> Any:
            seen.append(given[2])
            return before(*given)

        patch.setattr(runs, "split_tile", watched)
        found = superpoints_file(plane, plane.parent / "split", count=[500, 60])
    assert len(seen) == found.n_tiles >= 6
    return found, np.load(found.labels_file), seen[0]


@pytest.mark.parametrize("level", [0, 1])
def test_no_more_borders_along_the_faces_than_elsewhere(
    plane: Path, split: tuple[runs.FileSuperpoints, Labels, Tiles], level: int
) -> None:
    found, _, tiles = split
    xyz = np.load(plane)[:, :3]
    known = np.isfinite(xyz[:, 0])
    labels = np.load(found.labels_file.parent / "levels.npz")["labels"][level][known]
    scene = Scene.from_cloud(xyz[known], np.load(plane)[known, 3:].astype(np.uint8))
    whole = geohue.superpoints(scene, count=found.counts[level]).labels
    one, other, _ = near_pairs(xyz[known] - [3000, -500, 20])
    tile = tiles.find(xyz[known])
    across = tile[one] != tile[other]
    assert across.sum() > 1000

    def ratio(labels: NDArray[np.integer[Any]]) -> float:
        apart = labels[one] != labels[other]
        return float(apart[across].mean() / apart[~across].mean())

    # Where no tiles were, the faces are as good as any line; cut fine regions give 1.5.
    assert ratio(labels) < ratio(whole) + 0.12


def test_as_the_whole_cloud(plane: Path, split: tuple[runs.FileSuperpoints, Labels, Tiles]) -> None:
    found, labels, _ = split
    rows = np.load(plane)
    known = np.isfinite(rows[:, 0])
    assert (labels[~known] == -1).all()
    assert np.bincount(labels[known]).min() > 0
    assert found.k == 500 == labels.max() + 1
    assert (np.diff(np.bincount(labels[known])) <= 0).all()
    xyz = rows[known, :3] - [3000, -500, 20]
    one, other, spacing = near_pairs(xyz)
    assert found.spacing == pytest.approx(spacing, rel=0.03)
    assert connected_groups(labels[known].astype(np.int32), one, other).max() + 1 == 500


def test_one_tile_and_many_give_nearly_the_same_labels(
    plane: Path, split: tuple[runs.FileSuperpoints, Labels, Tiles], monkeypatch: pytest.MonkeyPatch
) -> None:
    found, labels, _ = split
    monkeypatch.setattr(runs, "survey", lambda *_: np.array([found.spacing]))
    alone = superpoints_file(plane, plane.parent / "alone", count=500)
    assert alone.n_tiles == 1
    assert adjusted_rand_index(labels, np.load(alone.labels_file)) > 0.85


@pytest.mark.usefixtures("small_tiles")
def test_accuracy_as_in_memory(tmp_path: Path) -> None:
    frame, truth = simulated("boxes", "kinect")
    known = frame.valid
    xyz, rgb = frame.points[known], frame.colors[known]
    np.save(tmp_path / "room.npy", np.hstack([xyz, rgb]))
    found = superpoints_file(tmp_path / "room.npy", tmp_path / "out", count=[400, 80])
    whole = geohue.superpoints(Scene.from_cloud(xyz, rgb), count=400)
    levels = np.load(tmp_path / "out" / "levels.npz")
    assert found.n_tiles > 10
    assert whole.levels is not None
    for level, n in zip(levels["labels"], (400, 80), strict=True):
        best = superpoint_scores(whole.levels.with_segments(n), truth[known] + 1)
        own = superpoint_scores(level, truth[known] + 1)
        assert own["n_superpoints"] == n
        assert own["achievable_accuracy"] > best["achievable_accuracy"] - 0.01


def test_levels_and_graph(plane: Path, split: tuple[runs.FileSuperpoints, Labels, Tiles]) -> None:
    found, labels, _ = split
    folder = found.labels_file.parent
    levels, graph = np.load(folder / "levels.npz"), np.load(folder / "graph.npz")
    assert levels["counts"].tolist() == [500, 60]
    np.testing.assert_array_equal(levels["labels"][0], labels)
    known = labels >= 0
    pairs = np.unique(levels["labels"][:, known], axis=1)
    assert pairs.shape[1] == 500  # nested: each superpoint lies in one of the next level
    rows, size = np.load(plane)[known], np.bincount(labels[known])
    np.testing.assert_array_equal(graph["size"], size)
    for name, columns in (("center", rows[:, :3]), ("color", rows[:, 3:])):
        mean = np.stack([np.bincount(labels[known], c) for c in columns.T], axis=1) / size[:, None]
        np.testing.assert_allclose(graph[name], mean, rtol=1e-6)
    one, other, _ = near_pairs(rows[:, :3] - [3000, -500, 20])
    a, b = labels[known][one], labels[known][other]
    apart = a != b
    beside = np.sort(np.stack([a, b], axis=1)[apart], axis=1)
    edges, contact = np.unique(beside, axis=0, return_counts=True)
    order = np.lexsort(graph["edges"].T[::-1])
    np.testing.assert_array_equal(graph["edges"][order], edges)
    # Which of two points at the same distance is the eighth nearest, rounding decides.
    assert abs(graph["contact"][order] - contact).sum() < 1e-3 * contact.sum()
    content = json.loads((folder / "superpoints.json").read_text())
    assert content == found.summary()
    assert sorted(file.name for file in folder.iterdir()) == [
        *("graph.npz", "levels.npz", "running.lock", "superpoints.json", "superpoints.npy")
    ]


def _stopping(n: int, seen: list[int], split: Callable[..., Any]) -> Callable[..., Any]:
    def stop(buckets: Any, tile: int, *given: Any) -> Any:
        if len(seen) == n:
            raise KeyboardInterrupt
        seen.append(tile)
        return split(buckets, tile, *given)

    return stop


@pytest.mark.usefixtures("small_tiles")
def test_resume_goes_on_and_ends_alike(
    plane: Path,
    split: tuple[runs.FileSuperpoints, Labels, Tiles],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: list[int] = []
    real = split_tile
    monkeypatch.setattr(runs, "split_tile", _stopping(3, seen, real))
    with pytest.raises(KeyboardInterrupt):
        superpoints_file(plane, tmp_path / "out", count=[500, 60])
    with pytest.raises(
        GeohueError, match=r"has count = \[500, 60\], this one \[30\]; give another"
    ):
        superpoints_file(plane, tmp_path / "out", count=30, resume=True)
    monkeypatch.setattr(runs, "split_tile", _stopping(-1, seen, real))
    found = superpoints_file(plane, tmp_path / "out", count=[500, 60], resume=True, threads=1)
    assert seen == list(range(found.n_tiles))  # none twice
    np.testing.assert_array_equal(np.load(found.labels_file), split[1])


def test_a_width_in_metres(plane: Path, tmp_path: Path) -> None:
    found = superpoints_file(plane, tmp_path / "out", width=0.4)
    assert found.k == pytest.approx(16 / 0.4**2, rel=0.2)


def test_size_and_a_cloud_of_one_colour(tmp_path: Path) -> None:
    rows = _plane(3000)
    rows[:, 3:] = 90
    np.save(tmp_path / "gray.npy", rows)
    found = superpoints_file(tmp_path / "gray.npy", tmp_path / "out", size=100)
    assert (found.k, found.cues) == (30, "geometry")


@pytest.mark.parametrize(
    ("wish", "message"),
    [
        ({}, "nothing given: say either count"),
        ({"count": 5, "size": 3.0}, "count and size given"),
        ({"count": [30, 0]}, "count is 0: expected a whole number"),
        ({"count": 5, "memory": "100MB"}, "memory 100 MB is too little: give at least 700MB"),
        ({"count": 5, "cues": "smell"}, "cues is 'smell'"),
        ({"count": 5, "compactness": -1.0}, "compactness is -1.0"),
    ],
)
def test_mistakes(plane: Path, tmp_path: Path, wish: dict[str, Any], message: str) -> None:
    with pytest.raises(GeohueError, match=message):
        superpoints_file(plane, tmp_path / "out", **wish)
    assert not (tmp_path / "out").exists()


def test_a_graph_beyond_the_memory(
    plane: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(runs, "LEAST", 10**6)
    with pytest.raises(GeohueError, match="too little for so many superpoints: at least"):
        superpoints_file(plane, tmp_path / "out", count=2000, memory="2MB")


def test_no_point_has_a_place(tmp_path: Path) -> None:
    np.save(tmp_path / "none.npy", np.full((40, 6), np.nan))
    with pytest.raises(GeohueError, match="no point has a position"):
        superpoints_file(tmp_path / "none.npy", tmp_path / "out", count=3)


def test_tiles_fill_space_with_as_many_points_each() -> None:
    xyz = np.random.default_rng(2).normal(size=(4000, 3)) * [5, 2, 0.1]
    tiles = Tiles.of(xyz, 300)
    found = tiles.find(xyz)
    assert np.bincount(found, minlength=len(tiles)).min() > 100
    assert np.bincount(found).max() <= 300
    assert ((xyz >= tiles.low[found]) & (xyz < tiles.high[found])).all()
    assert tiles.find(np.array([[np.nan, 0, 0]])).tolist() == [-1]
    assert len(Tiles.of(np.ones((500, 3)), 10)) == 1


def test_crumbs_come_to_the_nearest() -> None:
    region = np.zeros((4, COLUMNS))
    region[:, SIZE] = [50, 60, 2, 3]
    region[:, 10] = region[:, SIZE] * [0, 10, 12, 2]
    regions = Regions(region, np.array([[5.0, 1.0]]), np.array([[0, 1]]))
    ends = with_crumbs(regions, 10).ends
    assert ends.tolist() == [[0, 1], [2, 1], [3, 0]]
    assert with_crumbs(regions, 1) is regions


def _chain(n: int) -> Regions:
    """Regions in a row whose colours differ more and more."""
    region = np.zeros((n, COLUMNS))
    region[:, SIZE] = 1
    region[:, 1] = np.cumsum(np.arange(n) + 1.0)
    region[:, 10] = np.arange(n)
    ends = np.stack([np.arange(n - 1), np.arange(1, n)], axis=1)
    return Regions(region, np.ones((n - 1, 2)), ends)


def test_inside_merges_are_those_of_the_whole_until_an_open_region_is_wanted() -> None:
    weights = merging_weights()
    every, _ = merge_regions(_chain(12), 1.0, weights)
    is_open = np.zeros(12, np.bool_)
    is_open[-1] = True
    inside, alive = merge_inside(_chain(12), 1.0, weights, is_open, 0.0)
    assert 0 < len(inside) < 11
    rest = iter(every.tolist())
    assert all(merge in rest for merge in inside.tolist())  # those, in this order
    assert alive.sum() == 11 - len(inside)
    closed = np.zeros(12, np.bool_)
    some, _ = merge_inside(_chain(12), 1.0, weights, closed, 0.5)
    assert len(some) == 6


@pytest.mark.usefixtures("small_tiles")
def test_command(plane: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    run = CliRunner().invoke(
        app, ["superpoints", str(plane), "--count", "300,30", "--memory", "1GB", "-o", str(out)]
    )
    assert run.exit_code == 0, run.output
    assert "300 superpoints of" in run.output
    assert np.load(out / "superpoints.npy").max() == 299
    for extra, message in (
        (["--format", "ply"], "--format ply writes the whole cloud"),
        (["--intrinsics", "kinect"], "intrinsics has no use for a cloud in pieces"),
    ):
        given = ["superpoints", str(plane), "--count", "30", "--memory", "1GB", *extra]
        run = CliRunner().invoke(app, given)
        assert isinstance(run.exception, GeohueError)
        assert message in str(run.exception)


def test_field_survey(tmp_path: Path) -> None:
    data = Path(os.environ.get("GEOHUE_DATA", "")) / "churo_uav" / "churo_full.laz"
    if not data.is_file():
        pytest.skip("needs GEOHUE_DATA with churo_uav/churo_full.laz")
    from geohue.read.clouds.chunks import open_chunks

    source = open_chunks(data)
    xyz, rgb = source.read(0, 60_000)
    source.close()
    np.save(tmp_path / "part.npy", np.hstack([xyz, rgb]))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(runs, "TILE", 10_000)
        found = superpoints_file(tmp_path / "part.npy", tmp_path / "out", size=300)
    labels = np.load(found.labels_file)
    assert len(np.unique(labels)) == found.k >= 200
    center = np.load(tmp_path / "out" / "graph.npz")["center"]
    near = np.asarray(cKDTree(center).query(xyz, 30)[1])
    assert (near == labels[:, None]).any(axis=1).mean() > 0.95
