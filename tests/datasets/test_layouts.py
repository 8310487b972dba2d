"""Data sets: tiny folders in each layout, and the real ones."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from geohue import GeohueError, Intrinsics
from geohue.cli.app import run
from geohue.datasets import LAYOUTS, Dataset, open_dataset
from geohue.datasets.frames import inside
from geohue.datasets.nyu_raw import nyu_rig
from geohue.results import write_png
from geohue.results.rig import write_rig
from geohue.sensors import edge_agreement
from sensors.rigs import beside

SIZE = (80, 100)
RGB = np.random.default_rng(0).integers(0, 256, (*SIZE, 3)).astype(np.uint8)
POSE = np.array([[0, -1, 0, 1.5], [1, 0, 0, 2], [0, 0, 1, -3], [0, 0, 0, 1]], np.float64)
# The same pose: 90 degrees about z.
QUATERNION = "1.5 2 -3 0 0 0.70710678118654752 0.70710678118654752"
K = "100 0 49.5\n0 100 39.5\n0 0 1\n"


def depth(value: int) -> NDArray[np.uint16]:
    image = np.full(SIZE, value, np.uint16)
    image[:5] = 0
    return image


def text(file: Path, content: str) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(content, encoding="utf-8")


def tum(folder: Path) -> None:
    lines = {"rgb": "", "depth": "", "groundtruth": "# pose\n"}
    for i in range(3):
        write_png(folder / "rgb" / f"{i}.png", RGB)
        write_png(folder / "depth" / f"{i}.png", depth(10000))
        lines["rgb"] += f"{100 + i}.000 rgb/{i}.png\n"
        lines["depth"] += f"{100 + i}.015 depth/{i}.png\n"
        lines["groundtruth"] += f"{100 + i}.001 {QUATERNION}\n"
    lines["rgb"] += "300.0 rgb/0.png\n"  # no depth within 20 ms
    for name, content in lines.items():
        text(folder / f"{name}.txt", content)


def open3d(folder: Path) -> None:
    log = ""
    for i in range(2):
        write_png(folder / "color" / f"{i:05d}.png", RGB)
        write_png(folder / "depth" / f"{i:05d}.png", depth(2000))
        log += f"{i} {i} {i + 1}\n" + "\n".join(" ".join(map(str, r)) for r in POSE) + "\n"
    text(folder / "trajectory.log", log)
    camera = {"width": 100, "height": 80, "intrinsic_matrix": [100, 0, 0, 0, 100, 0, 49.5, 39.5, 1]}
    text(folder / "camera_intrinsic.json", json.dumps(camera))


def bop(folder: Path) -> None:
    camera: dict[str, Any] = {"cam_K": [float(x) for x in K.split()], "depth_scale": 0.1}
    R = POSE[:3, :3]
    camera["cam_R_w2c"] = R.T.ravel().tolist()
    camera["cam_t_w2c"] = (-R.T @ POSE[:3, 3] * 1000).tolist()
    cameras = {}
    for i in (0, 12):
        write_png(folder / "rgb" / f"{i:06d}.png", RGB)
        write_png(folder / "depth" / f"{i:06d}.png", depth(20000))
        cameras[str(i)] = camera
    text(folder / "scene_camera.json", json.dumps(cameras))


def sevenscenes(folder: Path) -> None:
    for i in range(2):
        write_png(folder / f"frame-{i:06d}.color.png", RGB)
        write_png(folder / f"frame-{i:06d}.depth.png", depth(2000))
        pose = POSE if i == 0 else np.full((4, 4), np.inf)
        text(folder / f"frame-{i:06d}.pose.txt", "\n".join(" ".join(map(str, r)) for r in pose))
    text(folder / "camera-intrinsics.txt", K)


def scannet(folder: Path) -> None:
    for i in range(2):
        write_png(folder / "color" / f"{i}.png", RGB.repeat(2, axis=0).repeat(2, axis=1))
        write_png(folder / "depth" / f"{i}.png", depth(2000))
        text(folder / "pose" / f"{i}.txt", "\n".join(" ".join(map(str, r)) for r in POSE))
    text(
        folder / "intrinsic" / "intrinsic_depth.txt", "100 0 49.5 0\n0 100 39.5 0\n0 0 1 0\n0 0 0 1"
    )


def sunrgbd(folder: Path) -> None:
    for i in range(2):
        scene = folder / "kv1" / f"NYU{i:04d}"
        write_png(scene / "image" / f"NYU{i}.png", RGB)
        write_png(scene / "depth" / f"NYU{i}.png", depth(2000) << 3)
        text(scene / "intrinsics.txt", K)


def kitti(folder: Path) -> None:
    base = folder / "training"
    rng = np.random.default_rng(1)
    ahead = rng.uniform(5, 20, 500)
    points = np.stack([ahead, rng.uniform(-0.3, 0.3, 500) * ahead, 0.1 * ahead, ahead * 0], axis=1)
    calib = (
        "P2: 100 0 49.5 0 0 100 39.5 0 0 0 1 0\nP3: 100 0 49.5 -50 0 100 39.5 0 0 0 1 0\n"
        "R0_rect: 1 0 0 0 1 0 0 0 1\nTr_velo_to_cam: 0 -1 0 0 0 0 -1 0 1 0 0 0\n"
    )
    for name in ("000000", "000007"):
        for n in (2, 3):
            write_png(base / f"image_{n}" / f"{name}.png", RGB)
        (base / "velodyne").mkdir(exist_ok=True)
        (base / "velodyne" / f"{name}.bin").write_bytes(points.astype("<f4").tobytes())
        text(base / "calib" / f"{name}.txt", calib)


def middlebury(folder: Path) -> None:
    for name in ("Aloe", "Baby"):
        write_png(folder / name / "view1.png", RGB)
        write_png(folder / name / "view5.png", RGB)
        disparity = np.full(SIZE, 29, np.uint8)
        disparity[:5] = 0
        write_png(folder / name / "disp1.png", disparity)
        text(folder / name / "dmin.txt", "270\n")


def middlebury_2014(folder: Path) -> None:
    write_png(folder / "Piano" / "im0.png", RGB)
    values = np.full(SIZE, 40, "<f4")
    values[-5:] = np.inf  # rows go upwards in PFM: the first five of the picture
    (folder / "Piano" / "disp0.pfm").write_bytes(b"Pf\n100 80\n-1.0\n" + values.tobytes())
    calib = "cam0=[100 0 49.5; 0 100 39.5; 0 0 1]\ncam1=[100 0 59.5; 0 100 39.5; 0 0 1]\n"
    text(folder / "Piano" / "calib.txt", f"{calib}doffs=10\nbaseline=1000\nwidth=100\nheight=80\n")


def rig(folder: Path) -> None:
    for i in range(2):
        write_png(folder / f"{i:02d}_rgb.png", RGB)
        write_png(folder / f"{i:02d}_depth.png", depth(2000))
    write_rig(folder / "calibration.json", beside(0.0))


def pairs(folder: Path) -> None:
    for i in range(2):
        write_png(folder / f"{i:06d}-color.png", RGB)
        write_png(folder / f"{i:06d}-depth.png", depth(2000))
    text(folder / "intrinsics.txt", K)


def nyu_raw(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    raw = np.full((480, 640), 917, np.uint16)  # 351.3 / (1092.5 - 917) = 2.0017 m
    for i in range(2):
        rgb = np.zeros((480, 640, 3), np.uint8)
        (folder / f"r-{100 + i}.25-77.ppm").write_bytes(b"P6 640 480 255\n" + rgb.tobytes())
        # The recorder wrote its own byte order into a format that is big-endian.
        (folder / f"d-{100 + i}.26-78.pgm").write_bytes(b"P5 640 480 65535\n" + raw.tobytes())


MAKERS: dict[str, Callable[[Path], None]] = {
    "tum": tum,
    "open3d": open3d,
    "bop": bop,
    "sevenscenes": sevenscenes,
    "scannet": scannet,
    "sunrgbd": sunrgbd,
    "kitti": kitti,
    "middlebury": middlebury,
    "rig": rig,
    "pairs": pairs,
    "nyu_raw": nyu_raw,
}


def made(folder: Path, layout: str) -> Dataset:
    MAKERS[layout](folder / "set")
    return open_dataset(folder / "set")


@pytest.mark.parametrize("layout", MAKERS)
def test_a_layout_is_recognised_and_read(tmp_path: Path, layout: str) -> None:
    data = made(tmp_path, layout)
    assert data.layout == layout
    assert len(data) == (3 if layout == "tum" else 2)
    assert len({frame.name for frame in data}) == len(data)
    scene = data[0].scene()
    assert scene.valid.any()
    assert json.dumps(data.describe())
    if scene.depth is not None:
        assert np.nanmedian(scene.depth) == pytest.approx(2.0, rel=2e-3)


@pytest.mark.parametrize("layout", ["tum", "open3d", "bop", "sevenscenes", "scannet"])
def test_poses_are_camera_to_world(tmp_path: Path, layout: str) -> None:
    pose = made(tmp_path, layout)[0].T_world_camera
    assert pose == pytest.approx(POSE, abs=1e-9)


@pytest.mark.parametrize("layout", ["open3d", "bop", "sevenscenes", "scannet", "sunrgbd", "pairs"])
def test_the_cameras_of_the_files_are_used(tmp_path: Path, layout: str) -> None:
    camera = made(tmp_path, layout)[0].intrinsics
    assert camera is not None
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == (100, 100, 49.5, 39.5)


def test_holes_stay_holes(tmp_path: Path) -> None:
    for layout in ("tum", "bop", "sunrgbd", "middlebury", "pairs"):
        seen = made(tmp_path / layout, layout)[0].read_depth()
        assert np.isnan(seen[:5]).all()
        assert np.isfinite(seen[5:]).all()


def test_middlebury_2014(tmp_path: Path) -> None:
    middlebury_2014(tmp_path)
    frame = open_dataset(tmp_path)[0]
    assert frame.name == "Piano"
    seen = frame.read_depth()  # 100 px * 1 m / (40 + 10)
    assert seen[10] == pytest.approx(2.0)
    assert np.isnan(seen[:5]).all()


def test_kitti_frames_are_trinocular(tmp_path: Path) -> None:
    scene = made(tmp_path, "kitti")[1].scene()
    assert scene.shape == (500,)
    assert scene.second_colors is not None


def test_a_rigs_depth_is_registered(tmp_path: Path) -> None:
    data = made(tmp_path, "rig")
    assert data[0].rig is not None
    assert data.describe()["registered"] is False
    assert np.array_equal(data[0].scene().colors, RGB)


def test_what_is_given_comes_first(tmp_path: Path) -> None:
    pairs(tmp_path)
    camera = Intrinsics(50.0, 50.0, 50.0, 40.0)
    frame = open_dataset(tmp_path, intrinsics=camera, depth_scale="tum")[0]
    assert frame.intrinsics == camera
    assert np.nanmax(frame.read_depth()) == pytest.approx(0.4)


def test_layouts_by_name_and_alias(tmp_path: Path) -> None:
    open3d(tmp_path)
    assert open_dataset(tmp_path).layout == "open3d"
    assert open_dataset(tmp_path, "redwood").layout == "open3d"
    assert open_dataset(tmp_path, "pairs").layout == "pairs"
    with pytest.raises(GeohueError, match="choose one of tum"):
        open_dataset(tmp_path, "nope")


@pytest.mark.parametrize("layout", [*LAYOUTS])
def test_an_empty_folder_is_no_data_set(tmp_path: Path, layout: str) -> None:
    with pytest.raises(GeohueError, match="none of the known layouts"):
        open_dataset(tmp_path)
    with pytest.raises(GeohueError):
        open_dataset(tmp_path, layout)


@pytest.mark.parametrize("name", ["../x", "/etc/passwd", "a/../../b", "", "a\0b"])
def test_lists_lead_nowhere_else(tmp_path: Path, name: str) -> None:
    with pytest.raises(GeohueError, match="outside"):
        inside(tmp_path, name)


def test_a_list_that_leads_out_is_refused(tmp_path: Path) -> None:
    tum(tmp_path)
    text(tmp_path / "rgb.txt", "100.0 ../../../etc/passwd\n")
    with pytest.raises(GeohueError, match="outside"):
        open_dataset(tmp_path)


@pytest.mark.parametrize(
    ("layout", "file", "content", "cause"),
    [
        ("tum", "depth.txt", "soon depth/0.png\n", "no numbers"),
        ("bop", "scene_camera.json", "{", "damaged JSON"),
        ("bop", "scene_camera.json", "[]", "no cameras"),
        ("bop", "scene_camera.json", '{"0": {"cam_K": [1], "depth_scale": 1}}', "no number"),
        ("scannet", "intrinsic/intrinsic_depth.txt", "1 2 3", "no 4 x 4"),
        ("kitti", "training/calib/000000.txt", "P2: 1\n", "no line Tr_velo"),
    ],
)
def test_damaged_lists_are_named(
    tmp_path: Path, layout: str, file: str, content: str, cause: str
) -> None:
    MAKERS[layout](tmp_path)
    text(tmp_path / file, content)
    with pytest.raises(GeohueError, match=cause) as caught:
        open_dataset(tmp_path)
    assert Path(file).name in str(caught.value)


def test_a_file_that_vanished_is_an_error_of_its_frame(tmp_path: Path) -> None:
    data = made(tmp_path, "pairs")
    (tmp_path / "set" / "000000-depth.png").unlink()
    with pytest.raises(GeohueError, match="no such file"):
        data[0].scene()
    assert data[1].scene().shape == SIZE


def test_azure_recordings_are_refused_with_the_way_out(tmp_path: Path) -> None:
    (tmp_path / "a.mkv").write_bytes(b"\x1aE\xdf\xa3")
    with pytest.raises(GeohueError, match="export its frames"):
        open_dataset(tmp_path / "a.mkv")


def test_labelled_nyu(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py", reason="needs geohue[datasets]")
    with h5py.File(tmp_path / "nyu_depth_v2_labeled.mat", "w") as file:
        file["images"] = RGB.transpose(2, 1, 0)[None]
        file["depths"] = np.full((1, 100, 80), 2.0, np.float32)
    data = open_dataset(tmp_path)
    assert data.layout == "nyu_labelled"
    assert np.array_equal(data[0].read_color(), RGB)
    assert data[0].read_depth().shape == SIZE


def test_info_tells_what_it_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tum(tmp_path)
    assert run(["info", str(tmp_path), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["layout"], facts["n_frames"], facts["depth_scale"]) == ("tum", 3, "tum")
    assert facts["frame_median_depth_m"] == pytest.approx(2.0)
    rows = struct.pack("<8f", 0, 0, 1, 0, 1, 0, 1, 0)
    (tmp_path / "scan.bin").write_bytes(rows)
    assert run(["info", str(tmp_path / "scan.bin"), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["read_as"] == "arrays"
    assert facts["colors"] is False
    assert run(["info", str(tmp_path / "rgb")]) == 2
    assert "none of the known layouts" in capsys.readouterr().err


REAL = {
    "sevenscenes": ("sevenscenes", 40),
    "open3d_testdata/examples/TestData/RGBD": ("open3d", 5),
    "mosd": ("pairs", 45),
    "nyuv2": ("pairs", 200),
    "uoc_demo/data/demo": ("pairs", 9),
    "slambook2/ch5/rgbd": ("pairs", 5),
    "ist_maizena2/cam1": ("rig", 11),
    "herrera_kinect_2rgb": ("rig", 11),
    "kitti_stereo_lidar/demo": ("kitti", 1),
    "middlebury2006_third": ("middlebury", 10),
}


@pytest.mark.parametrize("name", REAL)
def test_real_data_sets(data_dir: Path, name: str) -> None:
    layout, count = REAL[name]
    data = open_dataset(data_dir / name)
    assert data.layout == layout
    assert len(data) >= count
    if layout != "rig":  # those are registered in the tests of the sensors
        assert data[0].scene().valid.any()


def test_real_nyu_raw_is_registered(data_dir: Path) -> None:
    from geohue.read import read_color, read_depth
    from geohue.sensors import register_depth

    folder = data_dir / "open3d_testdata" / "examples" / "TestData" / "RGBD" / "other_formats"
    rgb = read_color(folder / "NYU_color.ppm")
    raw = read_depth(folder / "NYU_depth.pgm", "nyu-raw").depth
    seen = register_depth(raw, nyu_rig(), (640, 480))
    assert edge_agreement(rgb, seen) > 1.5 * edge_agreement(rgb, raw)
