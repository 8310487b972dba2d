"""Measures of segments: worked by hand, against a slow twin, and laws."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from typer.testing import CliRunner

from geohue import GeohueError, Intrinsics, Scene, segment
from geohue.cli.app import app
from geohue.objects import Measured, Segments
from geohue.objects.segments import table
from geohue.results.objects import features, outlines, write_features, write_table

Floats = NDArray[np.float64]


def cloud(points: Floats, seed: int = 0) -> Scene:
    colors = np.random.default_rng(seed).integers(0, 256, points.shape, np.uint8)
    return Scene.from_cloud(points, colors)


def turn(seed: int) -> Floats:
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return np.asarray(q * np.sign(np.linalg.det(q)))


@pytest.fixture(scope="module")
def frame() -> tuple[Scene, NDArray[np.int32]]:
    """A wall 2 m away, and a plate 1 m away in the middle of it; no depth in one corner."""
    rgb = np.full((40, 60, 3), 100, np.uint8)
    depth = np.full((40, 60), 2.0)
    labels = np.zeros((40, 60), np.int32)
    rgb[10:20, 20:40], depth[10:20, 20:40], labels[10:20, 20:40] = (200, 50, 0), 1.0, 1
    depth[:5, :5] = np.nan
    return Scene.from_rgbd(rgb, depth, Intrinsics(50, 50, 29.5, 19.5, 60, 40)), labels


def test_a_plate_before_a_wall(frame: tuple[Scene, NDArray[np.int32]]) -> None:
    plate = Segments(Measured(*frame))[1]
    assert (plate.area, plate.frame_box) == (200, (10, 20, 19, 39))
    assert plate.color.tolist() == [200, 50, 0]
    assert plate.centroid == pytest.approx([0.0, -0.1, 1.0])
    assert plate.box == pytest.approx(np.array([[-0.19, -0.19, 1], [0.19, -0.01, 1]]))
    normal, offset = plate.plane
    assert normal == pytest.approx([0, 0, -1])
    assert offset == pytest.approx(-1)
    assert plate.plane_residual == pytest.approx(0, abs=1e-7)
    center, size, axes = plate.oriented_box
    assert center == pytest.approx([0.0, -0.1, 1.0])
    assert size == pytest.approx([0.38, 0.18, 0], abs=1e-6)
    assert np.abs(axes[0]) == pytest.approx([1, 0, 0], abs=1e-6)
    assert plate.neighbours == {0: 60}
    assert plate.mask.sum() == len(plate.indices) == len(plate.points) == 200
    assert plate.stands_free
    assert not plate.touches_edge


def test_the_wall_behind_it_has_a_gap_and_is_cut_off(
    frame: tuple[Scene, NDArray[np.int32]],
) -> None:
    segments = Segments(Measured(*frame))
    wall = segments[-2]
    assert wall.touches_edge
    assert not wall.stands_free
    assert len(wall.points) == wall.area - 25
    assert segments.measured.neighbours.contact.tolist() == [0]


def test_what_touches_in_space_does_not_stand_free() -> None:
    scene = Scene.from_rgbd(np.zeros((9, 9, 3), np.uint8), np.ones((9, 9)))
    labels = np.zeros((9, 9), np.int32)
    labels[3:6, 3:6] = 1
    middle = Segments(Measured(scene, labels))[1]
    assert (middle.stands_free, middle.touches_edge) == (False, False)


@given(seed=st.integers(0, 99), sides=st.tuples(*[st.floats(0.2, 3.0)] * 3))
@settings(max_examples=15, deadline=None)
def test_the_box_of_a_turned_block_is_the_block(
    seed: int, sides: tuple[float, float, float]
) -> None:
    long, wide, thick = sorted(sides, reverse=True)
    grid = np.stack(np.meshgrid(*[np.linspace(-0.5, 0.5, 7)] * 3), axis=-1).reshape(-1, 3)
    block = grid * [long, wide, thick * 0.1]
    points = block @ turn(seed) + 5
    boxes = Measured(cloud(points), np.zeros(len(points), np.int32)).boxes
    assert boxes.volume[0] <= 1.05 * long * wide * thick * 0.1
    away = (points - boxes.center[0]) @ boxes.axes[0].T
    assert (np.abs(away) <= boxes.size[0] / 2 + 1e-5).all()
    assert np.linalg.det(boxes.axes[0]) == pytest.approx(1)
    assert boxes.size[0, 0] >= boxes.size[0, 1]
    far = np.abs((boxes.corners[0] - boxes.center[0]) @ boxes.axes[0].T)
    assert far == pytest.approx(np.broadcast_to(boxes.size[0] / 2, (8, 3)))


@given(seed=st.integers(0, 99))
@settings(max_examples=10, deadline=None)
def test_planes_are_those_of_a_singular_value_decomposition(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(300, 3)) * [2, 1, 0.1] @ turn(seed) + 100 * (seed % 3)
    labels = rng.integers(-1, 4, 300).astype(np.int32)
    scene = cloud(points)
    planes = Measured(scene, labels, 5).planes
    for k in range(4):
        own = scene.points[labels == k].astype(np.float64)
        _, s, vt = np.linalg.svd(own - own.mean(axis=0))
        assert planes.spread[k] == pytest.approx(s / np.sqrt(len(own)), rel=1e-4)
        assert abs(vt[2] @ planes.normal[k]) == pytest.approx(1, abs=1e-4)
    assert np.isnan(planes.normal[4]).all()  # a segment without points has no plane
    assert np.isnan(planes.residual[4])


def test_a_quadric_fits_a_bowl_and_tells_its_curvature() -> None:
    y, x = np.mgrid[-1:1:41j, -1:1:41j].reshape(2, -1)
    points = np.stack([x, y, 0.5 * x**2 / 4 + 0.5 * y**2 / 2], axis=1)
    found = Segments(Measured(cloud(points @ turn(3)), np.zeros(len(x), np.int32)))[0]
    assert found.plane_residual > 0.05
    assert found.quadric_residual < 1e-5
    assert np.abs(found.curvatures) == pytest.approx([1 / 2, 1 / 4], rel=1e-3)
    assert found.curvatures[0] * found.curvatures[1] > 0
    u, v, w = ((found.points - found.centroid) @ found.plane_axes.T).T
    c = found.quadric
    assert w == pytest.approx(
        c[0] + c[1] * u + c[2] * v + c[3] * u**2 + c[4] * u * v + c[5] * v**2, abs=1e-5
    )


def test_a_convex_and_a_concave_edge() -> None:
    y, x = np.mgrid[0:1:30j, 0:1:30j].reshape(2, -1)
    top = np.stack([x, y, 1 + 0 * x], axis=1)
    side = np.stack([1 + 0 * x, y, x], axis=1)
    floor = np.stack([1 + x, y, 0 * x], axis=1)
    points = np.concatenate([top, side, floor])
    normals = np.eye(3)[[2, 0, 2]].repeat(len(x), axis=0)
    scene = Scene.from_cloud(points, np.zeros(points.shape, np.uint8), normals)
    graph = Measured(scene, np.repeat(np.arange(3, dtype=np.int32), len(x))).neighbours
    edge = {tuple(pair): i for i, pair in enumerate(graph.pairs.tolist())}
    assert graph.convexity[edge[0, 1]] > 0.5  # the edge of the block
    assert graph.convexity[edge[1, 2]] < -0.5  # the block on the floor
    assert graph.normal_angle[edge[0, 1]] == pytest.approx(90, abs=0.1)
    assert graph.edge_index().shape == (2, 2 * len(graph.pairs))
    assert graph.degree().sum() == 2 * len(graph.pairs)


def test_borders_are_those_of_a_slow_count() -> None:
    labels = np.random.default_rng(1).integers(-1, 5, (20, 30)).astype(np.int32)
    scene = Scene.from_image(np.zeros((20, 30, 3), np.uint8))
    slow: dict[tuple[int, int], int] = {}
    for y in range(20):
        for x in range(30):
            for v, u in ((y, x + 1), (y + 1, x)):
                if v < 20 and u < 30:
                    a, b = sorted((int(labels[y, x]), int(labels[v, u])))
                    if a >= 0 and a != b:
                        slow[a, b] = slow.get((a, b), 0) + 1
    graph = Measured(scene, labels).neighbours
    assert dict(zip(map(tuple, graph.pairs.tolist()), graph.length.tolist(), strict=True)) == slow
    assert graph.contact.sum() == 0
    networkx = pytest.importorskip("networkx")
    assert isinstance(graph.to_networkx(), networkx.Graph)
    assert graph.to_networkx().number_of_edges() == len(slow)


@given(seed=st.integers(0, 999))
@settings(max_examples=30, deadline=None)
def test_outlines_hold_the_mask(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mask = rng.random((9, 11)) < rng.uniform(0.2, 0.9)
    mask[4, 5] = True
    area = 0.0
    drawn = np.zeros((90, 110), np.uint8)
    for polygon in outlines(mask):
        for ring, sign in zip(polygon, [1, *[-1] * len(polygon)], strict=False):
            assert ring[0] == ring[-1]
            a = np.array(ring, float)
            area += sign * abs((a[:-1, 0] * a[1:, 1] - a[1:, 0] * a[:-1, 1]).sum()) / 2
        cv2.fillPoly(drawn, [np.array(ring) * 10 for ring in polygon], 1)
    assert area == mask.sum()
    assert (drawn[5::10, 5::10] == mask).all()


def test_picking(frame: tuple[Scene, NDArray[np.int32]]) -> None:
    segments = Segments(Measured(*frame))
    picked = segments.at(25, 15)
    assert picked is not None
    assert picked.id == 1
    assert segments.near([0.0, 0.0, 0.5]).id == 1
    assert segments.near([0.5, 0.5, 3.0]).id == 0
    with pytest.raises(GeohueError, match="outside of the image, 60 x 40"):
        segments.at(60, 0)
    with pytest.raises(GeohueError, match="three finite numbers"):
        segments.near([0, 0])
    bare = Segments(Measured(cloud(np.eye(3)), np.zeros(3, np.int32)))
    with pytest.raises(GeohueError, match="near"):
        bare.at(0, 0)


def test_points_without_a_label_are_not_picked() -> None:
    scene = cloud(np.array([[0.0, 0, 0], [1, 0, 0]]))
    assert Segments(Measured(scene, np.array([-1, 0], np.int32))).near([0, 0, 0]).id == 0
    with pytest.raises(GeohueError, match="no labelled point"):
        Segments(Measured(scene, np.array([-1, -1], np.int32), 1)).near([0, 0, 0])


def test_files(frame: tuple[Scene, NDArray[np.int32]], tmp_path: Path) -> None:
    segments = Segments(Measured(*frame))
    write_table(tmp_path / "objects.csv", segments)
    write_features(tmp_path / "objects.json", segments)
    rows = list(csv.DictReader((tmp_path / "objects.csv").read_text().splitlines()))
    columns = table(segments)
    assert list(rows[0]) == list(columns)
    assert [int(row["area"]) for row in rows] == columns["area"].tolist() == [2200, 200]
    found = json.loads((tmp_path / "objects.json").read_text())
    plate = found["features"][1]
    assert plate["properties"]["borders"] == [{"segment": 0, "length": 60}]
    assert plate["bbox"] == pytest.approx([-0.19, -0.19, 1, 0.19, -0.01, 1])
    outer = plate["geometry"]["coordinates"][0][0]
    assert sorted(map(tuple, outer[:-1])) == [(20, 10), (20, 20), (40, 10), (40, 20)]
    nowhere = Scene.from_image(np.zeros((2, 2, 3), np.uint8))
    unknown = features(Segments(Measured(nowhere, np.zeros((2, 2), np.int32))))["features"][0]
    assert "bbox" not in unknown
    assert unknown["properties"]["x"] is None


def test_map_coordinates_stay() -> None:
    place = np.array([5e5, 5.4e6, 300.0])
    rng = np.random.default_rng(0)
    points = rng.random((200, 3)) + place
    labels = (points[:, 0] > place[0] + 0.5).astype(np.int32)
    scene = Scene.from_cloud(points, np.zeros((200, 3), np.uint8))
    segments = Segments(Measured(scene, labels))
    own = points[labels == 1]
    assert segments[1].centroid == pytest.approx(own.mean(axis=0), abs=1e-4)
    assert segments[1].box == pytest.approx(np.stack([own.min(axis=0), own.max(axis=0)]), abs=1e-4)
    assert segments[1].points == pytest.approx(own, abs=1e-4)
    assert segments.near(own[0]).id == 1
    assert table(segments)["low_y"][1] == pytest.approx(own[:, 1].min(), abs=1e-4)
    normal, offset = segments[1].plane
    assert abs(normal @ segments[1].oriented_box[0] - offset) < 1
    assert segments[1].corners.mean(axis=0) == pytest.approx(segments[1].oriented_box[0])


def test_segmentation_has_its_objects(three_boxes: tuple[Scene, NDArray[np.int32]]) -> None:
    scene, _ = three_boxes
    seg = segment(scene)
    assert len(seg.segments) == seg.k
    assert seg.segments is seg.segments
    assert seg.segments[0].area == (seg.labels == 0).sum()
    picked = seg.at(5, 5)
    assert picked is not None
    assert picked.id == seg.labels[5, 5] == seg.near(scene.points[5, 5]).id
    assert seg.neighbours.n_segments == len(seg.table()["id"]) == seg.k
    assert repr(seg.segments[0]).startswith("<Segment 0: area")


def test_command_writes_objects(tmp_path: Path) -> None:
    args = ["segment", "--sample", "boxes", "--preset", "fast", "-o", str(tmp_path), "--objects"]
    done = CliRunner().invoke(app, args)
    assert done.exit_code == 0, done.output
    assert "objects.csv" in done.output
    assert json.loads((tmp_path / "objects.json").read_text())["type"] == "FeatureCollection"
