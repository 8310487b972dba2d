"""Superpoints: laws of count, connection and nesting, a slow twin of the merging, and files."""

from __future__ import annotations

import json
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from typer.testing import CliRunner

import geohue
from geohue import GeohueError, Scene
from geohue.cli.app import app
from geohue.measures import superpoint_scores
from geohue.regions.groups import connected_groups
from geohue.regions.images import connected_components
from geohue.results.superpoints import write_superpoints
from geohue.results.tensor import write_tensor
from geohue.simulate import scene as simulated
from geohue.superpoint import loops, nested, superpoints
from geohue.superpoint.driver import fine_regions
from geohue.superpoint.nodes import NEIGHBOURS, near_pairs, nodes_of
from geohue.superpoint.ward import COLUMNS, Regions, merge_regions, tabulate
from geohue.superpoint.weights import merging_weights
from twins.superpoint import slow_merges

Labels = NDArray[np.int32]


@pytest.fixture(scope="module")
def frame() -> tuple[Scene, Labels]:
    return simulated("boxes", "kinect")


@pytest.fixture(scope="module")
def cloud(frame: tuple[Scene, Labels]) -> tuple[Scene, Labels]:
    """Some of the frame's points as a cloud, in no order."""
    scene, truth = frame
    some = np.random.default_rng(0).permutation(np.flatnonzero(scene.valid))[:9000]
    points, colors = scene.points.reshape(-1, 3)[some], scene.colors.reshape(-1, 3)[some]
    return Scene.from_cloud(points, colors), truth.reshape(-1)[some]


@pytest.mark.parametrize("count", [30, 200, 1500])
def test_a_frame_falls_into_as_many_connected_parts_as_wanted(
    frame: tuple[Scene, Labels], count: int
) -> None:
    scene, truth = frame
    seg = superpoints(scene, count=count)
    assert seg.k == count == len(np.unique(seg.labels))
    assert seg.labels.min() == 0
    assert connected_components(seg.labels).max() + 1 == count
    sizes = np.bincount(seg.labels.ravel())
    assert (np.diff(sizes) <= 0).all()
    assert superpoint_scores(seg.labels, truth + 1)["achievable_accuracy"] > 0.98


def test_a_cloud_too(cloud: tuple[Scene, Labels]) -> None:
    scene, truth = cloud
    seg = superpoints(scene, count=300)
    assert seg.k == 300
    one, other, _ = near_pairs(scene.points.astype(np.float64))
    assert connected_groups(seg.labels, one, other).max() + 1 == 300
    assert superpoint_scores(seg.labels, truth + 1)["achievable_accuracy"] > 0.95


def test_levels_are_nested(cloud: tuple[Scene, Labels]) -> None:
    seg = superpoints(cloud[0], count=500)
    levels = nested(seg, [500, 120, 30])
    assert levels.dtype == np.int64
    assert [len(np.unique(level)) for level in levels] == [500, 120, 30]
    assert (levels[0] == seg.labels).all()
    for fine, coarse in pairwise(levels):
        assert len(np.unique(fine * 1000 + coarse)) == fine.max() + 1
    with pytest.raises(GeohueError, match="from 1 to 500"):
        nested(seg, [501])
    with pytest.raises(GeohueError, match="no levels"):
        nested(geohue.segment(cloud[0], k=2, preset="paper"), [1])


def test_a_level_is_what_asking_for_it_gives(cloud: tuple[Scene, Labels]) -> None:
    # Both begin with the same fine regions, as these have a largest size.
    fine, coarse = superpoints(cloud[0], count=100), superpoints(cloud[0], count=40)
    assert (nested(fine, [40])[0] == coarse.labels).all()


def test_neither_order_nor_place_nor_threads_matter(cloud: tuple[Scene, Labels]) -> None:
    scene = cloud[0]
    found = superpoints(scene, count=150)
    order = np.random.default_rng(1).permutation(scene.size)
    shuffled = Scene.from_cloud(scene.points[order], scene.colors[order])
    again = superpoints(shuffled, count=150, threads=1).labels
    assert len(np.unique(found.labels[order] * 1000 + again)) == 150
    scaled = Scene.from_cloud(4 * scene.points, scene.colors)
    assert (superpoints(scaled, count=150).labels == found.labels).all()


@pytest.mark.parametrize("cues", ["color", "geometry", "fusion"])
def test_cues_are_what_counts(cues: str) -> None:
    y, x = np.indices((30, 40))
    rgb = np.zeros((30, 40, 3), np.uint8)
    rgb[:, 20:] = 200
    depth = np.where(y < 15, 1.0, 2.0)
    parts = {"color": x >= 20, "geometry": y >= 15, "fusion": 2 * (y >= 15) + (x >= 20)}
    seg = superpoints(Scene.from_rgbd(rgb, depth), count=12, cues=cues)
    scores = superpoint_scores(seg.labels, parts[cues].astype(int), ignore=None)
    assert scores["achievable_accuracy"] == 1


def test_what_there_is_counts_by_itself(cloud: tuple[Scene, Labels]) -> None:
    scene = cloud[0]
    assert superpoints(Scene.from_image(scene.colors[None]), count=4).cues == "color"
    plain = Scene.from_cloud(scene.points, np.full(scene.colors.shape, 90, np.uint8))
    assert superpoints(plain, count=4).cues == "geometry"
    grey = Scene.from_cloud(scene.points, np.repeat(scene.colors[:, :1], 3, axis=1))
    assert superpoints(grey, count=4).cues == "fusion"


def test_size_and_width(frame: tuple[Scene, Labels]) -> None:
    scene, _ = frame
    assert superpoints(scene, size=100).k == scene.size // 100
    y, x = np.mgrid[0:2:80j, 0:1:40j].reshape(2, -1)
    plane = Scene.from_cloud(np.stack([x, y, 0 * x], axis=1), np.zeros((3200, 3), np.uint8))
    assert 0.8 < superpoints(plane, width=0.1).k / 200 < 1.25


def test_compactness_makes_them_rounder(frame: tuple[Scene, Labels]) -> None:
    scene, truth = frame
    ragged, usual, round_ = (
        superpoint_scores(superpoints(scene, 300, compactness=c).labels, truth + 1)["compactness"]
        for c in (0.0, 1.0, 100.0)
    )
    assert ragged < usual < round_


def test_points_in_one_place_and_without_one() -> None:
    points = np.random.default_rng(0).random((400, 3))
    points[200:] = points[:200]
    points[7] = np.nan
    seg = superpoints(Scene.from_cloud(points, np.zeros((400, 3), np.uint8)), count=10)
    assert seg.labels[7] == -1
    assert (seg.labels[200:] == seg.labels[:200])[np.arange(200) != 7].all()
    assert seg.k == 10


def test_pieces_that_lie_apart_stay_apart_and_crumbs_do_not() -> None:
    rng = np.random.default_rng(0)
    pieces = [rng.random((300, 3)) + np.array([20.0 * i, 0, 0]) for i in range(3)]
    crumb = rng.random((4, 3)) + np.array([30, 5, 0])
    scene = Scene.from_cloud(np.concatenate([*pieces, crumb]), np.zeros((904, 3), np.uint8))
    seg = superpoints(scene, count=1)
    assert seg.k == 3
    assert seg.warnings[-1].startswith("3 superpoints instead of 1")
    assert len(np.unique(seg.labels[900:])) == 1
    assert seg.labels[900] == seg.labels[400] or seg.labels[900] == seg.labels[700]


@pytest.mark.parametrize(
    ("wish", "message"),
    [
        ({}, "nothing given"),
        ({"count": 3, "size": 2.0}, "count and size given"),
        ({"count": 0}, "count is 0"),
        ({"count": 2.5}, "count is 2.5"),
        ({"size": 0.5}, "size is 0.5"),
        ({"width": -1.0}, "width is -1.0"),
        ({"width": float("nan")}, "width is nan"),
        ({"count": 2, "cues": "smell"}, "cues is 'smell'"),
        ({"count": 2, "compactness": -1}, "compactness is -1"),
    ],
)
def test_mistakes_are_named(wish: dict[str, float], message: str) -> None:
    scene = Scene.from_cloud(np.eye(3), np.zeros((3, 3), np.uint8))
    with pytest.raises(GeohueError, match=message):
        superpoints(scene, **wish)  # type: ignore[arg-type]


def test_a_scene_without_points() -> None:
    nowhere = Scene.from_cloud(np.full((3, 3), np.nan), np.zeros((3, 3), np.uint8))
    with pytest.raises(GeohueError, match="no point has a position"):
        superpoints(nowhere, count=1)
    image = Scene.from_image(np.zeros((3, 3, 3), np.uint8))
    with pytest.raises(GeohueError, match="colour alone"):
        superpoints(image, count=1, cues="geometry")


def joined(n: int, merges: Sequence[Sequence[int]]) -> list[frozenset[int]]:
    """The members of what each merge made."""
    members = [frozenset([i]) for i in range(n)]
    made = []
    for one, other in merges:
        members[one] = members[other] = members[one] | members[other]
        made.append(members[one])
    return made


@given(seed=st.integers(0, 99))
@settings(max_examples=15, deadline=None)
def test_merging_is_that_of_a_slow_twin(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = 25
    region = rng.random((n, COLUMNS)) * 3
    region[:, 0] = rng.integers(1, 6, n)
    pairs = np.array([(i, j) for i in range(n) for j in range(i + 1, n) if rng.random() < 0.2])
    border = np.stack([rng.integers(1, 5, len(pairs)), rng.random(len(pairs))], axis=1)
    weights = merging_weights(2.0)
    expected = slow_merges(region, border, pairs, 0.7, weights)
    merges, costs = merge_regions(
        Regions(region.copy(), border.astype(np.float64), pairs.copy()), 0.7, weights
    )
    assert joined(n, merges.tolist()) == joined(n, [pair for pair, _ in expected])
    assert costs == pytest.approx([cost for _, cost in expected])


def test_tables_add_up(cloud: tuple[Scene, Labels]) -> None:
    nodes = nodes_of(cloud[0], "fusion")
    fine, n, step = fine_regions(nodes, 200)
    assert np.bincount(fine).max() <= 9000 / 200
    here = nodes.points, nodes.lab, nodes.normals, nodes.weight, nodes.one, nodes.other
    table = tabulate(fine, n, *here, step)
    assert table.region[:, 0].tolist() == np.bincount(fine).tolist()
    assert table.region[:, 1:4].sum(axis=0) == pytest.approx(nodes.lab.sum(axis=0))
    traces = table.region[:, [4, 7, 9]].sum(axis=1)
    assert traces == pytest.approx(table.region[:, 0])
    apart = fine[nodes.one] != fine[nodes.other]
    assert table.border[:, 0].sum() == apart.sum()
    assert table.border[:, 1].sum() == pytest.approx(step[apart].sum())
    assert (table.ends[:, 0] < table.ends[:, 1]).all()


@given(seed=st.integers(0, 99))
@settings(max_examples=10, deadline=None)
def test_pairs_are_each_point_with_its_nearest(seed: int) -> None:
    points = np.random.default_rng(seed).random((60, 3))
    one, other, _ = near_pairs(points)
    near = np.asarray(cKDTree(points).query(points, NEIGHBOURS + 1)[1])
    slow = {tuple(sorted((i, int(j)))) for i in range(60) for j in near[i, 1:]}
    found = list(zip(np.minimum(one, other).tolist(), np.maximum(one, other).tolist(), strict=True))
    assert set(found) <= slow
    assert len(found) == len(set(found))
    length = {pair: float(np.linalg.norm(points[pair[0]] - points[pair[1]])) for pair in slow}
    left = slow - set(found)
    assert all(length[pair] > max(length[p] for p in found) * 0.99 for pair in left)


def test_the_curve_keeps_near_points_near() -> None:
    grid = np.stack(np.meshgrid(*[np.arange(8.0)] * 3), axis=-1).reshape(-1, 3)
    along = grid[np.argsort(loops.curve(grid))]
    assert np.abs(np.diff(along, axis=0)).sum(axis=1).mean() < 2.5


def test_normals_of_a_plane_and_neighbour_lists() -> None:
    rng = np.random.default_rng(0)
    plane = np.c_[rng.random((500, 2)), np.zeros(500)]
    nodes = nodes_of(Scene.from_cloud(plane, np.zeros((500, 3), np.uint8)), "geometry")
    assert np.abs(nodes.normals[:, 2]) == pytest.approx(1)
    start, beside = loops.csr(np.array([0, 1]), np.array([1, 2]), 4)
    lists = [beside[start[i] : start[i + 1]].tolist() for i in range(4)]
    assert lists == [[1], [0, 2], [1], []]


def test_files(cloud: tuple[Scene, Labels], tmp_path: Path) -> None:
    seg = superpoints(cloud[0], count=80)
    files = write_superpoints(tmp_path, seg, [20], ["ply"])
    assert {file.name for file in files} == {file.name for file in tmp_path.iterdir()}
    ids = np.load(tmp_path / "superpoints.npy")
    assert ids.dtype == np.int64
    assert (ids == seg.labels).all()
    levels = np.load(tmp_path / "levels.npz")
    assert levels["counts"].tolist() == [80, 20]
    assert levels["labels"].shape == (2, 9000)
    graph = np.load(tmp_path / "graph.npz")
    assert graph["size"].tolist() == np.bincount(ids).tolist()
    assert graph["edges"].max() < 80
    assert graph["center"][3] == pytest.approx(cloud[0].points[ids == 3].mean(axis=0), abs=1e-4)
    with pytest.raises(GeohueError, match="format 'gif'"):
        write_superpoints(tmp_path, seg, formats=["gif"])
    image = superpoints(Scene.from_image(np.zeros((9, 9, 3), np.uint8)), count=2)
    with pytest.raises(GeohueError, match="needs geometry"):
        write_superpoints(tmp_path, image, formats=["las"])


@pytest.mark.parametrize("dtype", [np.int64, np.int32, np.uint8, np.float32, np.float64, bool])
def test_tensors_are_read_by_torch(tmp_path: Path, dtype: type) -> None:
    torch = pytest.importorskip("torch")
    array: NDArray[Any] = (np.arange(12).reshape(2, 1, 6) % 2).astype(dtype)
    write_tensor(tmp_path / "a.pth", array)
    found = torch.load(tmp_path / "a.pth", weights_only=True)
    assert found.shape == (2, 1, 6)
    assert (found.numpy() == array).all()
    assert found.numpy().dtype == array.dtype


def test_only_some_numbers_become_tensors(tmp_path: Path) -> None:
    with pytest.raises(GeohueError, match="complex128"):
        write_tensor(tmp_path / "a.pth", np.zeros(2, complex))


def test_command(tmp_path: Path) -> None:
    run = CliRunner().invoke
    args = ["superpoints", "--sample", "boxes", "-o", str(tmp_path), "--json"]
    done = run(app, [*args, "--count", "20,200"])
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["k"] == 200
    assert np.load(tmp_path / "levels.npz")["counts"].tolist() == [200, 20]
    for wrong in ([], ["--count", "x"], ["--count", "3", "--size", "3"]):
        assert isinstance(run(app, [*args, *wrong]).exception, GeohueError)


def test_command_takes_a_folder_of_clouds(cloud: tuple[Scene, Labels], tmp_path: Path) -> None:
    from geohue.results.ply import write_ply

    scene, truth = cloud
    for name in ("a", "b"):
        write_ply(tmp_path / "in" / f"{name}.ply", scene.points, scene.colors, truth)
    out = tmp_path / "out"
    done = CliRunner().invoke(
        app, ["superpoints", str(tmp_path / "in"), "--size", "90", "-o", str(out)]
    )
    assert done.exit_code == 0, done.output
    assert "a: 100 superpoints" in done.output
    first = np.load(out / "a" / "superpoints.npy")
    assert (first == np.load(out / "b" / "superpoints.npy")).all()


@pytest.mark.parametrize(("width", "k"), [(1e-300, 60), (1e300, 1)])
def test_a_width_whose_square_is_no_number(width: float, k: int) -> None:
    scene = Scene.from_rgbd(np.zeros((6, 10, 3), np.uint8), np.ones((6, 10)))
    assert superpoints(scene, width=width).k == k


def test_points_too_far_apart_for_squares_in_float32_have_neighbours() -> None:
    points = np.random.default_rng(0).normal(0, 1e25, (60, 3))
    seg = superpoints(Scene.from_cloud(points, np.zeros((60, 3), np.uint8)), count=5)
    assert seg.neighbours.n_segments == 5
    assert seg.neighbours.contact.sum() > 0
