"""What the command line says, word for word."""

from __future__ import annotations

import os
import struct
import subprocess
import sys
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest

from geohue import GeohueError
from geohue.cli.app import run
from geohue.read import read_color, read_labels
from geohue.results import write_ply, write_png

RNG = np.random.default_rng(0)


def said(arguments: list[str], capsys: pytest.CaptureFixture[str], status: int = 2) -> list[str]:
    assert run(arguments) == status
    return capsys.readouterr().err.splitlines()


def bomb(width: int, height: int) -> bytes:
    """A PNG whose header announces more than there is."""

    def chunk(name: bytes, content: bytes) -> bytes:
        sealed = name + content
        return struct.pack(">I", len(content)) + sealed + struct.pack(">I", zlib.crc32(sealed))

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", b"") + chunk(b"IEND", b"")


def test_a_header_bomb_is_told_by_its_true_size(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "bomb.png"
    for width, height in ((60_000, 50_000), (13_000, 12_000)):
        file.write_bytes(bomb(width, height))
        assert said(["segment", str(file), "--cues", "color"], capsys) == [
            f"geohue: error: {file}: announces {width} x {height} pixels, more than 134217728 in "
            "all; make it smaller first"
        ]


def test_calibrate_counts_left_and_right(capsys: pytest.CaptureFixture[str]) -> None:
    left = [f"left{n:02}.jpg" for n in range(13)]
    right = [f"right{n:02}.jpg" for n in range(5)]
    assert said(["calibrate", *left, *right], capsys) == [
        "geohue: error: 13 left pictures and 5 right pictures: give a right one for every left "
        "one, and no other"
    ]
    mixed = [name for pair in zip(left, right, strict=False) for name in pair]
    assert said(["calibrate", *mixed], capsys) == [
        "geohue: error: 5 left pictures and 5 right pictures: give all left ones first, then all "
        "right ones in the same order"
    ]
    assert said(["calibrate", "a.jpg", "b.jpg", "c.jpg"], capsys) == [
        "geohue: error: 3 pictures: give as many right ones as left ones"
    ]


def test_evaluate_asks_whether_depth_is_labels(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    labels, depth = tmp_path / "labels.png", tmp_path / "depth.png"
    write_png(labels, np.repeat(np.arange(1, 5, dtype=np.uint16), 15)[None].repeat(40, 0))
    noisy = 1000 + np.arange(60)[None] + RNG.integers(0, 20, (40, 60))
    write_png(depth, noisy.astype(np.uint16))
    n_values = len(np.unique(noisy))
    (line,) = said(["evaluate", str(labels), str(depth)], capsys)
    start = f"geohue: error: {depth}: is that a label image? Its {n_values} values lie in "
    assert line.startswith(start)
    assert line.endswith(" pieces, like those of a depth map or a photograph; give labels.png")


def test_superpixels_are_labels(tmp_path: Path) -> None:
    rows, columns = np.indices((120, 160)) // 6
    pieces = (rows * 27 + columns + 1).astype(np.uint16)
    write_png(tmp_path / "labels.png", pieces)
    assert np.array_equal(read_labels(tmp_path / "labels.png"), pieces)


@pytest.fixture
def photo(tmp_path: Path) -> Path:
    image = cv2.GaussianBlur(RNG.integers(0, 255, (120, 160, 3)).astype(np.uint8), (0, 0), 2)
    cv2.imwrite(str(tmp_path / "photo.jpg"), image)
    return tmp_path / "photo.jpg"


def test_a_damaged_jpeg_is_refused_in_geohues_words(
    photo: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    whole = photo.read_bytes()
    photo.write_bytes(whole[: len(whole) // 2] + b"\xff\xd9")
    assert run(["segment", str(photo), "--cues", "color"]) == 2
    assert capfd.readouterr().err == (
        f"geohue: error: {photo}: is cut short or damaged (Corrupt JPEG data: premature end of "
        "data segment); copy or export it again\n"
    )
    photo.write_bytes(whole)
    assert read_color(photo).shape == (120, 160, 3)


def test_what_others_write_while_a_picture_is_read_is_kept(
    capfd: pytest.CaptureFixture[str],
) -> None:
    from geohue.read.images.quiet import listened

    with listened() as lines:
        os.write(2, b"from a thread\nCorrupt JPEG data: 3 extraneous bytes before marker 0xd9\n")
    assert lines == ["Corrupt JPEG data: 3 extraneous bytes before marker 0xd9"]
    assert capfd.readouterr().err == "from a thread\n"


def test_odd_points_are_counted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    points = RNG.normal(size=(400, 3)).astype(np.float32)
    points[:5], points[5:7], points[7] = np.nan, np.inf, 3e7
    file = tmp_path / "odd.ply"
    write_ply(file, points, np.zeros((400, 3), np.uint8), np.zeros(400, np.int32))
    assert said(["info", str(file)], capsys, 0) == [
        "geohue: warning: 7 of 400 points have no finite coordinates and are left out",
        "geohue: warning: 1 of 400 points lies over 10000 times farther out than most: remove "
        "what is garbage, since the extent of the scene counts",
    ]


class TestFrames:
    @pytest.fixture
    def frame(self, tmp_path: Path) -> list[str]:
        write_png(tmp_path / "rgb.png", RNG.integers(0, 255, (48, 64, 3)).astype(np.uint8))
        write_png(tmp_path / "depth.png", np.full((12, 16), 1500, np.uint16))
        write_png(tmp_path / "wide.png", np.full((12, 30), 1500, np.uint16))
        return [str(tmp_path / name) for name in ("rgb.png", "depth.png", "wide.png")]

    def test_scaled_depth(self, frame: list[str], capsys: pytest.CaptureFixture[str]) -> None:
        assert said(["info", *frame[:2], "--intrinsics", "60,60,31.5,23.5"], capsys, 0) == [
            "geohue: warning: the depth map of 16 x 12 is taken to show the view of the image and "
            "scaled to its 64 x 48; register it first if it does not"
        ]

    def test_another_shape(self, frame: list[str], capsys: pytest.CaptureFixture[str]) -> None:
        assert said(["info", frame[0], frame[2]], capsys) == [
            f"geohue: error: {frame[2]}: differs in shape from {frame[0]}: 64 x 48 and 30 x 12; "
            "register the depth to the image first (geohue register, "
            "geohue.sensors.register_depth)"
        ]

    def test_no_intrinsics(self, frame: list[str], capsys: pytest.CaptureFixture[str]) -> None:
        assert said(["info", *frame[:2]], capsys, 0)[-1] == (
            "geohue: warning: no intrinsics given: assuming a typical depth camera (fx = fy = 52 "
            "px, centre of the image)"
        )

    @pytest.mark.parametrize(
        ("options", "message"),
        [
            (["--least", "2"], "--least has nothing to compare with: give --confidence too"),
            (
                ["--min-depth", "3", "--max-depth", "2"],
                "--min-depth 3.0 and --max-depth 2.0 leave no depth between them",
            ),
            (
                ["--max-depth", "1"],
                "no depth is left within --min-depth, --max-depth and the least confidence: "
                "widen them",
            ),
        ],
    )
    def test_depth_that_is_used(
        self,
        options: list[str],
        message: str,
        frame: list[str],
        capsys: pytest.CaptureFixture[str],
    ) -> None:
        assert said(["info", *frame[:2], *options], capsys) == [f"geohue: error: {message}"]

    def test_the_library_says_it_with_arguments(self, frame: list[str]) -> None:
        from geohue import Scene

        with pytest.raises(GeohueError) as caught:
            Scene.from_rgbd(frame[0], frame[1], min_depth=3, max_depth=2)
        assert str(caught.value) == "min_depth=3 and max_depth=2 leave no depth between them"


def test_a_cloud_without_colours(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "bare.xyz"
    np.savetxt(file, RNG.normal(size=(50, 3)))
    assert said(["segment", str(file), "--cues", "color", "--json"], capsys) == [
        "geohue: error: the scene has no colours: go by --cues geometry"
    ]
    assert said(["info", str(file)], capsys, 0) == [
        "geohue: warning: no colours: the geometry alone tells the parts apart"
    ]


INTERRUPTED = """
import sys, geohue.cli.{module} as command
from geohue.cli.app import run
def stop(*_, **__):
    raise KeyboardInterrupt
{patch}
sys.exit(run({arguments!r}))
"""


@pytest.mark.parametrize(
    ("module", "patch", "arguments", "message"),
    [
        (
            "segment",
            "import geohue.segmentation.driver as d; d.segment = stop",
            ["segment", "--sample", "boxes", "-o", "{out}"],
            "no results were written",
        ),
        (
            "batch",
            "import geohue.studies.batch as b; b.batch = stop",
            ["batch", "{folder}", "-o", "{out}", "--cues", "color"],
            "the frames that are done are kept in {out}; the same command with --resume goes on",
        ),
        (
            "pieces",
            "import geohue.large as l; l.segment_file = stop",
            ["segment", "{folder}/a.ply", "--memory", "2GB", "-o", "{out}"],
            "what is done is kept in {out}; the same command with --resume goes on",
        ),
    ],
)
def test_ctrl_c_says_what_is_kept(
    module: str, patch: str, arguments: list[str], message: str, tmp_path: Path
) -> None:
    write_png(tmp_path / "a.png", np.zeros((8, 8, 3), np.uint8))
    names = {"folder": str(tmp_path), "out": str(tmp_path / "out")}
    given = [argument.format(**names) for argument in arguments]
    script = INTERRUPTED.format(module=module, patch=patch, arguments=given)
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 130
    last = done.stderr.strip().splitlines()[-1]
    assert last == f"geohue: error: interrupted: {message.format(**names)}"
