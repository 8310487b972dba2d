"""Intrinsics: the same camera from every kind of file, and files that are no camera."""

from __future__ import annotations

import json
import warnings
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from geohue.camera import Intrinsics
from geohue.errors import GeohueError, GeohueWarning
from geohue.read import read_intrinsics
from geohue.read.cameras.rig import read_rig
from geohue.read.cameras.stereo_calibration import read_stereo_calibration

SIZED = Intrinsics(525.0, 520.0, 319.5, 239.5, 640, 480)
BARE = Intrinsics(525.0, 520.0, 319.5, 239.5)
K: list[list[float]] = [[525.0, 0, 319.5], [0, 520.0, 239.5], [0, 0, 1]]
ROWS = [x for row in K for x in row]
OPEN3D = {"width": 640, "height": 480, "intrinsic_matrix": [525, 0, 0, 0, 520, 0, 319.5, 239.5, 1]}
ROS = """image_width: 640
image_height: 480
camera_name: narrow_stereo/left
camera_matrix:
  rows: 3
  cols: 3
  data: [525.0, 0.0, 319.5,
         0, 520.0, 239.5, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [0, 0, 0, 0, 0]
projection_matrix:
  rows: 3
  cols: 4
  data: [1, 0, 2, 0, 0, 3, 4, 0, 0, 0, 1, 0]
"""
ROS_TOPIC = """header:
  stamp:
    sec: 12
  frame_id: camera
height: 480
width: 640
d:
- 0.0
- 0.0
k:
- 525.0
- 0.0
- 319.5
- 0.0
- 520.0
- 239.5
- 0.0
- 0.0
- 1.0
"""
KALIBR = """cam0:
  intrinsics: [525.0, 520.0, 319.5, 239.5]
  resolution: [640, 480]
"""
OPENCV_XML = """<?xml version="1.0"?>
<opencv_storage>
<image_width>640</image_width><image_height>480</image_height>
<!-- calibrated -->
<M1 type_id="opencv-matrix"><rows>3</rows><cols>3</cols><dt>d</dt>
  <data>525. 0. 319.5 0. 520. 239.5
        0. 0. 1.</data></M1>
</opencv_storage>
"""
FLAT = {"fx": 525.0, "fy": 520.0, "cx": 319.5, "cy": 239.5}
SIZE = {"width": 640, "height": 480}
FILES = {
    "project.json": json.dumps(FLAT | SIZE),
    "realsense.json": json.dumps(
        {"intrinsics": {"fx": 525.0, "fy": 520.0, "ppx": 319.5, "ppy": 239.5, **SIZE}}
    ),
    "uoc.json": json.dumps(
        {"img_width": 640, "img_height": 480, "fx": 525, "fy": 520}
        | {"x_offset": 319.5, "y_offset": 239.5}
    ),
    "open3d.json": json.dumps(OPEN3D),
    "open3d_view.json": json.dumps({"extrinsic": [1, 0], "intrinsic": OPEN3D}),
    "open3d_trajectory.json": json.dumps({"parameters": [{"intrinsic": OPEN3D}] * 3}),
    "k_rows.json": json.dumps({"K": K} | SIZE),
    "k_flat.json": json.dumps({"cam_K": ROWS, "width": 640, "height": 480}),
    "ros.yaml": ROS,
    "topic.yaml": ROS_TOPIC,
    "kalibr.yaml": KALIBR,
    "opencv.xml": OPENCV_XML,
}


@pytest.mark.parametrize("name", FILES)
def test_every_layout_gives_the_same_camera(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text(FILES[name])
    assert read_intrinsics(tmp_path / name) == SIZED
    assert read_intrinsics(str(tmp_path / name)) == SIZED


@pytest.mark.parametrize("name", ["c.yml", "c.xml", "c.json"])
def test_what_opencv_writes(tmp_path: Path, name: str) -> None:
    storage = cv2.FileStorage(str(tmp_path / name), cv2.FILE_STORAGE_WRITE)
    storage.write("image_width", 640)
    storage.write("image_height", 480)
    storage.write("camera_matrix", np.array(K))
    storage.write("distortion_coefficients", np.array([[0.1, -0.2, 0, 0, 0]]))
    storage.release()
    with pytest.warns(GeohueWarning, match="distortion"):
        assert read_intrinsics(tmp_path / name) == SIZED


@pytest.mark.parametrize(
    "text", ["525,520,319.5,239.5", " 525 520 319.5 2.395e2 ", "525;520;319.5;239.5"]
)
def test_four_numbers(tmp_path: Path, text: str) -> None:
    assert read_intrinsics(text) == BARE
    (tmp_path / "k.txt").write_text(text + "\n")
    assert read_intrinsics(tmp_path / "k.txt") == BARE


@pytest.mark.parametrize("separator", [" ", ",", "\t", ", "])
def test_matrix_as_text(tmp_path: Path, separator: str) -> None:
    lines = [separator.join(map(str, row)) for row in K]
    (tmp_path / "k.txt").write_text("# camera\n" + "\n".join(lines) + "\n")
    assert read_intrinsics(tmp_path / "k.txt") == BARE


def test_depth_scale(tmp_path: Path) -> None:
    file = tmp_path / "c.json"
    file.write_text(json.dumps(FLAT | {"depth_scale": 1000.0}))
    assert read_intrinsics(file).depth_scale == 1000
    file.write_text(json.dumps(FLAT | {"depth_scale": 0.1}))
    with pytest.warns(GeohueWarning, match="give depth_scale"):
        assert read_intrinsics(file).depth_scale is None


BROKEN = {
    "nothing": ("{}", "what is read"),
    "prose": ("a camera\n", "what is read"),
    "damaged json": ('{"fx": 1,', "damaged JSON"),
    "damaged xml": ("<a><b></a>", "damaged XML"),
    "xml entities": ('<!DOCTYPE a [<!ENTITY b "b">]><a>&b;</a>', "declarations"),
    "deep json": ('{"a":' * 100_000, "damaged JSON"),
    "no camera matrix": ("1 2 3\n4 5 6\n7 8 9\n", "not a camera matrix"),
    "words": (json.dumps(FLAT | {"fx": "wide"}), "numbers"),
    "zero focal length": (json.dumps(FLAT | {"fx": 0}), "focal"),
    "infinite": (json.dumps(FLAT | {"fx": 1e999}), "finite"),
    "large": (json.dumps(FLAT | {"fx": 10**400}), "numbers"),
    "two cameras": (json.dumps({"rgb": FLAT, "depth": FLAT | {"fx": 9.0}}), "several cameras"),
}


@pytest.mark.parametrize(("text", "words"), BROKEN.values(), ids=BROKEN.keys())
def test_broken_files_say_what_is_wrong(tmp_path: Path, text: str, words: str) -> None:
    file = tmp_path / "c.txt"
    file.write_text(text)
    with pytest.raises(GeohueError, match=words) as error:
        read_intrinsics(file)
    assert str(error.value).startswith(str(file))


def test_neither_file_nor_numbers(tmp_path: Path) -> None:
    for given_ in ("525,525,319.5", "nowhere.json", str(tmp_path), "a\0b"):
        with pytest.raises(GeohueError) as error:
            read_intrinsics(given_)
        assert str(error.value).startswith(given_)


@settings(
    max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    name=st.sampled_from(sorted(FILES)),
    cut=st.integers(1, 500),
    edits=st.lists(
        st.tuples(st.integers(0, 500), st.characters() | st.sampled_from('[]{}:-,\n "<>&!#%0e.'))
    ),
)
def test_damage_gives_a_camera_or_one_error(
    tmp_path: Path, name: str, cut: int, edits: list[tuple[int, str]]
) -> None:
    text = list(FILES[name][:cut])
    for position, character in edits[:5]:
        text[position % len(text)] = character
    file = tmp_path / name
    file.write_bytes("".join(text).encode("utf-8", "surrogatepass"))
    message = f"{file}: "
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", GeohueWarning)
            read_intrinsics(file)
    except GeohueError as error:
        message = str(error)
    assert message.startswith(f"{file}: ")


@pytest.mark.parametrize(
    ("name", "fx", "width"),
    [
        ("open3d_testdata/examples/TestData/camera_primesense.json", 525.0, 640),
        ("uoc_demo/data/demo/camera_params.json", 612.937, 640),
        ("stereodemo_oakd/stereodemo_calibration.json", 451.0344543457031, 640),
        ("nyuv2/frames/0602/intrinsics.json", 518.8579011745019, 640),
    ],
)
def test_real_files(data_dir: Path, name: str, fx: float, width: int) -> None:
    camera = read_intrinsics(data_dir / name)
    assert (camera.fx, camera.width) == (fx, width)


def test_real_opencv_yaml_warns_of_distortion(data_dir: Path) -> None:
    with pytest.warns(GeohueWarning, match="distortion"):
        camera = read_intrinsics(data_dir / "opencv_samples/left_intrinsics.yml")
    assert camera.fx == pytest.approx(535.91573)


@pytest.mark.parametrize("upper", [False, True])
def test_the_three_calibration_readers_know_a_key_in_any_case(tmp_path: Path, upper: bool) -> None:
    """A camera, a rig and a stereo pair, from one file with OpenCV's names."""
    matrix, R = [[500, 0, 320], [0, 500, 240], [0, 0, 1]], np.eye(3).tolist()
    content: dict[str, object] = {
        "m1": matrix,
        "d1": [0.0] * 5,
        "m2": matrix,
        "d2": [0.0] * 5,
        "r": R,
        "t": [-0.1, 0, 0],
    }
    file = tmp_path / "calib.json"
    file.write_text(json.dumps({k.upper() if upper else k: v for k, v in content.items()}))
    assert read_intrinsics(file).fx == 500
    assert read_rig(file).cameras[0].translation == pytest.approx([-0.1, 0, 0])
    assert read_stereo_calibration(file).baseline == pytest.approx(0.1)
