"""Every calibration format, by hand, and files that are none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from geohue.camera import Intrinsics
from geohue.errors import GeohueError
from geohue.read.cameras.stereo_calibration import read_stereo_calibration
from geohue.results.stereo_calibration import write_stereo_calibration
from geohue.stereo import StereoRig

OPENCV = """%YAML:1.0
---
{left}: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 500., 0., 320., 0., 500., 240., 0., 0., 1. ]
{left_d}: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ 0.1, 0., 0., 0., 0. ]
{right}: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 510., 0., 330., 0., 510., 241., 0., 0., 1. ]
{right_d}: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ 0.2, 0., 0., 0., 0. ]
"""
EXTRINSICS = """%YAML:1.0
---
R: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 1., 0., 0., 0., 1., 0., 0., 0., 1. ]
T: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ -0.12, 0., 0. ]
"""
Q = """%YAML:1.0
---
Q: !!opencv-matrix
   rows: 4
   cols: 4
   dt: d
   data: [ 1., 0., 0., -320., 0., 1., 0., -240., 0., 0., 0., 500., 0., 0., 10., 50. ]
"""
KITTI = """P0: 700 0 600 0 0 700 170 0 0 0 1 0
P1: 700 0 600 -378 0 700 170 0 0 0 1 0
P2: 720 0 610 45 0 720 172 0.2 0 0 1 0.003
P3: 720 0 610 -339.48 0 720 172 2.2 0 0 1 0.003
R0_rect: 1 0 0 0 1 0 0 0 1
"""
RAW_KITTI = """calib_time: 09-Jan-2012 13:57:47
S_rect_02: 1.242000e+03 3.750000e+02
P_rect_02: 720 0 610 45 0 720 172 0.2 0 0 1 0.003
S_rect_03: 1.242000e+03 3.750000e+02
P_rect_03: 720 0 610 -339.48 0 720 172 2.2 0 0 1 0.003
"""
MIDDLEBURY = """cam0=[3979.911 0 1244.772; 0 3979.911 1019.507; 0 0 1]
cam1=[3979.911 0 1369.115; 0 3979.911 1019.507; 0 0 1]
doffs=124.343
baseline=193.001
width=2964
height=1988
ndisp=270
isint=0
"""
ROS = """image_width: 640
image_height: 480
camera_name: stereo/{side}
camera_matrix:
  rows: 3
  cols: 3
  data: [500, 0, 320, 0, 500, 240, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [{bend}, 0, 0, 0, 0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [480, 0, 310, {shift}, 0, 480, 242, 0, 0, 0, 1, 0]
"""


def saved(folder: Path, name: str, text: str) -> Path:
    file = folder / name
    file.write_text(text)
    return file


@pytest.mark.parametrize(
    "names",
    [
        ("K1", "D1", "K2", "D2"),
        ("M1", "D1", "M2", "D2"),
        ("cameraMatrix1", "distCoeffs1", "cameraMatrix2", "distCoeffs2"),
    ],
)
def test_opencv_matrices(tmp_path: Path, names: tuple[str, str, str, str]) -> None:
    fields = dict(zip(("left", "left_d", "right", "right_d"), names, strict=True))
    text = OPENCV.format(**fields) + EXTRINSICS.split("---\n")[1]
    rig = read_stereo_calibration(saved(tmp_path, "stereo.yml", text))
    assert (rig.left.fx, rig.right.fx, rig.right.cx) == (500, 510, 330)
    assert rig.left_distortion[0] == 0.1
    assert rig.right_distortion[0] == 0.2
    assert rig.baseline == pytest.approx(0.12)
    assert not rig.is_rectified


def test_opencv_in_two_files(tmp_path: Path) -> None:
    text = OPENCV.format(left="M1", left_d="D1", right="M2", right_d="D2")
    file = saved(tmp_path, "intrinsics.yml", text)
    assert read_stereo_calibration(file).rotation is None
    other = saved(tmp_path, "extrinsics.yml", EXTRINSICS)
    assert read_stereo_calibration(file).baseline == pytest.approx(0.12)
    other.rename(tmp_path / "poses.yml")
    both = read_stereo_calibration(file, tmp_path / "poses.yml")
    assert both.baseline == pytest.approx(0.12)


def test_opencv_millimetres_are_said(tmp_path: Path) -> None:
    text = OPENCV.format(left="K1", left_d="D1", right="K2", right_d="D2")
    text += EXTRINSICS.split("---\n")[1].replace("-0.12", "-120.")
    rig = read_stereo_calibration(saved(tmp_path, "stereo.yml", text))
    assert rig.baseline == pytest.approx(0.12)
    assert "millimetres" in rig.warnings[0]


def test_opencv_xml(tmp_path: Path) -> None:
    parts = {"K1": (3, 3, "500 0 320 0 500 240 0 0 1"), "K2": (3, 3, "500 0 325 0 500 240 0 0 1"),
             "R": (3, 3, "1 0 0 0 1 0 0 0 1"), "T": (3, 1, "-0.1 0 0")}  # fmt: skip
    body = "".join(
        f'<{n} type_id="opencv-matrix"><rows>{r}</rows><cols>{c}</cols><dt>d</dt>'
        f"<data>{d}</data></{n}>"
        for n, (r, c, d) in parts.items()
    )
    text = f'<?xml version="1.0"?><opencv_storage>{body}</opencv_storage>'
    rig = read_stereo_calibration(saved(tmp_path, "stereo.xml", text))
    assert rig.is_rectified
    assert rig.offset == 5
    assert rig.baseline == pytest.approx(0.1)


def test_opencv_q(tmp_path: Path) -> None:
    """Q has 1/b = 10 and doffs/b = 50."""
    rig = read_stereo_calibration(saved(tmp_path, "q.yml", Q))
    assert rig.left == Intrinsics(500, 500, 320, 240)
    assert rig.baseline == pytest.approx(0.1)
    assert rig.offset == pytest.approx(5)
    disparity, (x, y) = 45.0, (400.0, 300.0)
    point = np.array([[1, 0, 0, -320], [0, 1, 0, -240], [0, 0, 0, 500], [0, 0, 10, 50]]) @ [
        x, y, disparity, 1
    ]  # fmt: skip
    depth = rig.depth(np.array([[disparity]]))[0, 0]
    assert depth == pytest.approx(point[2] / point[3])


def test_kitti_colour_before_grey(tmp_path: Path) -> None:
    rig = read_stereo_calibration(saved(tmp_path, "calib.txt", KITTI))
    assert rig.left.fx == 720
    assert rig.baseline == pytest.approx((45 + 339.48) / 720)
    grey = "\n".join(KITTI.splitlines()[:2])
    assert read_stereo_calibration(saved(tmp_path, "grey.txt", grey)).baseline == pytest.approx(
        378 / 700
    )


def test_kitti_raw(tmp_path: Path) -> None:
    rig = read_stereo_calibration(saved(tmp_path, "calib_cam_to_cam.txt", RAW_KITTI))
    assert (rig.left.width, rig.left.height) == (1242, 375)
    assert rig.baseline == pytest.approx(0.534)


def test_middlebury_2014(tmp_path: Path) -> None:
    rig = read_stereo_calibration(saved(tmp_path, "calib.txt", MIDDLEBURY))
    assert rig.baseline == pytest.approx(0.193001)
    assert rig.offset == 124.343
    assert (rig.left.width, rig.left.height) == (2964, 1988)
    small = rig.scaled_to(741, 497)
    assert small.offset == pytest.approx(124.343 / 4)


def test_middlebury_2006(tmp_path: Path) -> None:
    rig = read_stereo_calibration(saved(tmp_path, "dmin.txt", "270\n")).scaled_to(641, 555)
    assert rig.left.fx == 1870
    assert rig.offset == 135
    assert rig.left.cx == 320
    assert "Middlebury" in rig.warnings[0]
    named = read_stereo_calibration(
        saved(tmp_path, "c.txt", "focal=3740\nbaseline=160\ndmin=270\n")
    )
    assert named.scaled_to(641, 555).left == rig.left
    assert named.baseline == rig.baseline


def test_ros_pair_beside_one_another(tmp_path: Path) -> None:
    saved(tmp_path, "right.yaml", ROS.format(side="right", bend=0, shift=-48))
    left = saved(tmp_path, "left.yaml", ROS.format(side="left", bend=0, shift=0))
    rig = read_stereo_calibration(left)
    assert rig.is_rectified
    assert rig.left.fx == 480
    assert rig.baseline == pytest.approx(0.1)


def test_ros_raw_pair(tmp_path: Path) -> None:
    left = saved(tmp_path, "l.yaml", ROS.format(side="left", bend=-0.2, shift=0))
    right = saved(tmp_path, "r.yaml", ROS.format(side="right", bend=-0.1, shift=-48))
    rig = read_stereo_calibration(left, right)
    assert not rig.is_rectified
    assert rig.left.fx == 500
    assert rig.right_distortion[0] == -0.1
    assert rig.translation is not None
    np.testing.assert_allclose(rig.translation, [-0.1, 0, 0])


def test_ros_right_camera_alone(tmp_path: Path) -> None:
    file = saved(tmp_path, "camera.yaml", ROS.format(side="right", bend=0, shift=-48))
    assert read_stereo_calibration(file).baseline == pytest.approx(0.1)


def test_ros_left_camera_alone_has_no_baseline(tmp_path: Path) -> None:
    file = saved(tmp_path, "camera.yaml", ROS.format(side="left", bend=0, shift=0))
    rig = read_stereo_calibration(file)
    assert rig.baseline is None
    assert "baseline is unknown" in rig.warnings[0]


def test_json(tmp_path: Path) -> None:
    text = (
        '{"width": 640, "height": 480, "baseline_meters": 0.075, "fx": 451.0, "fy": 451.0, '
        '"cx0": 299.0, "cx1": 302.5, "cy": 255.2, "depth_range": [1, 5]}'
    )
    rig = read_stereo_calibration(saved(tmp_path, "c.json", text))
    assert rig.left == Intrinsics(451.0, 451.0, 299.0, 255.2, 640, 480)
    assert (rig.baseline, rig.offset) == (0.075, 3.5)


def test_numbers() -> None:
    two, three = read_stereo_calibration("700,0.2"), read_stereo_calibration("700 0.2 12")
    assert (two.left.fx, two.baseline, two.offset, two.centre_known) == (700, 0.2, 0, False)
    assert three.offset == 12
    assert three.scaled_to(101, 51).left.cx == 50
    five = read_stereo_calibration("700,0.2,12,320,240")
    assert (five.left.cx, five.right.cx, five.left.cy) == (320, 332, 240)
    assert five.centre_known
    assert read_stereo_calibration("700,193").baseline == pytest.approx(0.193)


# --- written and read again ----------------------------------------------------------------------


def test_written_is_what_is_read(tmp_path: Path) -> None:
    camera = Intrinsics(500.25, 501.5, 320.125, 240.0625, 640, 480)
    turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    rig = StereoRig(
        camera, camera, None, None, (0.1, -0.2, 1e-9, 0.0, 1 / 3), (0.3, 0, 0, 0, 0),
        turn, np.array([-0.1, 0.02, 1e-5]),
    )  # fmt: skip
    file = tmp_path / "new" / "stereo.yml"
    write_stereo_calibration(file, rig, {"reprojection_error": 0.25})
    back = read_stereo_calibration(file)
    assert (back.left, back.right) == (rig.left, rig.right)
    assert back.left_distortion == rig.left_distortion
    assert back.rotation is not None
    assert back.translation is not None
    np.testing.assert_array_equal(back.rotation, turn)
    np.testing.assert_allclose(back.translation, [-0.1, 0.02, 1e-5], rtol=1e-15)
    assert "reprojection_error: 0.25" in file.read_text()
    assert [f.name for f in file.parent.iterdir()] == ["stereo.yml"]


def test_opencv_reads_what_is_written(tmp_path: Path) -> None:
    import cv2

    camera = Intrinsics(500.0, 500.0, 320.0, 240.0, 640, 480)
    write_stereo_calibration(tmp_path / "s.yml", StereoRig(camera, camera, 0.1))
    storage = cv2.FileStorage(str(tmp_path / "s.yml"), cv2.FILE_STORAGE_READ)
    assert storage.getNode("K2").mat()[0, 2] == 320
    assert storage.getNode("T").mat().ravel().tolist() == [-0.1, 0, 0]
    storage.release()


# --- no calibration ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "cause"),
    [
        ("hello there", "has no stereo calibration"),
        ("{}", "has no stereo calibration"),
        ('{"fx": 500}', "has no stereo calibration"),
        ("{", "damaged JSON"),
        ("1 2 3 4", "4 bare numbers"),
        (Q.replace("10.", "0."), "Q has no baseline"),
        (Q.replace("-320.,", ""), "15 numbers instead of 16"),
        (KITTI.replace("-339.48", "45"), "same place"),
        (KITTI.replace("-339.48", "339.48"), "to the left"),
        (MIDDLEBURY.replace("baseline=193.001", "baseline=-1"), "baseline"),
        (MIDDLEBURY.replace("3979.911 0 1244.772", "0 0 1244.772"), "focal lengths positive"),
        ("focal=abc\nbaseline=x\ndmin=270\nK1=[1 2]\nK2=[1]", "2 numbers instead of 9"),
    ],
)
def test_what_is_no_calibration(tmp_path: Path, text: str, cause: str) -> None:
    with pytest.raises(GeohueError, match=cause) as caught:
        read_stereo_calibration(saved(tmp_path, "c.txt", text))
    assert str(caught.value).startswith(str(tmp_path))
    assert "what is read" in str(caught.value) or "damaged" in str(caught.value)


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(GeohueError, match="no such file, nor the numbers"):
        read_stereo_calibration(tmp_path / "none.yml")
    with pytest.raises(GeohueError, match="is a folder"):
        read_stereo_calibration(tmp_path)
