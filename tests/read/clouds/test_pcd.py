"""PCD: the three encodings against pypcd4, organised clouds, and files that are broken."""

from __future__ import annotations

import struct
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pypcd4.pypcd4 import Encoding, PointCloud

from geohue.errors import GeohueError
from geohue.read import read_cloud, read_pcd

RELAXED = settings(
    max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
ENCODINGS = ["ascii", "binary", "binary_compressed"]


def header(
    fields: str = "x y z rgb",
    types: str = "F F F F",
    sizes: str = "4 4 4 4",
    width: int = 3,
    height: int = 1,
    data: str = "binary",
    points: int | None = None,
) -> bytes:
    points = width * height if points is None else points
    return (
        f"# .PCD v0.7\nVERSION 0.7\nFIELDS {fields}\nSIZE {sizes}\nTYPE {types}\n"
        f"COUNT {' '.join('1' * len(fields.split()))}\nWIDTH {width}\nHEIGHT {height}\n"
        f"VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {points}\nDATA {data}\n"
    ).encode()


def saved(folder: Path, data: bytes) -> Path:
    file = folder / "cloud.pcd"
    file.write_bytes(data)
    return file


def rows(count: int = 3) -> bytes:
    return b"".join(struct.pack("<fffI", i, 2, 3, 0x010203 + i) for i in range(count))


def compressed(columns: list[np.ndarray[Any, Any]]) -> bytes:
    raw = b"".join(column.tobytes() for column in columns)
    packed: bytes = import_module("lzf").compress(raw)
    return struct.pack("<II", len(packed), len(raw)) + packed


BINARY = header() + rows()
TEXT = header(types="F F F U", data="ascii") + b"0 2 3 66051\n1 2 3 66052\n2 2 3 66053\n"
COLUMNS = [np.arange(3, dtype="<f4"), np.full(3, 2, "<f4"), np.full(3, 3, "<f4")]
COLUMNS.append(np.arange(3, dtype="<u4") + 0x010203)
COMPRESSED = header(data="binary_compressed") + compressed([np.repeat(c, 40) for c in COLUMNS])
COMPRESSED = COMPRESSED.replace(b"WIDTH 3", b"WIDTH 120").replace(b"POINTS 3", b"POINTS 120")


@RELAXED
@given(encoding=st.sampled_from(ENCODINGS), count=st.integers(12, 40), seed=st.integers(0, 2**16))
def test_reads_what_pypcd4_writes(tmp_path: Path, encoding: str, count: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.integers(-9, 9, (count, 3)).astype(np.float32)
    colors = rng.integers(0, 256, (count, 3)).astype(np.uint8)
    labels = rng.integers(0, 5, count).astype(np.uint32)
    packed = PointCloud.encode_rgb(colors)
    cloud = PointCloud.from_points(
        [*points.T, packed.ravel(), labels],
        ("x", "y", "z", "rgb", "label"),
        (np.float32, np.float32, np.float32, np.float32, np.uint32),
    )
    file = tmp_path / "cloud.pcd"
    cloud.save(file, Encoding(encoding))
    ours = read_pcd(file)
    np.testing.assert_array_equal(ours.points, points)
    np.testing.assert_array_equal(ours.labels, labels)
    if encoding != "ascii":  # pypcd4 writes too few digits of the packed colour into text
        np.testing.assert_array_equal(ours.colors, colors)


@pytest.mark.parametrize("data", [BINARY, TEXT, TEXT.replace(b"2 3 ", b"2\t 3  ")])
def test_packed_colors(tmp_path: Path, data: bytes) -> None:
    cloud = read_cloud(saved(tmp_path, data))
    assert cloud.points.tolist() == [[0, 2, 3], [1, 2, 3], [2, 2, 3]]
    assert cloud.colors is not None
    assert cloud.colors.tolist() == [[1, 2, 3], [1, 2, 4], [1, 2, 5]]


def test_compressed_and_organised(tmp_path: Path) -> None:
    cloud = read_pcd(saved(tmp_path, COMPRESSED))
    assert cloud.points[::40].tolist() == [[0, 2, 3], [1, 2, 3], [2, 2, 3]]
    data = COMPRESSED.replace(b"WIDTH 120", b"WIDTH 40").replace(b"HEIGHT 1", b"HEIGHT 3")
    organised = read_pcd(saved(tmp_path, data))
    assert organised.points.shape == (3, 40, 3)
    assert organised.colors is not None
    assert organised.colors[:, 0].tolist() == [[1, 2, 3], [1, 2, 4], [1, 2, 5]]


def test_old_header_without_count_points_and_with_padding(tmp_path: Path) -> None:
    data = header("x y z _", sizes="4 4 4 1", types="F F F U").replace(b"POINTS 3\n", b"")
    data = data.replace(b"COUNT 1 1 1 1", b"COUNT 1 1 1 4")
    cloud = read_pcd(saved(tmp_path, data + rows()))
    assert cloud.points[:, 0].tolist() == [0, 1, 2]
    assert cloud.colors is None


BROKEN = {
    "not pcd": (b"hello\n", "not a PCD"),
    "too many points": (header(width=10**12) + rows(), "cut short"),
    "overflowing size": (header(width=2**40, height=2**40) + rows(), "header"),
    "points are not width x height": (header(points=5) + rows(), "header"),
    "unknown encoding": (header(data="zip") + rows(), "encoding"),
    "unknown type": (header(types="F F F Q") + rows(), "header"),
    "wrong size": (header(sizes="4 4 4 3") + rows(), "header"),
    "fields do not fit": (header(fields="x y z") + rows(), "header"),
    "no x": (header(fields="a y z rgb") + rows(), "x, y, z"),
    "no points": (header(width=0), "no points"),
    "word": (TEXT.replace(b"2 2 3", b"2 ? 3"), "row 3"),
    "uncompressed size is a lie": (
        header(data="binary_compressed") + struct.pack("<II", 8, 2**32 - 1) + b"a" * 8,
        "damaged",
    ),
    "too dense to be true": (
        header(data="binary_compressed", width=10**6)
        + struct.pack("<II", 8, 16 * 10**6)
        + b"a" * 8,
        "damaged",
    ),
}


@pytest.mark.parametrize(("data", "words"), BROKEN.values(), ids=BROKEN.keys())
def test_broken_files_say_what_is_wrong(tmp_path: Path, data: bytes, words: str) -> None:
    file = saved(tmp_path, data)
    with pytest.raises(GeohueError) as error:
        read_pcd(file)
    assert str(error.value).startswith(str(file))
    assert words in str(error.value)


@pytest.mark.parametrize("data", [BINARY, COMPRESSED, TEXT[:-6]])
def test_cut_anywhere(tmp_path: Path, data: bytes) -> None:
    for size in range(len(data)):
        with pytest.raises(GeohueError, match=r"cloud\.pcd: "):
            read_pcd(saved(tmp_path, data[:size]))


@RELAXED
@given(
    base=st.sampled_from([BINARY, TEXT, COMPRESSED]),
    edits=st.lists(st.tuples(st.integers(0, 500), st.integers(0, 255)), max_size=6),
    end=st.binary(max_size=20),
)
def test_damage_gives_a_cloud_or_one_error(
    tmp_path: Path, base: bytes, edits: list[tuple[int, int]], end: bytes
) -> None:
    data = bytearray(base)
    for position, value in edits:
        data[position % len(data)] = value
    file = saved(tmp_path, bytes(data) + end)
    message = f"{file}: "
    try:
        read_pcd(file)
    except GeohueError as error:
        message = str(error)
    assert message.startswith(f"{file}: ")


@pytest.mark.parametrize(
    ("name", "shape"),
    [
        ("pcl_tutorials/region_growing_rgb_tutorial.pcd", (480, 640, 3)),
        ("pcl_tutorials/table_scene_mug_stereo_textured.pcd", (480, 640, 3)),
        ("mosd/raw/learn3.pcd", (480, 640, 3)),
        ("open3d_testdata/examples/TestData/fragment.pcd", (113662, 3)),
    ],
)
def test_real_clouds_agree_with_pypcd4(
    data_dir: Path, tmp_path: Path, name: str, shape: tuple[int, ...]
) -> None:
    cloud = read_cloud(data_dir / name)
    other = PointCloud.from_path(data_dir / name)
    assert cloud.points.shape == shape
    np.testing.assert_array_equal(cloud.points.reshape(-1, 3), other.numpy(("x", "y", "z")))
    packed = other.pc_data["rgba" if "rgba" in other.fields else "rgb"]
    assert cloud.colors is not None
    blue = np.ascontiguousarray(packed).view(np.uint32) & 255
    np.testing.assert_array_equal(cloud.colors.reshape(-1, 3)[:, 2], blue)
    data = (data_dir / name).read_bytes()
    for size in (90, 1000, len(data) // 2):  # not the last bytes, which PCL pads
        with pytest.raises(GeohueError):
            read_pcd(saved(tmp_path, data[:size]))
