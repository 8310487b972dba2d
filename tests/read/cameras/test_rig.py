"""Calibrations: the same rig from every layout, worked poses, and files that are none."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from geohue import GeohueError
from geohue.read.cameras.rig import read_rig, rotation_from_quaternion
from geohue.results.rig import write_rig
from geohue.sensors import DisparityModel, Lens, PosedCamera, Rig
from sensors.rigs import BENT, CAMERA, rotation

OPENCV: Any = cv2
K = [[100.0, 0.0, 49.5], [0.0, 100.0, 39.5], [0.0, 0.0, 1.0]]
R = rotation(1, 5.0)
T = np.array([-0.03, 0.01, 0.002])
DEPTH = {"K": K, "dist": list(BENT), "size": [100, 80]}
POSE = {"R": R.tolist(), "T": [0, 0, 0]}
COLOR = {"K": K, "dist": [0.0] * 5, "size": [100, 80]}


def saved(folder: Path, content: Any, name: str = "calibration.json") -> Path:
    file = folder / name
    file.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
    return file


def check(rig: Rig, depth: Lens | None = None) -> None:
    assert rig.depth == (depth or Lens(CAMERA, BENT))
    camera = rig.cameras[0]
    assert camera.lens == Lens(CAMERA)
    assert camera.rotation == pytest.approx(R, abs=1e-9)
    assert camera.translation == pytest.approx(T, abs=1e-9)


def test_plain_json(tmp_path: Path) -> None:
    whole = {"depth": DEPTH, "rgb": COLOR}
    named = whole | {"R_depth_to_rgb": R.tolist(), "T_depth_to_rgb": T.tolist()}
    check(read_rig(saved(tmp_path, named | {"depth_unit_m": 0.001})))
    check(read_rig(saved(tmp_path, whole | {"R": R.tolist(), "T": T.tolist()})))
    own = {"depth": DEPTH, "color": COLOR | {"R": R.tolist(), "T": T.tolist()}}
    check(read_rig(saved(tmp_path, own)))
    T4 = np.eye(4)
    T4[:3, :3], T4[:3, 3] = R, T
    check(read_rig(saved(tmp_path, {"ir": DEPTH, "rgb": COLOR | {"T_rgb_ir": T4.tolist()}})))


def test_opencv_yaml_and_xml_and_two_files(tmp_path: Path) -> None:
    intrinsics = {"M1": np.array(K), "D1": np.array([BENT]), "M2": np.array(K), "D2": np.zeros(5)}
    extrinsics = {"R": R, "T": T.reshape(3, 1)}
    for suffix in ("yml", "xml"):
        files = []
        for name, content in (("intrinsics", intrinsics), ("extrinsics", extrinsics)):
            file = tmp_path / f"{name}.{suffix}"
            storage = OPENCV.FileStorage(str(file), cv2.FILE_STORAGE_WRITE)
            for key, value in content.items():
                storage.write(key, value)
            storage.release()
            files.append(file)
        rig = read_rig(*files)
        assert rig.depth_lens.distortion == pytest.approx(BENT)
        assert rig.cameras[0].rotation == pytest.approx(R)
        assert rig.cameras[0].translation == pytest.approx(T)
        assert "first camera" in rig.warnings[0]
        with pytest.raises(GeohueError, match="no R and T"):
            read_rig(files[0])


INFO = """header:
  frame_id: {frame}
height: 80
width: 100
distortion_model: {model}
d: {d}
k: [100.0, 0.0, 49.5, 0.0, 100.0, 39.5, 0.0, 0.0, 1.0]
"""
TRANSFORM = """header:
  frame_id: {frame}
transform:
  translation:
    x: {t[0]}
    y: {t[1]}
    z: {t[2]}
  rotation:
    x: {q[0]}
    y: {q[1]}
    z: {q[2]}
    w: {q[3]}
"""
QUATERNION = [0.0, np.sin(np.radians(2.5)), 0.0, np.cos(np.radians(2.5))]


def test_ros(tmp_path: Path) -> None:
    turn = rotation_from_quaternion(QUATERNION)
    depth = saved(
        tmp_path, INFO.format(frame="ir", model="plumb_bob", d=list(BENT)), "depth_info.yaml"
    )
    color = saved(tmp_path, INFO.format(frame="rgb", model="plumb_bob", d=[0.0] * 5), "color.yaml")
    there = saved(tmp_path, TRANSFORM.format(frame="rgb", t=T, q=QUATERNION), "tf.yaml")
    rig = read_rig(depth, color, there)
    assert rig.depth == Lens(CAMERA, BENT)
    assert rig.cameras[0].rotation == pytest.approx(turn)
    assert rig.cameras[0].translation == pytest.approx(T)
    # tf the other way round: the parent is the depth camera.
    back = saved(tmp_path, TRANSFORM.format(frame="ir", t=T, q=QUATERNION), "tf2.yaml")
    rig = read_rig(depth, color, back)
    assert rig.cameras[0].rotation == pytest.approx(turn.T)
    assert rig.cameras[0].translation == pytest.approx(-turn.T @ T)


def test_quaternion_by_hand() -> None:
    assert rotation_from_quaternion(QUATERNION) @ [0, 0, 1] == pytest.approx(
        [np.sin(np.radians(5)), 0, np.cos(np.radians(5))]
    )


def test_kitti_by_hand(tmp_path: Path) -> None:
    text = (
        "P2: 700 0 600 70 0 700 170 0 0 0 1 0\nP3: 700 0 600 -280 0 700 170 0 0 0 1 0\n"
        "R0_rect: 1 0 0 0 1 0 0 0 1\nTr_velo_to_cam: 0 -1 0 0.1 0 0 -1 -0.2 1 0 0 -0.3\n"
    )
    left, right = read_rig(saved(tmp_path, text, "calib.txt")).cameras
    # A point 10.3 m ahead, 1 m to the left of the scanner and at its height.
    point = np.array([[10.3, 1.0, 0.0]])
    assert left.transform(point)[0] == pytest.approx([-1 + 0.1 + 0.1, -0.2, 10.0], rel=1e-6)
    assert right.transform(point)[0] == pytest.approx([-1 + 0.1 - 0.4, -0.2, 10.0], rel=1e-6)
    assert left.lens.project(left.transform(point))[0] == pytest.approx([544.0, 156.0])


@pytest.mark.parametrize("model", ["brown", "fisheye", "inverse"])
def test_what_is_written_is_read(tmp_path: Path, model: Any) -> None:
    bent = BENT[:4] if model == "fisheye" else BENT
    lens = Lens(CAMERA, bent, model)
    cameras = tuple(PosedCamera(Lens(CAMERA, BENT), R, T * n, f"c{n}") for n in (1, 2))
    rig = Rig(cameras, lens, DisparityModel(3.1, -0.0029), 0.001)
    write_rig(tmp_path / "rig.json", rig)
    again = read_rig(tmp_path / "rig.json")
    assert again.depth == lens
    assert again.depth_unit == 0.001
    assert again.disparity is not None
    assert (again.disparity.c0, again.disparity.c1) == (3.1, -0.0029)
    for one, two in zip(rig.cameras, again.cameras, strict=True):
        assert one.lens == two.lens
        assert np.array_equal(one.rotation, two.rotation)
        assert np.array_equal(one.translation, two.translation)


@pytest.mark.parametrize(
    ("content", "cause"),
    [
        ({"depth": DEPTH, "rgb": COLOR}, "no R and T from the depth camera"),
        ({"fx": 1}, "no calibration of a range sensor"),
        ("", "empty"),
        ("just words", "no calibration of a range sensor"),
        ("{", "damaged JSON"),
        ({"depth": {}, "rgb": COLOR} | POSE, "not a camera matrix"),
        (
            {"depth": DEPTH, "rgb": COLOR} | POSE | {"R": np.ones((3, 3)).tolist()},
            "no rotation",
        ),
        ({"depth": DEPTH, "rgb": COLOR} | POSE | {"T": [0, 0]}, "T must be 3 numbers"),
        (
            {"depth": DEPTH | {"dist": [1]}, "rgb": COLOR} | POSE,
            "expected 0",
        ),
        ("P2: 1 0 0 0 0 1 0 0 0 0 1 0\n", "no line Tr_velo_to_cam"),
    ],
)
def test_refuses_what_is_no_calibration(tmp_path: Path, content: Any, cause: str) -> None:
    with pytest.raises(GeohueError, match=cause) as caught:
        read_rig(saved(tmp_path, content))
    assert "\n" not in str(caught.value)


def test_millimetres_are_doubted(tmp_path: Path) -> None:
    content = {"depth": DEPTH, "rgb": COLOR, "R": R.tolist(), "T": (T * 1000).tolist()}
    assert "must be in metres" in read_rig(saved(tmp_path, content)).warnings[0]


def test_real_calibrations(data_dir: Path) -> None:
    ist = read_rig(data_dir / "ist_maizena2" / "calibration.json")
    assert ist.depth_unit == 0.001
    assert ist.cameras[0].translation[0] == pytest.approx(-0.0263, abs=1e-4)
    herrera = read_rig(data_dir / "herrera_kinect_2rgb" / "calibration.json")
    assert [c.name for c in herrera.cameras] == ["c1", "c2"]
    assert herrera.depth_lens.model == "inverse"
    assert herrera.disparity is not None
    kitti = read_rig(data_dir / "kitti_stereo_lidar" / "demo" / "calib.txt")
    apart = kitti.cameras[1].translation - kitti.cameras[0].translation
    assert np.linalg.norm(apart) == pytest.approx(0.5327, abs=1e-3)
