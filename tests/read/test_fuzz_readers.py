"""Damaged files: whatever the bytes are, a cloud or one GeohueError, and no more memory than due.

Every reader gets whole files with bytes changed, cut out, put in and repeated, headers whose
counts lie, archives that unpack to more than they are, and plain noise. The number of cases is in
`CASES` (for each reader) and in the docs.
"""

from __future__ import annotations

import io
import json
import os
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from geohue import GeohueError
from geohue.datasets import open_dataset
from geohue.read import read_cloud, read_depth
from geohue.read.cameras.rig import read_rig

CASES = int(os.environ.get("GEOHUE_FUZZ_CASES", "150"))
RELAXED = settings(
    max_examples=CASES,
    deadline=5000,  # ms: no hang
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
RNG = np.random.default_rng(0)
XYZ = RNG.normal(0, 3, (30, 3))
RGB = RNG.integers(0, 256, (30, 3)).astype(np.uint8)


def _text(*columns: Any) -> bytes:
    table = np.hstack([np.reshape(c, (len(XYZ), -1)) for c in columns])
    return "\n".join(" ".join(f"{v:g}" for v in row) for row in table).encode()


def _npy() -> bytes:
    file = io.BytesIO()
    np.save(file, np.hstack([XYZ, RGB]))
    return file.getvalue()


def _npz() -> bytes:
    file = io.BytesIO()
    np.savez_compressed(file, points=XYZ, colors=RGB)
    return file.getvalue()


def _colmap() -> bytes:
    data = struct.pack("<Q", len(XYZ))
    for p, c in zip(XYZ, RGB, strict=True):
        data += struct.pack("<QdddBBBdQ", 1, *p, *c, 0.5, 1) + b"\1" * 8
    return data


def _bundler() -> bytes:
    points = "".join(
        f"{' '.join(map(str, p))}\n{' '.join(map(str, c))}\n1 0 1 2.0 3.0\n"
        for p, c in zip(XYZ.tolist(), RGB.tolist(), strict=True)
    )
    return f"# Bundle file v0.3\n1 30\n500 0 0\n1 0 0\n0 1 0\n0 0 1\n0 0 0\n{points}".encode()


def _las(suffix: str) -> Callable[[Path], bytes]:
    def make(folder: Path) -> bytes:
        pytest.importorskip("laspy", reason="needs geohue[clouds]")
        pytest.importorskip("lazrs", reason="needs geohue[clouds]")
        from geohue.results.las import write_las

        write_las(folder / f"whole.{suffix}", XYZ, RGB, np.arange(30))
        return (folder / f"whole.{suffix}").read_bytes()

    return make


def _e57(folder: Path) -> bytes:
    pye57 = pytest.importorskip("pye57", reason="needs geohue[clouds]")
    names = ("cartesianX", "cartesianY", "cartesianZ")
    scan = {name: XYZ[:, i].copy() for i, name in enumerate(names)}
    file = folder / "whole.e57"
    with pye57.E57(str(file), mode="w") as out:
        out.write_scan_raw(scan)
    return file.read_bytes()


FILES: dict[str, Callable[[Path], bytes]] = {
    "a.xyz": lambda _: _text(XYZ, RGB),
    "a.csv": lambda _: b"x,y,z,red,green,blue\n" + _text(XYZ, RGB).replace(b" ", b","),
    "a.pts": lambda _: b"30\n" + _text(XYZ, RGB[:, 0], RGB),
    "a.npy": lambda _: _npy(),
    "a.npz": lambda _: _npz(),
    "a.bin": lambda _: np.hstack([XYZ, XYZ[:, :1]]).astype("<f4").tobytes(),
    "points3D.bin": lambda _: _colmap(),
    "points3D.txt": lambda _: _text(np.arange(30), XYZ, RGB, np.ones((30, 5))),
    "bundle.out": lambda _: _bundler(),
    "a.las": _las("las"),
    "a.laz": _las("laz"),
    "a.e57": _e57,
}


@st.composite
def edits(draw: st.DrawFn) -> list[tuple[str, float, bytes]]:
    """Some changes: where (as a share of the file) and what."""
    kinds = st.sampled_from(["set", "cut", "insert", "end", "repeat", "extreme"])
    extreme = st.sampled_from(
        [b"\xff" * 8, b"\0" * 8, b"\xff\xff\xff\x7f", b"\0\0\0\x80", b"1e999 ", b"-1 ", b"9" * 30]
    )
    change = st.tuples(kinds, st.floats(0, 1), st.one_of(st.binary(max_size=12), extreme))
    return draw(st.lists(change, min_size=1, max_size=6))


def changed(data: bytes, steps: list[tuple[str, float, bytes]]) -> bytes:
    for kind, share, piece in steps:
        # Half of the changes go to the first bytes, where the headers are.
        size = len(data) if share < 0.5 else min(400, len(data))
        place = int(2 * (share % 0.5) * size)
        if kind in ("set", "extreme"):
            data = data[:place] + piece + data[place + len(piece) :]
        elif kind == "insert":
            data = data[:place] + piece + data[place:]
        elif kind == "cut":
            data = data[:place] + data[place + len(piece) :]
        elif kind == "end":
            data = data[:place]
        else:
            data = data[: place + 40] + data[place:]
    return data


def survives(reader: Callable[[Path], object], file: Path) -> None:
    message = f"{file.parent}: read"
    try:
        reader(file)
    except GeohueError as error:
        message = str(error)
    assert str(file.parent) in message
    assert "\n" not in message


@pytest.mark.parametrize("name", FILES)
def test_damaged_clouds(tmp_path: Path, name: str) -> None:
    whole = FILES[name](tmp_path)
    file = tmp_path / name

    @RELAXED
    @given(steps=edits())
    def attempt(steps: list[tuple[str, float, bytes]]) -> None:
        file.write_bytes(changed(whole, steps))
        survives(read_cloud, file)

    file.write_bytes(whole)
    assert read_cloud(file).points.shape == (30, 3)
    attempt()


@pytest.mark.parametrize("name", FILES)
def test_noise_behind_a_true_start(tmp_path: Path, name: str) -> None:
    whole = FILES[name](tmp_path)

    @settings(RELAXED, max_examples=40)
    @given(noise=st.binary(max_size=300), keep=st.integers(0, 400))
    def attempt(noise: bytes, keep: int) -> None:
        (tmp_path / name).write_bytes(whole[:keep] + noise)
        survives(read_cloud, tmp_path / name)

    attempt()


RIGS = {
    "json": json.dumps(
        {
            "depth": {"K": [[500, 0, 320], [0, 500, 240], [0, 0, 1]], "dist": [0.1, 0, 0, 0, 0]},
            "rgb": {"K": [[500, 0, 320], [0, 500, 240], [0, 0, 1]], "dist": [0, 0, 0, 0, 0]},
            "R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
            "T": [-0.02, 0, 0],
        }
    ),
    "yml": "%YAML:1.0\n"
    + "".join(
        f"{name}: !!opencv-matrix\n   rows: {r}\n   cols: {c}\n   dt: d\n   data: {data}\n"
        for name, r, c, data in (
            ("M1", 3, 3, [500, 0, 320, 0, 500, 240, 0, 0, 1]),
            ("D1", 1, 5, [0] * 5),
            ("M2", 3, 3, [500, 0, 320, 0, 500, 240, 0, 0, 1]),
            ("D2", 1, 5, [0] * 5),
            ("R", 3, 3, [1, 0, 0, 0, 1, 0, 0, 0, 1]),
            ("T", 3, 1, [-0.02, 0, 0]),
        )
    ),
    "txt": "P2: 7 0 6 4 0 7 1 0 0 0 1 0\nP3: 7 0 6 -3 0 7 1 2 0 0 1 0\n"
    "R0_rect: 1 0 0 0 1 0 0 0 1\nTr_velo_to_cam: 0 -1 0 0 0 0 -1 0 1 0 0 0\n",
}


@pytest.mark.parametrize("kind", RIGS)
def test_damaged_calibrations(tmp_path: Path, kind: str) -> None:
    file = tmp_path / f"calib.{kind}"

    @RELAXED
    @given(steps=edits())
    def attempt(steps: list[tuple[str, float, bytes]]) -> None:
        file.write_bytes(changed(RIGS[kind].encode(), steps))
        survives(read_rig, file)

    attempt()


LISTS = {
    "tum": ("rgb.txt", "1.0 rgb/1.png\n2.0 rgb/2.png\n"),
    "bop": ("scene_camera.json", '{"1": {"cam_K": [5,0,3,0,5,2,0,0,1], "depth_scale": 1.0}}'),
    "open3d": ("trajectory.log", "0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"),
    "scannet": ("intrinsic/intrinsic_depth.txt", "5 0 3 0\n0 5 2 0\n0 0 1 0\n0 0 0 1\n"),
    "sevenscenes": ("frame-000001.pose.txt", "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"),
    "middlebury": (
        "calib.txt",
        "cam0=[5 0 3; 0 5 2; 0 0 1]\ndoffs=1\nbaseline=9\nwidth=6\nheight=4",
    ),
}


@pytest.mark.parametrize("layout", LISTS)
def test_damaged_lists(tmp_path: Path, layout: str) -> None:
    from geohue.results import write_png

    name, content = LISTS[layout]
    places = ("rgb/1", "color/1", "frame-000001.color", "im0", "depth/1", "frame-000001.depth")
    for place in (*places, "disp0"):
        write_png(tmp_path / f"{place}.png", np.ones((4, 6), np.uint16))
    (tmp_path / "depth.txt").write_text("1.0 depth/1.png\n")
    (tmp_path / "intrinsic").mkdir()

    @RELAXED
    @given(steps=edits())
    def attempt(steps: list[tuple[str, float, bytes]]) -> None:
        (tmp_path / name).write_bytes(changed(content.encode(), steps))
        survives(lambda file: open_dataset(file.parent, layout).describe(), tmp_path / "x")

    (tmp_path / name).write_text(content)
    assert len(open_dataset(tmp_path, layout)) >= 1
    attempt()


# --- sizes that lie ------------------------------------------------------------------------------


def test_an_archive_that_unpacks_to_gigabytes(tmp_path: Path) -> None:
    head = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        head, {"descr": "<f4", "fortran_order": False, "shape": (200_000_000, 3)}
    )
    kind: Any = {"compression": zipfile.ZIP_DEFLATED, "compresslevel": 1}
    with (
        zipfile.ZipFile(tmp_path / "bomb.npz", "w", **kind) as archive,
        archive.open("points.npy", "w", force_zip64=True) as member,
    ):
        member.write(head.getvalue())
        for _ in range(300):
            member.write(bytes(1 << 22))
    assert (tmp_path / "bomb.npz").stat().st_size < 8 << 20
    with pytest.raises(GeohueError, match="unpacks to more than"):
        read_cloud(tmp_path / "bomb.npz")


@pytest.mark.parametrize("suffix", ["las", "laz"])
@pytest.mark.parametrize("count", [2**31, 2**40, 2**64 - 1])
def test_a_las_header_that_announces_too_much(tmp_path: Path, suffix: str, count: int) -> None:
    data = bytearray(_las(suffix)(tmp_path))
    data[247:255] = struct.pack("<Q", count)
    (tmp_path / f"a.{suffix}").write_bytes(bytes(data))
    with pytest.raises(GeohueError, match="do not fit"):
        read_cloud(tmp_path / f"a.{suffix}")


@pytest.mark.parametrize("chunks", [2**31, 2**32 - 1])
def test_a_laz_table_that_announces_too_much(tmp_path: Path, chunks: int) -> None:
    data = bytearray(_las("laz")(tmp_path))
    (start,) = struct.unpack_from("<I", data, 96)
    (table,) = struct.unpack_from("<q", data, start)
    data[table + 4 : table + 8] = struct.pack("<I", chunks)
    (tmp_path / "a.laz").write_bytes(bytes(data))
    with pytest.raises(GeohueError, match="chunks"):
        read_cloud(tmp_path / "a.laz")


def test_a_depth_map_of_noise(tmp_path: Path) -> None:
    @settings(RELAXED, max_examples=60)
    @given(noise=st.binary(min_size=1), unit=st.sampled_from(["sun", "kinect", "tum"]))
    def attempt(noise: bytes, unit: str) -> None:
        (tmp_path / "depth.png").write_bytes(noise)
        survives(lambda file: read_depth(file, unit), tmp_path / "depth.png")

    attempt()
