"""A LAS file goes through unchanged but for `segment_id`: laspy compares."""

from __future__ import annotations

import struct
from dataclasses import replace
from pathlib import Path
from typing import Any
from uuid import UUID

import numpy as np
import pytest
from numpy.typing import NDArray

from geohue import GeohueError, Scene, Segmentation, segment_file
from geohue.read import read_cloud
from geohue.read.clouds.chunks import open_chunks
from geohue.results.las import write_las
from geohue.results.las_copy import write_las_like
from geohue.results.outputs import write_results

laspy = pytest.importorskip("laspy", reason="needs geohue[clouds]")
pytest.importorskip("lazrs", reason="needs geohue[clouds]")

N = 300
VERSIONS = {**dict.fromkeys((0, 1), "1.1"), **dict.fromkeys((2, 3), "1.2"), 4: "1.3", 5: "1.3"}
OURS = (4, 22204)  # the records of the extra bytes and of the compression


def make_las(file: Path, form: int, version: str | None = None, *, extra: bool = True) -> Path:
    """A file whose every bit is used: attributes at random, map coordinates, a CRS, a record."""
    rng = np.random.default_rng(form)
    header = laspy.LasHeader(point_format=form, version=version or VERSIONS.get(form, "1.4"))
    header.scales, header.offsets = [0.001, 0.002, 0.01], [500_000.0, 4_000_000.0, 100.0]
    header.uuid = UUID(int=7)
    header.system_identifier = "a scanner"
    header.vlrs.append(laspy.VLR("LASF_Projection", 34735, "geo", struct.pack("<4H", 1, 1, 0, 0)))
    header.vlrs.append(laspy.VLR("somebody", 9, "", b"\1\2\3"))
    if extra:
        header.add_extra_dim(laspy.ExtraBytesParams("height", "f4", description="above ground"))
        header.add_extra_dim(
            laspy.ExtraBytesParams("pair", "2u2", scales=[0.5, 0.5], offsets=[1.0, 2.0])
        )
    rows = rng.integers(0, 256, (N, header.point_format.size), dtype=np.uint8)
    rows[:, :12] = rng.integers(-(10**6), 10**6, (N, 3)).astype("<i4").view(np.uint8)
    if extra:
        rows[:, -8:-4] = rng.random((N, 1)).astype("<f4").view(np.uint8)
    las = laspy.LasData(header)
    array = np.frombuffer(rows.tobytes(), header.point_format.dtype()).copy()
    las.points = laspy.ScaleAwarePointRecord(
        array, header.point_format, header.scales, header.offsets
    )
    if header.version.minor >= 4:
        las.evlrs = laspy.vlrs.vlrlist.VLRList()
        las.evlrs.append(laspy.VLR("somebody", 10, "behind", b"\4" * 100))
    las.write(str(file))
    return file


def assert_unchanged(before: Path, after: Path, labels: NDArray[np.int32]) -> None:
    one, other = laspy.read(before), laspy.read(after)
    for name in one.point_format.dimension_names:
        if name != "segment_id":
            np.testing.assert_array_equal(np.asarray(one[name]), np.asarray(other[name]), name)
    np.testing.assert_array_equal(other["segment_id"], labels)
    kept = ("scales", "offsets", "mins", "maxs", "uuid", "version", "creation_date", "point_count")
    kept += ("system_identifier", "generating_software", "number_of_points_by_return")
    for name in kept:
        np.testing.assert_array_equal(getattr(one.header, name), getattr(other.header, name), name)
    assert one.header.global_encoding.value == other.header.global_encoding.value
    assert one.header.point_format.id == other.header.point_format.id
    assert _records(one.vlrs) == _records(other.vlrs)
    assert _records(one.evlrs or []) == _records(other.evlrs or [])
    mine = [d for d in one.point_format.extra_dimensions if d.name != "segment_id"]
    theirs = [d for d in other.point_format.extra_dimensions if d.name != "segment_id"]
    assert [(d.name, d.dtype, d.description) for d in mine] == [
        (d.name, d.dtype, d.description) for d in theirs
    ]


def _records(items: Any) -> list[tuple[str, int, str, bytes]]:
    return [
        (item.user_id, item.record_id, item.description, item.record_data_bytes())
        for item in items
        if item.record_id not in OURS
    ]


def scene_of(file: Path) -> tuple[Scene, Segmentation]:
    """The scene of a file, as `read_scene` gives it, with segments made up."""
    cloud = read_cloud(file)
    colors = np.zeros(cloud.points.shape, np.uint8)
    x, y, z = cloud.offset.tolist()
    scene = replace(Scene.from_cloud(cloud.points, colors), source=file, offset=(x, y, z))
    labels = np.random.default_rng(1).integers(-1, 70_000, scene.size).astype(np.int32)
    return scene, Segmentation(labels, 70_000, 1.0, None, [], "nncsc", "paper", "fusion", 0, {})


@pytest.mark.parametrize("form", range(11))
def test_every_point_format_in_memory(tmp_path: Path, form: int) -> None:
    file = make_las(tmp_path / "in.las", form)
    scene, seg = scene_of(file)
    write_results(tmp_path / "out", scene, seg, ["las"], lean=True)
    assert_unchanged(file, tmp_path / "out" / "segmented.las", seg.labels)
    if form > 8:
        with pytest.raises(GeohueError, match="do not go through lazrs unchanged"):
            write_results(tmp_path / "out", scene, seg, ["laz"], lean=True)
        return
    write_results(tmp_path / "out", scene, seg, ["laz"], lean=True)
    assert_unchanged(file, tmp_path / "out" / "segmented.laz", seg.labels)
    # And back: from a compressed file to one that is not.
    write_las_like(tmp_path / "back.las", tmp_path / "out" / "segmented.laz", seg.labels[::-1])
    assert_unchanged(file, tmp_path / "back.las", seg.labels[::-1])
    assert (tmp_path / "back.las").stat().st_size == file.stat().st_size + 4 * N + 192


@pytest.mark.parametrize("form", range(11))
def test_every_point_format_in_pieces(tmp_path: Path, form: int) -> None:
    file, out = make_las(tmp_path / "in.las", form), tmp_path / "out"
    formats = ["ply", "las"] if form > 8 else ["ply", "las", "laz"]
    segment_file(file, out, 2, weight=1.0, cues="geometry", processes=1, formats=formats, lean=True)
    labels = np.load(out / "labels.npy")
    assert set(labels.tolist()) == {0, 1}
    for ending in formats[1:]:
        assert_unchanged(file, out / f"segmented.{ending}", labels)
    scene, seg = scene_of(file)
    write_results(tmp_path / "whole", scene, replace(seg, labels=labels, k=2))
    written = [(folder / "segmented.ply").read_bytes() for folder in (out, tmp_path / "whole")]
    head = [content.split(b"end_header\n")[0] for content in written]
    assert head[0] == head[1]
    assert b"property double x" in head[0]
    one, other = (_rows_of(content) for content in written)
    np.testing.assert_array_equal(one["xyz"], other["xyz"])
    np.testing.assert_array_equal(one["label"], other["label"])
    np.testing.assert_array_equal(one["xyz"], laspy.read(file).xyz)


def _rows_of(content: bytes) -> NDArray[np.void]:
    row = [("xyz", "<f8", 3), ("rgb", "u1", 3), ("label", "<i4"), ("scalar", "<f4")]
    return np.frombuffer(content.split(b"end_header\n")[1], np.dtype(row))


@pytest.mark.parametrize("version", ["1.3", "1.4"])
def test_waveforms_in_the_file_move_with_their_record(tmp_path: Path, version: str) -> None:
    file = make_las(tmp_path / "in.las", 4, version)
    data = bytearray(file.read_bytes())
    waves = b"\0\0" + b"LASF_Spec".ljust(16, b"\0") + struct.pack("<HQ", 65535, 50) + b"w" * 32
    struct.pack_into("<H", data, 6, 2)  # the waveforms are inside
    struct.pack_into("<Q", data, 227, len(data))
    file.write_bytes(bytes(data) + waves + b"samples..." * 5)
    write_las_like(tmp_path / "out.las", file, np.zeros(N, np.int32))
    after = (tmp_path / "out.las").read_bytes()
    (place,) = struct.unpack_from("<Q", after, 227)
    assert after[place:] == waves + b"samples..." * 5
    assert_unchanged(file, tmp_path / "out.las", np.zeros(N, np.int32))


def test_bytes_that_nobody_describes_stay(tmp_path: Path) -> None:
    file = make_las(tmp_path / "in.las", 0, extra=False)
    data = file.read_bytes()
    start = struct.unpack_from("<I", data, 96)[0]
    rows = np.frombuffer(data[start:], np.uint8).reshape(N, 20)
    longer = np.hstack([rows, np.full((N, 3), 77, np.uint8)])
    head = bytearray(data[:start])
    struct.pack_into("<H", head, 105, 23)
    file.write_bytes(bytes(head) + longer.tobytes())
    write_las_like(tmp_path / "out.las", file, np.arange(N))
    after = laspy.read(tmp_path / "out.las")
    assert after["segment_id"].tolist() == list(range(N))
    raw = after.points.array.view(np.uint8).reshape(N, 27)
    np.testing.assert_array_equal(raw[:, :23], longer)


def test_segments_of_an_earlier_run_are_replaced(tmp_path: Path) -> None:
    file = make_las(tmp_path / "in.las", 3)
    first, second = tmp_path / "first.las", tmp_path / "second.las"
    write_las_like(first, file, np.zeros(N, np.int32))
    write_las_like(second, first, np.arange(N))
    assert_unchanged(first, second, np.arange(N, dtype=np.int32))
    assert second.stat().st_size == first.stat().st_size
    labels = open_chunks(second)
    labels.close()
    np.testing.assert_array_equal(read_cloud(second).labels, np.arange(N))


def test_a_segment_id_of_another_type_gets_another_name(tmp_path: Path) -> None:
    las = laspy.read(make_las(tmp_path / "in.las", 3))
    las.add_extra_dim(laspy.ExtraBytesParams("segment_id", "u1"))
    las["segment_id"] = np.arange(N) % 5
    las.write(str(tmp_path / "u1.las"))
    write_las_like(tmp_path / "out.las", tmp_path / "u1.las", np.full(N, 70_000))
    after = laspy.read(tmp_path / "out.las")
    assert set(after["segment_id"].tolist()) == {70_000}
    np.testing.assert_array_equal(after["segment_id_before"], np.arange(N) % 5)


def test_what_does_not_fit_is_refused(tmp_path: Path) -> None:
    file = make_las(tmp_path / "in.las", 3)
    with pytest.raises(GeohueError, match="300 points, but there are 5 labels"):
        write_las_like(tmp_path / "out.las", file, np.zeros(5, np.int32))
    cut = tmp_path / "cut.las"
    cut.write_bytes(file.read_bytes()[:-100])
    with pytest.raises(GeohueError, match="cut short"):
        write_las_like(tmp_path / "out.las", cut, np.zeros(N, np.int32))
    data = bytearray(file.read_bytes())
    at = data.index(b"height") - 2  # the type of the first extra dimension
    data[at] = 7
    cut.write_bytes(data)
    with pytest.raises(GeohueError, match="more extra dimensions than its points have"):
        write_las_like(tmp_path / "out.las", cut, np.zeros(N, np.int32))
    assert sorted(p.name for p in tmp_path.iterdir()) == ["cut.las", "in.las"]


def test_map_coordinates_of_other_clouds_stay(tmp_path: Path) -> None:
    """Of a text file, whose digits float32 cannot hold, in PLY and LAS."""
    rng = np.random.default_rng(0)
    xyz = np.round(rng.random((50, 3)) * 10 + [500_000, 4_000_000, 100], 3)
    rgb = rng.integers(0, 256, (50, 3))
    np.savetxt(tmp_path / "a.xyz", np.hstack([xyz, rgb]), fmt=["%.3f"] * 3 + ["%d"] * 3)
    from geohue.read.scenes.scenes import read_scene

    scene = read_scene(tmp_path / "a.xyz")
    labels = np.zeros(50, np.int32)
    seg = Segmentation(labels, 1, 1.0, None, [], "nncsc", "paper", "fusion", 0, {})
    write_results(tmp_path / "out", scene, seg, ["las"])
    ply = _rows_of((tmp_path / "out" / "segmented.ply").read_bytes())
    np.testing.assert_allclose(ply["xyz"], xyz, atol=1e-5, rtol=0)
    np.testing.assert_allclose(laspy.read(tmp_path / "out" / "segmented.las").xyz, xyz, atol=1e-5)


def test_arrays_far_from_the_origin_come_back_there(tmp_path: Path) -> None:
    xyz = np.random.default_rng(0).random((60, 3)) + 1e5
    scene = Scene.from_cloud(xyz, np.zeros((60, 3), np.uint8))
    seg = Segmentation(np.zeros(60, np.int32), 1, 1.0, None, [], "nncsc", "paper", "fusion", 0, {})
    write_results(tmp_path / "out", scene, seg)
    ply = _rows_of((tmp_path / "out" / "segmented.ply").read_bytes())
    np.testing.assert_allclose(ply["xyz"], xyz, atol=1e-6, rtol=0)


def test_pieces_of_other_clouds_as_las(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    rows = np.hstack([rng.random((400, 3)), rng.integers(0, 256, (400, 3))])
    rows[7, :3] = np.nan
    np.save(tmp_path / "a.npy", rows)
    out = tmp_path / "out"
    segment_file(tmp_path / "a.npy", out, 2, weight=1.0, processes=1, formats=["laz"], lean=True)
    labels, known = np.load(out / "labels.npy"), np.arange(400) != 7
    found = laspy.read(out / "segmented.laz")
    np.testing.assert_array_equal(found["segment_id"], labels[known])
    np.testing.assert_allclose(found.xyz, rows[known, :3], atol=1e-6)
    write_las(tmp_path / "b.las", rows[known, :3], rows[known, 3:], labels[known])
    np.testing.assert_array_equal(laspy.read(tmp_path / "b.las").xyz, found.xyz)
