"""What ``--formats`` writes: round trips, and other libraries as second opinion."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from pypcd4.pypcd4 import PointCloud

from geohue import GeohueError, Scene, segment
from geohue.read import read_cloud, read_color
from geohue.results.coco import coco, encode_rle
from geohue.results.outputs import FORMATS, write_results
from geohue.results.pcd import write_pcd
from geohue.results.picture import palette

# pycocotools 2.0 has not followed NumPy 2 in every place.
pytestmark = pytest.mark.filterwarnings("ignore:__array__ implementation:DeprecationWarning")

RELAXED = settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


@RELAXED
@given(
    height=st.integers(1, 30), width=st.integers(1, 30), seed=st.integers(0, 999), p=st.floats(0, 1)
)
def test_rle_is_that_of_pycocotools(height: int, width: int, seed: int, p: float) -> None:
    mask_api = pytest.importorskip("pycocotools.mask", reason="needs pycocotools")
    mask = np.random.default_rng(seed).random((height, width)) < p
    theirs = mask_api.encode(np.asfortranarray(mask.astype(np.uint8)))
    ours = encode_rle(mask)
    assert ours == theirs["counts"].decode()
    back = mask_api.decode({"size": [height, width], "counts": ours.encode()})
    assert np.array_equal(back.astype(bool), mask)


def test_rle_of_long_runs() -> None:
    mask_api = pytest.importorskip("pycocotools.mask", reason="needs pycocotools")
    mask = np.zeros((480, 640), bool)
    mask[100:400, 37:601] = True
    theirs = mask_api.encode(np.asfortranarray(mask.astype(np.uint8)))
    assert encode_rle(mask) == theirs["counts"].decode()


def test_coco_file_is_read_by_pycocotools(tmp_path: Path) -> None:
    library = pytest.importorskip("pycocotools.coco", reason="needs pycocotools")
    labels = np.array([[0, 0, 1], [-1, 2, 1]], np.int32)
    file = tmp_path / "coco.json"
    file.write_text(json.dumps(coco(labels)))
    data = library.COCO(str(file))
    found = data.loadAnns(data.getAnnIds(imgIds=[1]))
    assert [a["id"] for a in found] == [1, 2, 3]
    for annotation in found:
        mask = data.annToMask(annotation).astype(bool)
        assert np.array_equal(mask, labels == annotation["id"] - 1)
        assert annotation["area"] == mask.sum()
    assert found[1]["bbox"] == [2, 0, 1, 2]


@RELAXED
@given(
    shape=st.one_of(st.tuples(st.integers(1, 60)), st.tuples(st.integers(2, 9), st.integers(1, 9))),
    seed=st.integers(0, 999),
)
def test_pcd_is_lossless(tmp_path: Path, shape: tuple[int, ...], seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(0, 5, (*shape, 3)).astype(np.float32)
    points.reshape(-1, 3)[1::7] = np.nan
    colors = rng.integers(0, 256, (*shape, 3)).astype(np.uint8)
    labels = rng.integers(-1, 400, shape).astype(np.int32)
    file = tmp_path / "cloud.pcd"
    write_pcd(file, points, colors, labels)
    again = read_cloud(file)
    assert np.array_equal(again.points, points, equal_nan=True)
    assert again.colors is not None
    assert np.array_equal(again.colors, colors)
    assert again.labels is not None
    assert np.array_equal(again.labels, labels)
    other = PointCloud.from_path(file)  # the independent reader
    assert np.array_equal(other.numpy(("x", "y", "z")), points.reshape(-1, 3), equal_nan=True)
    assert np.array_equal(other.pc_data["label"].ravel(), labels.ravel())
    packed = other.pc_data["rgb"].ravel().astype(np.uint32)
    assert np.array_equal(packed >> 16 & 255, colors.reshape(-1, 3)[:, 0])


@pytest.fixture
def grid(three_boxes: tuple[Scene, NDArray[np.int32]]) -> Scene:
    return three_boxes[0]


def test_all_formats_of_a_grid(tmp_path: Path, grid: Scene) -> None:
    pytest.importorskip("laspy", reason="needs geohue[clouds]")
    pytest.importorskip("lazrs", reason="needs geohue[clouds]")
    seg = segment(grid, k=3, preset="fast")
    files = write_results(tmp_path, grid, seg, FORMATS)
    names = [file.name for file in files]
    assert names[-1] == "result.json"
    assert {"segmented.pcd", "segmented.las", "segmented.laz", "coco.json"} < set(names)
    assert all(file.stat().st_size for file in files)
    painted = read_color(tmp_path / "segments.png")
    assert np.array_equal(painted, palette(seg.k)[seg.labels])
    organised = read_cloud(tmp_path / "segmented.pcd")
    assert organised.points.shape == (*grid.shape, 3)
    for name in ("segmented.las", "segmented.laz"):
        cloud = read_cloud(tmp_path / name)
        assert cloud.labels is not None
        assert np.array_equal(cloud.labels, seg.labels.ravel())
        assert cloud.colors is not None
        assert np.array_equal(cloud.colors, grid.colors.reshape(-1, 3))


def test_ply_can_be_asked_for(tmp_path: Path, grid: Scene) -> None:
    seg = segment(grid, k=3, preset="fast")
    usual = write_results(tmp_path / "usual", grid, seg, ["ply"])
    assert [file.name for file in usual].count("segmented.ply") == 1
    lean = write_results(tmp_path / "lean", grid, seg, ["ply"], lean=True)
    assert [file.name for file in lean] == ["labels.png", "segmented.ply", "result.json"]
    written = [
        (folder / "segmented.ply").read_bytes() for folder in (lean[0].parent, tmp_path / "usual")
    ]
    assert written[0] == written[1]


def test_ply_opens_in_trimesh_with_colours(tmp_path: Path, grid: Scene) -> None:
    import trimesh

    seg = segment(grid, k=3, preset="fast")
    write_results(tmp_path, grid, seg)
    other: Any = trimesh.load(tmp_path / "segmented.ply")
    assert np.allclose(other.vertices, grid.points.reshape(-1, 3))
    assert np.array_equal(other.colors[:, :3], grid.colors.reshape(-1, 3))


def test_points_in_nobodys_view_are_written_too(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    scene = Scene(
        rng.integers(0, 256, (60, 3)).astype(np.uint8),
        rng.random((60, 3)).astype(np.float32),
        unseen=np.arange(60) >= 50,
    )
    write_results(tmp_path, scene, segment(scene, k=2, preset="fast"), ["pcd"])
    for name in ("segmented.ply", "segmented.pcd"):
        assert read_cloud(tmp_path / name).points.shape == (60, 3)


def test_refuses_before_anything_is_written(
    tmp_path: Path, grid: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    import sys

    seg = segment(grid, k=3, preset="fast")
    cloud = Scene.from_cloud(grid.points.reshape(-1, 3), grid.colors.reshape(-1, 3))
    flat = segment(cloud, k=3, preset="fast")
    monkeypatch.setitem(sys.modules, "laspy", None)
    for scene, result, name, cause in (
        (grid, seg, "obj", "choose among ply, pcd"),
        (cloud, flat, "coco", "needs a grid"),
        (Scene.from_image(grid.colors), seg, "pcd", "needs geometry"),
        (grid, seg, "las", "needs laspy"),
    ):
        with pytest.raises(GeohueError, match=cause):
            write_results(tmp_path / "out", scene, result, [name])
    assert not (tmp_path / "out").exists()
