"""Things of other libraries: there and back, with the real ones where they are installed."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import geohue
from geohue import GeohueError, Intrinsics, Scene, as_scene, labelled
from geohue.interop import napari, rerun
from geohue.interop.ros import cloud_fields
from geohue.results.outputs import write_results
from geohue.results.picture import paint

POINTS = np.random.default_rng(0).random((20, 3))
COLORS = np.random.default_rng(1).integers(2, 256, (20, 3), np.uint8)
LABELS = (np.arange(20) % 3 - 1).astype(np.int32)


def check(thing: Any) -> Scene:
    """Read a thing that holds `POINTS` and `COLORS`."""
    scene = as_scene(thing)
    assert scene.points == pytest.approx(POINTS, abs=1e-6)
    assert (scene.colors == COLORS).all()
    return scene


def test_arrays() -> None:
    for colors in (COLORS.astype(float), COLORS / 255):
        check(np.hstack([POINTS, colors]))
    normals = np.eye(3)[np.zeros(20, int)]
    scene = check(np.hstack([POINTS, COLORS / 255, normals]))
    assert scene.normals is not None
    assert (scene.normals == normals).all()
    assert (as_scene(POINTS).colors == 128).all()
    assert labelled(POINTS, LABELS) is not None
    assert (labelled(POINTS, LABELS) == LABELS).all()
    assert as_scene(scene) is scene


def test_an_image_with_its_depth() -> None:
    rgb = np.zeros((4, 6, 3), np.uint8)
    camera = SimpleNamespace(k=[5.0, 0, 2.5, 0, 5, 1.5, 0, 0, 1], width=6, height=4)
    scene = as_scene(rgb, np.full((4, 6), 1500, np.uint16), camera, depth_scale=0.001)
    assert scene.depth is not None
    assert scene.depth[0, 0] == pytest.approx(1.5)
    assert scene.intrinsics == Intrinsics(5, 5, 2.5, 1.5, 6, 4)
    assert as_scene(rgb, np.ones((4, 6)), np.diag([7.0, 7, 1])).intrinsics.fx == 7  # type: ignore[union-attr]
    labels = np.zeros((4, 6), np.int32)
    assert labelled(rgb, labels).shape == (4, 6)
    with pytest.raises(GeohueError, match=r"labels have shape \(4, 6\)"):
        labelled(rgb[:2], labels)


def test_a_segmentation_gives_its_labels(three_boxes: tuple[Scene, NDArray[np.int32]]) -> None:
    scene = three_boxes[0]
    rows = np.hstack([scene.points.reshape(-1, 3)[::5], scene.colors.reshape(-1, 3)[::5]])
    seg = geohue.segment(as_scene(rows.astype(float)), k=3, preset="paper")
    assert (labelled(rows, seg) == seg.labels).all()


def test_trimesh() -> None:
    trimesh = pytest.importorskip("trimesh")
    cloud = trimesh.PointCloud(POINTS, COLORS)
    check(cloud)
    made = labelled(cloud, LABELS)
    assert isinstance(made, trimesh.PointCloud)
    assert (made.metadata["segment"] == LABELS).all()
    assert (np.asarray(made.colors)[:, :3] == paint(LABELS)).all()
    assert (np.asarray(cloud.colors)[:, :3] == COLORS).all()
    mesh = trimesh.Trimesh(POINTS[:3], [[0, 1, 2]], vertex_colors=COLORS[:3], process=False)
    assert (as_scene(mesh).colors == COLORS[:3]).all()
    assert (
        np.asarray(labelled(mesh, LABELS[:3]).visual.vertex_colors)[:, :3] == paint(LABELS[:3])
    ).all()


@pytest.mark.parametrize("wide", [True, False])
def test_laspy(wide: bool) -> None:
    laspy = pytest.importorskip("laspy")
    header = laspy.LasHeader(point_format=7, version="1.4")
    header.scales = np.full(3, 1e-8)
    cloud = laspy.LasData(header)
    cloud.x, cloud.y, cloud.z = POINTS.T
    factor = 257 if wide else 1
    cloud.red, cloud.green, cloud.blue = (COLORS.astype(np.uint16) * factor).T
    check(cloud)
    made = labelled(cloud, LABELS)
    assert (np.asarray(made["segment"]) == LABELS).all()
    assert "segment" not in set(cloud.point_format.dimension_names)
    assert (np.asarray(labelled(made, -LABELS)["segment"]) == -LABELS).all()


def test_open3d() -> None:
    o3d = pytest.importorskip("open3d")
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(POINTS))
    assert (as_scene(cloud).colors == 128).all()
    cloud.colors = o3d.utility.Vector3dVector(COLORS / 255)
    check(cloud)
    made = labelled(cloud, LABELS)
    assert (np.asarray(made.colors) * 255).round() == pytest.approx(paint(LABELS))
    assert (np.asarray(cloud.colors) * 255).round() == pytest.approx(COLORS)
    tensors = o3d.t.geometry.PointCloud.from_legacy(cloud)
    check(tensors)
    assert (labelled(tensors, LABELS).point["segment"].numpy()[:, 0] == LABELS).all()
    color = o3d.geometry.Image(np.full((4, 6, 3), 9, np.uint8))
    depth = o3d.geometry.Image(np.full((4, 6), 2000, np.uint16))
    frame = o3d.geometry.RGBDImage.create_from_color_and_depth(
        color, depth, convert_rgb_to_intensity=False
    )
    camera = o3d.camera.PinholeCameraIntrinsic(6, 4, 5.0, 5.0, 2.5, 1.5)
    scene = as_scene(frame, intrinsics=camera)
    assert scene.depth is not None
    assert scene.depth[0, 0] == pytest.approx(2)
    assert scene.intrinsics == Intrinsics(5, 5, 2.5, 1.5, 6, 4)
    assert labelled(frame, np.zeros((4, 6), np.int32)).shape == (4, 6)


def test_pyvista() -> None:
    pyvista = pytest.importorskip("pyvista")
    cloud = pyvista.PolyData(POINTS)
    assert (as_scene(cloud).colors == 128).all()
    cloud["RGB"] = COLORS
    check(cloud)
    made = labelled(cloud, LABELS)
    assert (made.point_data["segment"] == LABELS).all()
    assert "segment" not in cloud.point_data


def test_torch() -> None:
    torch = pytest.importorskip("torch")
    rows = torch.tensor(np.hstack([POINTS, COLORS / 255]), requires_grad=True)
    check(rows)
    made = labelled(rows, LABELS)
    assert made.dtype == torch.int32
    assert (made.numpy() == LABELS).all()
    frame = as_scene(torch.zeros(4, 6, 3, dtype=torch.uint8), torch.ones(4, 6))
    assert frame.shape == (4, 6)


def cloud_message(big: bool = False, padding: int = 5) -> SimpleNamespace:
    """A PointCloud2 with a packed colour, and rows that end in padding."""
    order = ">" if big else "<"
    kind = np.dtype([("xyz", order + "f4", 3), ("rgb", order + "u4"), ("ring", "u1")])
    rows = np.zeros(20, kind)
    rows["xyz"] = POINTS
    wide = COLORS.astype(np.uint32)
    rows["rgb"] = wide[:, 0] << 16 | wide[:, 1] << 8 | wide[:, 2]
    rows["ring"] = np.arange(20)
    lines = rows.reshape(4, 5).view(np.uint8).reshape(4, -1)
    data = np.concatenate([lines, np.full((4, padding), 77, np.uint8)], axis=1)
    places = [("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("rgb", 12, 7), ("ring", 16, 2)]
    fields = [SimpleNamespace(name=n, offset=o, datatype=t, count=1) for n, o, t in places]
    return SimpleNamespace(
        height=4, width=5, fields=fields, is_bigendian=big, point_step=kind.itemsize,
        row_step=5 * kind.itemsize + padding, data=data.tobytes(), is_dense=True,
    )  # fmt: skip


@pytest.mark.parametrize("big", [True, False])
def test_ros_clouds(big: bool) -> None:
    message = cloud_message(big)
    scene = as_scene(message)
    assert scene.shape == (4, 5)
    assert scene.points.reshape(-1, 3) == pytest.approx(POINTS, abs=1e-6)
    assert (scene.colors.reshape(-1, 3) == COLORS).all()
    made = labelled(message, LABELS.reshape(4, 5))
    assert isinstance(made.data, bytes)
    fields = cloud_fields(made)
    assert (fields["segment"].reshape(-1) == LABELS).all()
    assert fields["ring"].reshape(-1).tolist() == list(range(20))
    assert len(message.fields) == 5
    assert (as_scene(made).points == scene.points).all()


def test_broken_ros_clouds() -> None:
    message = cloud_message()
    message.data = message.data[:-1]
    with pytest.raises(GeohueError, match="cut off"):
        as_scene(message)
    message = cloud_message()
    message.fields = message.fields[1:]
    with pytest.raises(GeohueError, match="no x, y, z"):
        as_scene(message)


def image_message(pixels: NDArray[Any], encoding: str) -> SimpleNamespace:
    height, width = pixels.shape[:2]
    flat = np.ascontiguousarray(pixels).reshape(height, -1).view(np.uint8)
    return SimpleNamespace(
        height=height, width=width, encoding=encoding, is_bigendian=0, step=flat.shape[1],
        data=flat.reshape(-1),
    )  # fmt: skip


def test_ros_images() -> None:
    rgb = np.random.default_rng(0).integers(0, 256, (4, 6, 3), np.uint8)
    color, depth = image_message(rgb, "rgb8"), image_message(np.full((4, 6), 1500, "<u2"), "16UC1")
    info = SimpleNamespace(k=np.array([5.0, 0, 2.5, 0, 5, 1.5, 0, 0, 1]), width=6, height=4)
    scene = as_scene(color, depth, info)
    assert (scene.colors == rgb).all()
    assert scene.depth is not None
    assert scene.depth[0, 0] == pytest.approx(1.5)
    labels = np.arange(24, dtype=np.int32).reshape(4, 6) - 1
    made = labelled(color, labels)
    assert (made.encoding, made.step) == ("16UC1", 12)
    assert (made.data.view("<u2").reshape(4, 6) == labels + 1).all()
    with pytest.raises(GeohueError, match="has no depth"):
        as_scene(color)
    with pytest.raises(GeohueError, match=r"the image \(4, 6\)"):
        labelled(color, labels[:2])


@pytest.mark.parametrize(
    ("thing", "message"),
    [
        ("a path", "builtins.str is nothing that is known"),
        (np.zeros((3, 4)), r"shape \(3, 4\)"),
        (np.full((2, 6), 300.0), "from 0 to 300|from 300|to 300"),
    ],
)
def test_mistakes_are_named(thing: Any, message: str) -> None:
    with pytest.raises(GeohueError, match=message):
        as_scene(thing)


def test_labels_must_fit() -> None:
    with pytest.raises(GeohueError, match="3 labels for 20 points"):
        labelled(POINTS, LABELS[:3])
    with pytest.raises(GeohueError, match="a Scene has no place"):
        labelled(as_scene(POINTS), LABELS)


def test_napari_reads_a_folder(
    three_boxes: tuple[Scene, NDArray[np.int32]], tmp_path: Path
) -> None:
    seg = geohue.segment(three_boxes[0])
    write_results(tmp_path, three_boxes[0], seg)
    reader = napari.get_reader(str(tmp_path))
    assert reader is not None
    layers = reader(str(tmp_path))
    assert (layers[0][0] == seg.labels + 1).all()
    assert [layer[1]["name"] for layer in layers] == ["segments", "fine", "coarse"]
    assert seg.levels is not None
    assert (layers[2][0] == seg.levels.at("coarse") + 1).all()
    assert napari.get_reader(str(tmp_path / "none")) is None
    assert napari.get_reader([str(tmp_path)]) is None


def test_rerun_gets_points_labels_and_boxes(
    three_boxes: tuple[Scene, NDArray[np.int32]], tmp_path: Path
) -> None:
    rr = pytest.importorskip("rerun")
    recording = rr.RecordingStream("test")
    recording.save(tmp_path / "a.rrd")
    rerun.log(geohue.segment(three_boxes[0]), recording=recording)
    recording.flush()
    content = (tmp_path / "a.rrd").read_bytes()
    for name in (b"scene/points", b"scene/labels", b"scene/boxes"):
        assert name in content


@given(seed=st.integers(0, 99))
@settings(max_examples=10, deadline=None)
def test_quaternions_turn_the_axes(seed: int) -> None:
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    axes = q * np.sign(np.linalg.det(q))
    turned = Rotation.from_quat(rerun.quaternions(axes[None])[0]).apply(np.eye(3))
    assert turned == pytest.approx(axes)
