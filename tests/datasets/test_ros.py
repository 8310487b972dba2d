"""Recordings that the tests write with rosbags: ROS 1, ROS 2, MCAP, RealSense's topics."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geohue import GeohueError
from geohue.datasets import open_dataset

rosbags = pytest.importorskip("rosbags", reason="needs geohue[ros]")

RGB = np.random.default_rng(0).integers(0, 256, (6, 8, 3)).astype(np.uint8)
TOPICS = ("/camera/color/image_raw", "/camera/aligned_depth_to_color/image_raw")
REALSENSE = ("/device_0/sensor_1/Color_0/image/data", "/device_0/sensor_0/Depth_0/image/data")


def messages(types: Any, one: bool, encodings: tuple[str, str]) -> tuple[Any, Any, Any]:
    """A picture, a depth map at 2 m and a camera."""
    kinds = types.types
    time = kinds["builtin_interfaces/msg/Time"](sec=1, nanosec=0)
    seq = {"seq": 0} if one else {}
    header = kinds["std_msgs/msg/Header"](stamp=time, frame_id="camera", **seq)
    image = kinds["sensor_msgs/msg/Image"]
    pixels = RGB if encodings[0] == "rgb8" else RGB[..., ::-1]
    color = image(header, 6, 8, encodings[0], 0, 24, np.ascontiguousarray(pixels).ravel())
    wide = np.zeros((6, 10), np.uint16)  # rows padded to 20 bytes
    wide[:, :8] = 2000
    step = 20
    raw = wide
    if encodings[1] == "32FC1":
        raw, step = np.full((6, 8), 2.0, np.float32), 32
    depth = image(header, 6, 8, encodings[1], 0, step, raw.view(np.uint8).ravel())
    K = np.array([9.0, 0, 3.5, 0, 9.0, 2.5, 0, 0, 1])
    roi = kinds["sensor_msgs/msg/RegionOfInterest"](0, 0, 0, 0, False)
    names = ("D", "K", "R", "P") if one else ("d", "k", "r", "p")
    values = dict(zip(names, (np.zeros(5), K, np.eye(3).ravel(), np.zeros(12)), strict=True))
    info = kinds["sensor_msgs/msg/CameraInfo"](
        header=header, height=6, width=8, distortion_model="plumb_bob", **values,
        binning_x=0, binning_y=0, roi=roi,
    )  # fmt: skip
    return color, depth, info


def record(
    path: Path,
    kind: str,
    topics: tuple[str, str] = TOPICS,
    encodings: tuple[str, str] = ("rgb8", "16UC1"),
) -> Path:
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    one = kind == "bag"
    store = get_typestore(Stores.ROS1_NOETIC if one else Stores.ROS2_HUMBLE)
    color, depth, info = messages(store, one, encodings)
    plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
    writer: Any = Writer1(path) if one else Writer2(path, version=9, storage_plugin=plugin)
    pack = store.serialize_ros1 if one else store.serialize_cdr
    with writer:
        extra = {"typestore": store}
        camera = topics[0].rsplit("/", 1)[0] + "/camera_info"
        sent = [(topics[0], color), (topics[1], depth), (camera, info)]
        links = {t: writer.add_connection(t, m.__msgtype__, **extra) for t, m in sent}
        for i in range(3):
            for shift, (topic, message) in enumerate(sent):
                stamp = 10**9 * (i + 1) + shift * 10**7
                writer.write(links[topic], stamp, pack(message, message.__msgtype__))
        writer.write(links[topics[0]], 10**10, pack(color, color.__msgtype__))  # no depth near
    return path


@pytest.mark.parametrize("kind", ["bag", "db3", "mcap"])
@pytest.mark.parametrize("encodings", [("rgb8", "16UC1"), ("bgr8", "32FC1")])
def test_recordings(tmp_path: Path, kind: str, encodings: tuple[str, str]) -> None:
    path = record(tmp_path / ("a.bag" if kind == "bag" else "a"), kind, encodings=encodings)
    data = open_dataset(path)
    assert data.layout == "ros"
    assert len(data) == 3
    frame = data[1]
    assert np.array_equal(frame.read_color(), RGB)
    assert frame.read_depth() == pytest.approx(np.full((6, 8), 2.0))
    assert frame.intrinsics is not None
    assert (frame.intrinsics.fx, frame.intrinsics.cx) == (9.0, 3.5)
    assert frame.scene().warnings == ()
    assert len(data.notes) == 1


def test_a_single_file_of_ros2(tmp_path: Path) -> None:
    record(tmp_path / "a", "mcap")
    record(tmp_path / "b", "db3")
    for file in (*(tmp_path / "a").glob("*.mcap"), *(tmp_path / "b").glob("*.db3")):
        assert len(open_dataset(file)) == 3


def test_realsense_topics(tmp_path: Path) -> None:
    data = open_dataset(record(tmp_path / "a.bag", "bag", REALSENSE))
    assert len(data) == 3
    assert "registered" in data.notes[-1]


def test_refuses_recordings_without_depth_or_damaged(tmp_path: Path) -> None:
    path = record(tmp_path / "a.bag", "bag", ("/left/color", "/right/color"))
    with pytest.raises(GeohueError, match="no colour and depth pictures"):
        open_dataset(path)
    whole = record(tmp_path / "b.bag", "bag").read_bytes()
    for part in (whole[: len(whole) // 2], whole[:40], b"", b"#ROSBAG V2.0\n" + b"\xff" * 99):
        (tmp_path / "c.bag").write_bytes(part)
        with pytest.raises(GeohueError) as caught:
            open_dataset(tmp_path / "c.bag")
        assert "\n" not in str(caught.value)
    with pytest.raises(GeohueError):
        open_dataset(tmp_path / "missing.mcap")
