"""The command line: its contract, and one line for every mistake."""

from __future__ import annotations

import json
import struct
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from geohue import Scene
from geohue.cli.app import run
from geohue.read import read_levels, read_ply
from geohue.results import write_ply
from geohue.segmentation import warm

CONTRACT_KEYS = {
    "k",
    "weight",
    "quality",
    "weight_curve",
    "method",
    "preset",
    "seed",
    "timings_s",
    "n_points",
    "n_labelled",
    "warnings",
    "version",
    "detail",
    "levels",
}


@pytest.fixture
def frame(tmp_path: Path, three_boxes: tuple[Scene, NDArray[np.int32]]) -> tuple[str, str]:
    """A frame on disk, with a hole in its depth."""
    scene, _ = three_boxes
    assert scene.depth is not None
    depth = np.nan_to_num(scene.depth * 1000).round().astype(np.uint16)
    depth[10:20, 20:40] = 0
    color_file, depth_file = tmp_path / "rgb.png", tmp_path / "depth.png"
    cv2.imwrite(str(color_file), scene.colors[..., ::-1])
    cv2.imwrite(str(depth_file), depth)
    return str(color_file), str(depth_file)


@pytest.fixture
def cloud(tmp_path: Path) -> str:
    """Two groups of points as a PLY file."""
    rng = np.random.default_rng(0)
    group = np.arange(600) % 2
    points = rng.normal(0, 0.2, (600, 3)) + group[:, None] * [3, 0, 0]
    colors = np.array([[200, 30, 30], [30, 30, 200]], np.uint8)[group]
    file = tmp_path / "cloud.ply"
    write_ply(file, points, colors, group)
    return str(file)


class TestSegment:
    def test_a_frame_gives_all_files_of_the_contract(
        self, frame: tuple[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        out = tmp_path / "new" / "out"
        assert run(["segment", *frame, "-k", "3", "-o", str(out), "--json"]) == 0
        printed = json.loads(capsys.readouterr().out)
        assert printed == json.loads((out / "result.json").read_text())
        assert set(printed) >= CONTRACT_KEYS
        assert (printed["k"], printed["preset"], printed["detail"]) == (3, "best", None)
        assert printed["n_labelled"] == printed["n_points"] == 60 * 90
        assert {"features", "cuts", "merge", "fill", "total"} <= set(printed["timings_s"])
        labels = cv2.imread(str(out / "labels.png"), cv2.IMREAD_UNCHANGED)
        assert labels is not None
        assert labels.dtype == np.uint16
        assert np.unique(labels).tolist() == [1, 2, 3]
        made = sorted(file.name for file in out.iterdir())
        assert made == [
            "borders.png",
            "labels.png",
            "levels.npz",
            "overlay.png",
            "result.json",
            "segmented.ply",
        ]
        level = read_levels(out / "levels.npz").with_segments(3)
        np.testing.assert_array_equal(level + 1, labels)
        ply = read_ply(out / "segmented.ply")
        assert ply.labels is not None
        assert len(ply.points) == 60 * 90 - 200
        header = (out / "segmented.ply").read_bytes().split(b"end_header")[0].decode()
        wanted = ["format binary_little_endian", *(f"property float {a}" for a in "xyz")]
        wanted += ["property int label", "property float scalar_label"]
        assert all(line in header for line in wanted)

    def test_the_paper_has_a_curve_and_no_levels(
        self, frame: tuple[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        out = tmp_path / "out"
        given = ["segment", *frame, "-k", "3", "--preset", "paper"]
        assert run([*given, "-o", str(out), "--json"]) == 0
        printed = json.loads(capsys.readouterr().out)
        assert (printed["preset"], printed["levels"], printed["detail"]) == ("paper", None, None)
        assert len(printed["weight_curve"]) > 1
        assert {"features", "weight", "cut", "fill", "total"} <= set(printed["timings_s"])
        made = {file.name for file in out.iterdir()}
        assert "weight_curve.png" in made
        assert not made & {"borders.png", "levels.npz"}
        # A weight that was given has no curve to draw.
        assert run([*given, "--lambda", "2", "-o", str(tmp_path / "given")]) == 0
        assert made - {"weight_curve.png"} == {f.name for f in (tmp_path / "given").iterdir()}

    def test_detail_is_a_level(
        self, frame: tuple[str, str], capsys: pytest.CaptureFixture[str]
    ) -> None:
        found = {}
        for detail in ("-1.5", "coarse", "auto", "fine", "20"):
            assert run(["segment", *frame, "--detail", detail, "--json"]) == 0
            found[detail] = json.loads(capsys.readouterr().out)
        ks = {detail: result["k"] for detail, result in found.items()}
        assert ks["-1.5"] == ks["coarse"] <= ks["auto"] == 3 <= ks["fine"] <= ks["20"]
        assert ks["20"] > 3
        levels = found["auto"]["levels"]
        # One tree, but a region can lose its last pixel where the borders of a level are drawn.
        for result in found.values():
            assert abs(result["levels"]["n"] - levels["n"]) <= 0.1 * levels["n"]
            mine = dict(map(tuple, result["levels"]["segments"]))
            if not isinstance(result["detail"], str):
                continue
            assert mine[{"coarse": -1.5, "auto": 0, "fine": 1.5}[result["detail"]]] == result["k"]
        told = dict(map(tuple, levels["segments"]))
        assert list(told) == [-2, -1.5, -1, -0.5, 0, 0.5, 1, 1.5, 2]
        assert [told[d] for d in (-1.5, 0, 1.5)] == [ks["coarse"], ks["auto"], ks["fine"]]
        assert [found[d]["detail"] for d in ("-1.5", "coarse")] == [-1.5, "coarse"]

    @pytest.mark.parametrize(
        ("options", "says"),
        [
            ([], "3 segments, regions merged, "),
            (["--cues", "color", "--detail", "-20"], "1 segment, regions merged by colour alone, "),
            (["-k", "2", "--lambda", "0"], "2 segments, by colour alone, "),
            (["-k", "2", "--lambda", "inf"], "2 segments, by geometry alone, "),
            (["-k", "3", "--lambda", "0.5"], "3 segments, weight 0.5, "),
            (["-k", "2", "--cues", "color", "--method", "kmeans"], "2 segments, by colour alone, "),
        ],
    )
    def test_what_is_printed_is_words(
        self,
        options: list[str],
        says: str,
        frame: tuple[str, str],
        tmp_path: Path,
        capsys: pytest.CaptureFixture[str],
    ) -> None:
        assert run(["segment", *frame, *options, "-o", str(tmp_path / "out")]) == 0
        assert capsys.readouterr().out.startswith(says)

    def test_in_pieces_detail_means_the_same(
        self, cloud: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        given = ["segment", cloud, "-o", str(tmp_path / "out"), "--processes", "1"]
        assert "give one of them" in line_of([*given, "--detail", "fine", "-k", "2"], capsys)
        assert run([*given, "--detail", "fine"]) == 0
        assert ", regions merged, " in capsys.readouterr().out
        assert run([*given, "-k", "2", "--lambda", "inf"]) == 0
        assert capsys.readouterr().out.startswith("2 segments, by geometry alone, ")

    def test_a_cloud_gives_labels_in_its_order(self, cloud: str, tmp_path: Path) -> None:
        out = tmp_path / "out"
        assert run(["segment", cloud, "-k", "2", "-o", str(out)]) == 0
        labels = np.load(out / "labels.npy")
        assert labels.dtype == np.int32
        assert set(labels[::2]) != set(labels[1::2])
        assert not (out / "labels.png").exists()

    def test_options_reach_the_library(
        self, frame: tuple[str, str], capsys: pytest.CaptureFixture[str]
    ) -> None:
        options = [
            "-k",
            "2",
            "--lambda",
            "0.5",
            "--preset",
            "fast",
            "--seed",
            "3",
            "--no-fill",
            "--threads",
            "1",
            "--json",
        ]
        assert run(["segment", *frame, *options, "--intrinsics", "80,80,45,30"]) == 0
        result = json.loads(capsys.readouterr().out)
        assert (result["weight"], result["preset"], result["seed"]) == (0.5, "fast", 3)
        assert result["n_labelled"] == result["n_points"] - 200
        assert result["warnings"] == []
        assert result["weight_curve"] == []

    def test_single_cues_have_no_weight(
        self, frame: tuple[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert run(["segment", frame[0], "-k", "2", "--cues", "color", "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["weight"] == 0
        out = str(tmp_path / "g")
        assert run(["segment", *frame, "-k", "2", "--cues", "geometry", "-o", out, "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["weight"] is None

    def test_scale_of_the_depth(
        self, frame: tuple[str, str], capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert run(["info", *frame, "--depth-scale", "0.01", "--json"]) == 0
        facts = json.loads(capsys.readouterr().out)
        assert 9 < facts["median_depth_m"] < 19

    def test_without_a_terminal_standard_error_has_warnings_only(
        self, frame: tuple[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert run(["segment", *frame, "-k", "3", "-o", str(tmp_path / "o")]) == 0
        lines = capsys.readouterr().err.splitlines()
        assert len(lines) == 1
        assert lines[0].startswith("geohue: warning: no intrinsics given")


class TestInfo:
    def test_frame(self, frame: tuple[str, str], capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["info", *frame]) == 0
        text = capsys.readouterr().out
        assert "RGB-D frame" in text
        assert "90  60" in text
        assert "5200" in text

    def test_cloud(self, cloud: str, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["info", cloud, "--json"]) == 0
        facts = json.loads(capsys.readouterr().out)
        assert (facts["kind"], facts["n_points"]) == ("cloud", 600)


class TestEvaluate:
    def test_json_keys(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        truth = np.repeat([1, 2], 8).reshape(4, 4).astype(np.uint16)
        for name, labels in (("gt", truth), ("pred", 3 - truth)):
            cv2.imwrite(str(tmp_path / f"{name}.png"), labels)
        assert (
            run(["evaluate", *(str(tmp_path / f"{n}.png") for n in ("pred", "gt")), "--json"]) == 0
        )
        scores = json.loads(capsys.readouterr().out)
        assert (scores["voi_bits"], scores["rand"], scores["covering"]) == (0, 1, 1)


def line_of(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """Run a command that must fail; returns its one line."""
    assert run(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    lines = captured.err.splitlines()
    assert len(lines) == 1, captured.err
    assert lines[0].startswith("geohue: error: ")
    return lines[0]


class TestMistakes:
    @pytest.mark.parametrize(
        ("options", "message"),
        [
            (["-k", "0"], "-k 0: expected"),
            (["-k", "1000001"], "1 to 1000000"),
            (["-k", "few"], '-k few: expected "auto" or a whole number'),
            (["--lambda", "-1"], "--lambda -1.0: expected"),
            (
                ["--lambda", "x"],
                "--lambda x: expected auto, quality, agreement, consensus or a number",
            ),
            (["--cues", "depth"], "fusion, color, geometry"),
            (["--preset", "ultra"], "paper, fast, best"),
            (["--detail", "high"], "--detail high: expected coarse, auto, fine or a number"),
            (["--detail", "nan"], "--detail nan: expected coarse, auto, fine or a number"),
            (
                ["--detail", "fine", "--preset", "paper"],
                "--detail fine, and --preset paper has no levels to choose from: leave out "
                "--detail, or choose --preset best or fast",
            ),
            (
                ["--detail", "2", "--lambda", "0.5"],
                "--detail 2.0, and --lambda 0.5 has no levels to choose from: leave out --detail, "
                "or --lambda",
            ),
            (["--detail", "2", "--method", "kmeans"], "and --method kmeans has no levels"),
            (["--detail", "2", "-k", "3"], "--detail 2.0 and -k 3: give one of them"),
            (["--method", "magic"], "--method magic: choose one of"),
            (["--intrinsics", "1,2,3"], "1,2,3"),
            (["--depth-scale", "0"], "depth scale 0"),
            (["--threads", "0"], "threads is 0"),
            (["--wrong"], "--wrong"),
        ],
    )
    def test_options(
        self,
        options: list[str],
        message: str,
        frame: tuple[str, str],
        tmp_path: Path,
        capsys: pytest.CaptureFixture[str],
    ) -> None:
        out = tmp_path / "out"
        assert message in line_of(["segment", *frame, *options, "-o", str(out)], capsys)
        assert not out.exists()

    def test_files(
        self, frame: tuple[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        color, depth = frame
        small = tmp_path / "small.png"
        cv2.imwrite(str(small), np.ones((5, 5), np.uint16))
        cut = tmp_path / "cut.png"
        cut.write_bytes(Path(depth).read_bytes()[:300])
        empty = tmp_path / "empty.png"
        cv2.imwrite(str(empty), np.zeros((60, 90), np.uint16))
        out = ["-o", str(tmp_path / "out")]
        for arguments, message in (
            ([color, str(tmp_path / "none.png")], "none.png: no such file"),
            ([str(tmp_path), depth], "is a folder"),
            ([color, color], "one channel"),
            ([color, str(small)], "differs in shape"),
            ([color, str(cut)], "cut.png"),
            ([color, str(empty)], "all depth is missing"),
            ([color], "all depth is missing"),
            ([], "no scene"),
            (["--sample", "car"], "motorcycle"),
            ([color, "--sample", "motorcycle"], "choose one"),
        ):
            assert message in line_of(["segment", *arguments, *out], capsys)
        assert not (tmp_path / "out").exists()

    def test_clouds(
        self, cloud: str, frame: tuple[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        bare = tmp_path / "bare.ply"
        header = "ply\nformat binary_little_endian 1.0\nelement vertex 1\n"
        header += "".join(f"property float {axis}\n" for axis in "xyz") + "end_header\n"
        bare.write_bytes(header.encode() + struct.pack("<3f", 0, 0, 0))
        cut = tmp_path / "cut.ply"
        cut.write_bytes(Path(cloud).read_bytes()[:-40])
        pcd = tmp_path / "cut.pcd"
        pcd.write_text("VERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\n")
        for arguments, message in (
            ([str(bare), "--cues", "color"], "no colours: go by --cues geometry"),
            ([str(cut)], "cut.ply"),
            ([str(pcd)], "cut.pcd"),
            ([cloud, frame[1]], "own geometry"),
            ([frame[0], cloud], "give it alone"),
            ([cloud, "-k", "255", "--components"], "cloud without"),
        ):
            assert message in line_of(["segment", *arguments], capsys)

    def test_a_folder_that_cannot_be_made(
        self, frame: tuple[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
    ) -> None:
        (tmp_path / "file").write_text("here")
        blocked = str(tmp_path / "file" / "out")
        assert "cannot be made" in line_of(["segment", *frame, "-k", "2", "-o", blocked], capsys)

    def test_no_command_and_version(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["--version"]) == 0
        assert capsys.readouterr().out.startswith("geohue ")
        assert run(["--help"]) == 0
        assert "segment" in capsys.readouterr().out
        assert "fly" in line_of(["fly"], capsys)


@pytest.mark.parametrize(
    ("problem", "says"),
    [
        (OSError(28, "No space left on device", "labels.npy"), "labels.npy: No space left"),
        (MemoryError(), "out of memory: give a smaller scene"),
    ],
)
def test_what_the_machine_lacks_is_one_line(
    problem: Exception,
    says: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def fail() -> None:
        raise problem

    monkeypatch.setattr(warm, "compile_all", fail)
    assert run(["warm"]) == 2
    told = capsys.readouterr().err
    assert told.startswith(f"geohue: error: {says}")
    assert told.count("\n") == 1


def test_neither_the_library_nor_the_command_line_starts_with_heavy_libraries() -> None:
    heavy = ("numpy", "scipy", "cv2", "numba", "skimage", "sklearn", "matplotlib", "trimesh")
    for module in ("geohue", "geohue.cli"):
        code = f"import sys, {module}; print([m for m in {heavy} if m in sys.modules])"
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
        assert done.stdout.strip() == "[]", module
