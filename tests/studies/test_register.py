"""``geohue register`` and depth units by name: files in, files out."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from geohue import GeohueError
from geohue.cli.app import run
from geohue.read import read_color, read_depth
from geohue.read.images.depth_units import DEPTH_UNITS
from geohue.read.scenes.scenes import read_scene
from geohue.results import write_png
from geohue.results.rig import write_rig
from geohue.sensors import Lens, PosedCamera, Rig
from geohue.studies.register import to_millimetres
from sensors.rigs import BENT, CAMERA, beside


def files(folder: Path, rig: Rig | None = None) -> list[str]:
    """A wall at 2 m with a post at 1 m, the picture of both, and the calibration."""
    depth = np.full((80, 100), 2000, np.uint16)
    depth[:, 45:55] = 1000
    rgb = np.full((80, 100, 3), 90, np.uint8)
    rgb[:, 35:45] = (200, 50, 50)
    write_png(folder / "depth.png", depth)
    write_png(folder / "color.png", rgb)
    write_rig(folder / "rig.json", rig or beside(0.1))
    return [str(folder / name) for name in ("color.png", "depth.png")]


def test_registers_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = files(tmp_path)
    calib = ["--calib", str(tmp_path / "rig.json")]
    assert run(["register", *given, *calib, "-o", str(tmp_path / "out"), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["files"] == ["depth_registered.png", "intrinsics.json"]
    assert facts["edge_agreement"] > 5
    seen = read_depth(tmp_path / "out" / "depth_registered.png").depth
    assert seen[40, 35:45] == pytest.approx(1.0)
    assert np.isnan(seen[40, 45:50]).all()
    scene = read_scene(
        given[0], tmp_path / "out" / "depth_registered.png", tmp_path / "out" / "intrinsics.json"
    )
    assert scene.warnings == ()


def test_undistorts(tmp_path: Path) -> None:
    rig = Rig((PosedCamera(Lens(CAMERA, BENT)),), Lens(CAMERA))
    given = files(tmp_path, rig)
    arguments = ["--calib", str(tmp_path / "rig.json"), "-o", str(tmp_path), "--undistort"]
    assert run(["register", *given, *arguments]) == 0
    assert read_color(tmp_path / "color_undistorted.png").shape == (80, 100, 3)
    assert "dist" not in json.loads((tmp_path / "intrinsics.json").read_text())


@pytest.mark.parametrize(
    ("change", "cause"),
    [
        (["--camera", "3"], "no number 3"),
        (["--depth-scale", "furlong"], "one of m, mm"),
        (["--calib", "missing.json"], "no such file"),
    ],
)
def test_errors_are_one_line_and_leave_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], change: list[str], cause: str
) -> None:
    given = files(tmp_path)
    calib = [] if "--calib" in change else ["--calib", str(tmp_path / "rig.json")]
    assert run(["register", *given, *calib, *change, "-o", str(tmp_path / "out")]) == 2
    message = capsys.readouterr().err.strip()
    assert cause in message
    assert "\n" not in message
    assert not (tmp_path / "out").exists()


def test_a_picture_of_another_shape_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = files(tmp_path)
    write_png(tmp_path / "color.png", np.zeros((80, 80, 3), np.uint8))
    assert run(["register", *given, "--calib", str(tmp_path / "rig.json"), "-o", "x"]) == 2
    assert "another shape" in capsys.readouterr().err


@pytest.mark.parametrize("name", DEPTH_UNITS)
def test_every_unit_reads_a_picture(tmp_path: Path, name: str) -> None:
    write_png(tmp_path / "depth.png", np.array([[0, 800, 801]], np.uint16))
    depth = read_depth(tmp_path / "depth.png", name).depth
    assert depth.shape == (1, 3)
    assert name in ("kinect", "nyu-raw") or np.isnan(depth[0, 0])


def test_units_by_hand(tmp_path: Path) -> None:
    file = tmp_path / "depth.png"
    write_png(file, np.array([[5000]], np.uint16))
    assert read_depth(file, "tum").depth[0, 0] == 1.0
    assert read_depth(file, "TUM").depth[0, 0] == 1.0
    assert read_depth(file, "0.0002").depth[0, 0] == pytest.approx(1.0)
    # SUN: 1234 mm rotated by three bits to the left
    write_png(file, np.array([[1234 << 3]], np.uint16))
    assert read_depth(file, "sun").depth[0, 0] == pytest.approx(1.234)
    # NYU raw: disparity 741.2 is a metre; 741 with its bytes exchanged
    write_png(file, np.array([[741]], np.uint16).byteswap())
    assert read_depth(file, "nyu-raw").depth[0, 0] == pytest.approx(351.3 / (1092.5 - 741))
    np.save(tmp_path / "depth.npy", np.ones((2, 2), np.float32))
    with pytest.raises(GeohueError, match="for 16-bit pictures"):
        read_depth(tmp_path / "depth.npy", "sun")


def test_tum_depth_read_as_millimetres_is_doubted(tmp_path: Path) -> None:
    write_png(tmp_path / "depth.png", np.full((4, 4), 20000, np.uint16))
    assert "depth_scale=tum" in read_depth(tmp_path / "depth.png").warnings[0]
    assert read_depth(tmp_path / "depth.png", "tum").warnings == ()
    assert read_depth(tmp_path / "depth.png", 0.001).warnings == ()


def test_an_implausible_view_is_doubted(tmp_path: Path) -> None:
    color, depth = files(tmp_path)
    fine = read_scene(color, depth, "100,100,49.5,39.5")
    narrow = read_scene(color, depth, "5000,5000,49.5,39.5")
    aside = read_scene(color, depth, "100,100,640,512")
    assert fine.warnings == ()
    assert "implausible" in narrow.warnings[0]
    assert "implausible" in aside.warnings[0]


def test_millimetres_are_exact() -> None:
    depth = np.arange(1, 65536, dtype=np.float32)[None] / 1000
    assert np.array_equal(to_millimetres(depth)[0], np.arange(1, 65536))


def test_real_units(data_dir: Path) -> None:
    folder = data_dir / "open3d_testdata" / "examples" / "TestData" / "RGBD" / "other_formats"
    medians = {"SUN_depth.png": ("sun", 2.72), "TUM_depth.png": ("tum", 2.42)}
    medians["NYU_depth.pgm"] = ("nyu-raw", 3.27)
    for name, (unit, median) in medians.items():
        depth = read_depth(folder / name, unit)
        assert np.nanmedian(depth.depth) == pytest.approx(median, abs=0.01)
        assert depth.warnings == ()


def notes_of(arguments: list[str], capsys: pytest.CaptureFixture[str], status: int) -> list[str]:
    assert run(arguments) == status
    return capsys.readouterr().err.splitlines()


def test_depth_of_another_size_than_the_rig(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    small = Rig(beside(0.1).cameras, Lens(CAMERA.scaled_to(50, 40)))
    color, depth = files(tmp_path, small)
    calib = ["--calib", str(tmp_path / "rig.json"), "-o", str(tmp_path / "out")]
    assert notes_of(["register", color, depth, *calib], capsys, 2) == [
        f"geohue: error: {depth}: has the size of the picture, 100 x 80, and not that of the depth "
        "camera, 50 x 40: is it registered already? Then give it to 'geohue segment' as it is"
    ]
    write_png(depth_file := tmp_path / "square.png", np.full((60, 60), 2000, np.uint16))
    assert notes_of(["register", color, str(depth_file), *calib], capsys, 2) == [
        f"geohue: error: {depth_file}: is 60 x 60, the calibration is for 50 x 40: another shape; "
        "give the picture that belongs to the calibration"
    ]


def test_an_alignment_no_better_than_chance_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    color, depth = files(tmp_path)
    rgb = np.random.default_rng(0).integers(0, 255, (80, 100, 3)).astype(np.uint8)
    write_png(Path(color), rgb)  # whose edges are everywhere
    calib = ["--calib", str(tmp_path / "rig.json"), "-o", str(tmp_path / "out")]
    (line,) = notes_of(["register", color, depth, *calib], capsys, 0)
    assert line.endswith(
        " times as well as by chance, which is no alignment: check R and T (depth to colour, T in "
        "metres), the camera and the depth scale"
    )
    flat = np.full((80, 100), 2000, np.uint16)
    write_png(Path(depth), flat)
    assert notes_of(["register", color, depth, *calib], capsys, 0) == [
        "geohue: warning: the depth has no edge of an object: how well it lies cannot be measured"
    ]


def test_a_calibration_beside_pairs_does_not_make_them_registered(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("rgb", "depth"):
        (tmp_path / name).mkdir()
    color, depth = files(tmp_path)
    Path(color).rename(tmp_path / "rgb" / "0.png")
    Path(depth).rename(tmp_path / "depth" / "0.png")
    assert run(["info", str(tmp_path)]) == 0
    seen = capsys.readouterr()
    assert "registered         not known" in seen.out
    assert (
        f"geohue: warning: {tmp_path / 'rig.json'} calibrates a depth and a colour camera: the "
        "depth maps are taken to be registered already; if they are as the sensor gave them, use "
        "geohue register"
    ) in seen.err.splitlines()
    assert run(["segment", str(tmp_path), "-k", "2", "--json", "--preset", "fast"]) == 0
    assert "use geohue register" in capsys.readouterr().err
