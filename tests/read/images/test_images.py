"""Pictures and depth maps: formats, scales, marks for missing depth, and files cut short."""

from __future__ import annotations

import io
import struct
import zlib
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from PIL import Image

from geohue.errors import GeohueError
from geohue.read import read_color, read_depth
from geohue.results import write_png

RELAXED = settings(
    max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def smooth(height: int = 24, width: int = 32) -> NDArray[np.uint8]:
    y, x = np.mgrid[:height, :width]
    return np.stack([x * 7 % 256, y * 9 % 256, (x + y) * 4 % 256], -1).astype(np.uint8)


def encoded(extension: str, pixels: NDArray[Any]) -> bytes:
    """Encode RGB pixels."""
    ok, data = cv2.imencode(extension, np.ascontiguousarray(pixels[..., ::-1]))
    assert ok
    return data.tobytes()


def saved(folder: Path, name: str, data: bytes) -> Path:
    file = folder / name
    file.write_bytes(data)
    return file


@pytest.mark.parametrize("extension", [".png", ".ppm", ".bmp", ".tiff"])
def test_lossless_colors(tmp_path: Path, extension: str) -> None:
    file = saved(tmp_path, "c" + extension, encoded(extension, smooth()))
    np.testing.assert_array_equal(read_color(file), smooth())


@pytest.mark.parametrize("extension", [".jpg", ".webp"])
def test_lossy_colors(tmp_path: Path, extension: str) -> None:
    file = saved(tmp_path, "c" + extension, encoded(extension, smooth()))
    assert np.abs(read_color(file).astype(int) - smooth()).mean() < 12


def test_grey_alpha_palette_and_16_bits(tmp_path: Path) -> None:
    grey = smooth()[..., 0]
    write_png(tmp_path / "grey.png", grey)
    np.testing.assert_array_equal(read_color(tmp_path / "grey.png"), np.dstack([grey] * 3))
    write_png(tmp_path / "deep.png", smooth().astype(np.uint16) << 8)
    np.testing.assert_array_equal(read_color(tmp_path / "deep.png"), smooth())
    Image.fromarray(np.dstack([smooth(), grey])).save(tmp_path / "alpha.png")
    np.testing.assert_array_equal(read_color(tmp_path / "alpha.png"), smooth())
    flat = np.zeros((4, 4, 3), np.uint8) + np.uint8(9)
    Image.fromarray(flat).convert("P", palette=Image.Palette.ADAPTIVE).save(tmp_path / "p.png")
    np.testing.assert_array_equal(read_color(tmp_path / "p.png"), flat)


def test_float_colors(tmp_path: Path) -> None:
    unit = smooth().astype(np.float32) / np.float32(255)
    np.testing.assert_array_equal(
        read_color(saved(tmp_path, "f.tiff", encoded(".tiff", unit))), smooth()
    )
    with pytest.raises(GeohueError, match=r"0\.\.1"):
        read_color(saved(tmp_path, "g.tiff", encoded(".tiff", unit * 3)))


DEPTH = np.array([[0, 500, 1000], [65535, 2000, 4000]], np.uint16)
METRES = [[np.nan, 0.5, 1.0], [np.nan, 2.0, 4.0]]


@pytest.mark.parametrize("extension", [".png", ".pgm", ".tiff"])
def test_integer_depth(tmp_path: Path, extension: str) -> None:
    ok, data = cv2.imencode(extension, DEPTH)
    assert ok
    image = read_depth(saved(tmp_path, "d" + extension, data.tobytes()))
    np.testing.assert_allclose(image.depth, METRES, rtol=1e-6)
    assert image.depth.dtype == np.float32
    assert image.scale == 0.001
    assert image.warnings == ()


FLOATS = np.array([[0, 0.5, 1], [np.inf, 2, 4], [-1, np.nan, 3]], np.float32)


@pytest.mark.parametrize("extension", [".npy", ".npz", ".pfm", ".tiff"])
def test_float_depth_is_metres(tmp_path: Path, extension: str) -> None:
    file = tmp_path / ("d" + extension)
    if extension == ".npy":
        np.save(file, FLOATS.astype(">f8"))
    elif extension == ".npz":
        np.savez_compressed(file, other=np.zeros(3), depth=FLOATS)
    else:
        ok, data = cv2.imencode(extension, FLOATS)
        assert ok
        file.write_bytes(data.tobytes())
    expected = np.where(np.isfinite(FLOATS) & (FLOATS > 0), FLOATS, np.nan)
    np.testing.assert_array_equal(read_depth(file).depth, expected)
    assert read_depth(file, 0.5).scale == 0.5


def test_implausible_depth_names_the_option(tmp_path: Path) -> None:
    write_png(tmp_path / "d.png", np.full((3, 3), 12000, np.uint16))
    assert read_depth(tmp_path / "d.png").warnings == ()
    (warning,) = read_depth(tmp_path / "d.png", 1.0).warnings
    assert "depth_scale" in warning
    write_png(tmp_path / "e.png", np.zeros((3, 3), np.uint16))
    assert "no pixel" in read_depth(tmp_path / "e.png").warnings[0]


@pytest.mark.parametrize("scale", [0.0, -1.0, np.nan, np.inf])
def test_scale_must_be_positive(tmp_path: Path, scale: float) -> None:
    write_png(tmp_path / "d.png", DEPTH)
    with pytest.raises(GeohueError, match="scale"):
        read_depth(tmp_path / "d.png", scale)


def test_colored_depth_is_refused(tmp_path: Path) -> None:
    write_png(tmp_path / "d.png", smooth())
    with pytest.raises(GeohueError, match=r"colour picture.*raw depth"):
        read_depth(tmp_path / "d.png")


def test_arrays_that_are_no_depth(tmp_path: Path) -> None:
    np.savez(tmp_path / "d.npz", a=FLOATS, b=FLOATS)
    with pytest.raises(GeohueError, match="found: a, b"):
        read_depth(tmp_path / "d.npz")
    np.save(tmp_path / "d.npy", np.array([["a"]]))
    with pytest.raises(GeohueError, match="numbers"):
        read_depth(tmp_path / "d.npy")
    huge = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        huge, {"descr": "<f8", "fortran_order": False, "shape": (10**9, 10**9)}
    )
    with pytest.raises(GeohueError, match="cut short"):
        read_depth(saved(tmp_path, "h.npy", huge.getvalue()))


def test_files_that_cannot_be_opened(tmp_path: Path) -> None:
    (tmp_path / "empty.png").touch()
    for path, words in [
        (tmp_path / "none.png", "no such file"),
        (tmp_path, "folder"),
        (tmp_path / "empty.png", "empty"),
        (Path("/dev/zero"), "regular"),
        (Path("a\0b.png"), "file"),
    ]:
        for reader in (read_color, read_depth):
            with pytest.raises(GeohueError, match=words) as error:
                reader(path)
            assert str(error.value).startswith(str(path))


def cuts(data: bytes) -> list[int]:
    return sorted(
        {*range(1, len(data), max(1, len(data) // 60)), *range(len(data) - 20, len(data))}
    )


@pytest.mark.parametrize("extension", [".png", ".jpg", ".ppm", ".bmp", ".webp"])
def test_cut_picture_is_an_error(tmp_path: Path, extension: str) -> None:
    data = encoded(extension, smooth(64, 80))
    for size in cuts(data):
        with pytest.raises(GeohueError, match="cut short"):
            read_color(saved(tmp_path, "c" + extension, data[:size]))


def test_cut_tiff_is_an_error_or_whole(tmp_path: Path) -> None:
    data = encoded(".tiff", smooth())  # its directory comes last, with padding
    for size in cuts(data)[:-8]:
        with pytest.raises(GeohueError, match="cut short"):
            read_color(saved(tmp_path, "c.tiff", data[:size]))


def test_cut_progressive_jpeg_with_a_thumbnail(tmp_path: Path) -> None:
    data = encoded(".jpg", smooth(64, 80))
    inner = encoded(".jpg", smooth(8, 8))
    data = data[:2] + b"\xff\xe5" + struct.pack(">H", len(inner) + 2) + inner + data[2:]
    assert read_color(saved(tmp_path, "c.jpg", data)).shape == (64, 80, 3)
    assert read_color(saved(tmp_path, "c.jpg", data + b"\0trailer")).shape == (64, 80, 3)
    for size in cuts(data):
        with pytest.raises(GeohueError, match="cut short"):
            read_color(saved(tmp_path, "c.jpg", data[:size]))


@pytest.mark.parametrize("name", ["d.png", "d.npy", "d.npz", "d.pfm"])
def test_cut_depth_is_an_error(tmp_path: Path, name: str) -> None:
    file = tmp_path / name
    if name == "d.png":
        write_png(file, np.tile(DEPTH, (9, 9)))
    elif name == "d.pfm":
        file.write_bytes(b"Pf\n3 3\n-1.0\n" + FLOATS.tobytes())
    else:
        (np.save if name == "d.npy" else np.savez)(file, FLOATS)
    data = file.read_bytes()
    for size in cuts(data):
        with pytest.raises(GeohueError, match=name):
            read_depth(saved(tmp_path, name, data[:size]))


def test_enormous_announced_size_is_refused_before_decoding(tmp_path: Path) -> None:
    def chunk(kind: bytes, body: bytes) -> bytes:
        return (
            struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        )

    size = struct.pack(">IIBBBBB", 60000, 60000, 8, 2, 0, 0, 0)
    data = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", size)
    data += chunk(b"IDAT", zlib.compress(b"\0" * 1000)) + chunk(b"IEND", b"")
    with pytest.raises(GeohueError, match="pixels"):
        read_color(saved(tmp_path, "c.png", data))


SAMPLES = {e: encoded(e, smooth()) for e in (".png", ".jpg", ".ppm", ".bmp", ".tiff", ".webp")}


@RELAXED
@given(
    extension=st.sampled_from(sorted(SAMPLES)),
    edits=st.lists(st.tuples(st.integers(0, 5000), st.integers(0, 255)), max_size=4),
    garbage=st.binary(max_size=60),
    replace=st.booleans(),
)
def test_damage_gives_a_picture_or_one_error(
    tmp_path: Path, extension: str, edits: list[tuple[int, int]], garbage: bytes, replace: bool
) -> None:
    data = bytearray(SAMPLES[extension])
    for position, value in edits:
        data[position % min(len(data), 200)] = value
    file = saved(tmp_path, "c" + extension, garbage if replace else bytes(data) + garbage)
    message = f"{file}: "
    try:
        assert read_color(file).shape[2] == 3
        read_depth(file)
    except GeohueError as error:
        message = str(error)
    assert message.startswith(f"{file}: ")


@RELAXED
@given(
    name=st.sampled_from(["d.npy", "d.npz", "d.pfm"]),
    edits=st.lists(st.tuples(st.integers(0, 500), st.integers(0, 255)), max_size=4),
)
def test_damaged_arrays_give_depth_or_one_error(
    tmp_path: Path, name: str, edits: list[tuple[int, int]]
) -> None:
    stream = io.BytesIO()
    if name == "d.pfm":
        stream.write(b"Pf\n3 3\n-1.0\n" + FLOATS.tobytes())
    else:
        (np.save if name == "d.npy" else np.savez)(stream, FLOATS)
    data = bytearray(stream.getvalue())
    for position, value in edits:
        data[position % len(data)] = value
    file = saved(tmp_path, name, bytes(data))
    message = f"{file}: "
    try:
        read_depth(file)
    except GeohueError as error:
        message = str(error)
    assert message.startswith(f"{file}: ")


def test_write_png_round_trip_and_refusal(tmp_path: Path) -> None:
    write_png(tmp_path / "new" / "labels.png", DEPTH)
    with Image.open(tmp_path / "new" / "labels.png") as picture:
        np.testing.assert_array_equal(np.asarray(picture), DEPTH)
    write_png(tmp_path / "c.png", smooth())
    with Image.open(tmp_path / "c.png") as picture:
        np.testing.assert_array_equal(np.asarray(picture), smooth())
    with pytest.raises(GeohueError, match="no picture"):
        write_png(tmp_path / "f.png", np.zeros((2, 2), np.float32))
    assert not (tmp_path / "f.png").exists()


@pytest.mark.parametrize(
    ("name", "median"),
    [
        ("uoc_demo/data/demo/000000-depth.png", (0.3, 1.5)),
        ("sevenscenes/frame-000006.depth.png", (0.5, 4)),
        ("nyuv2/frames/0602/depth.png", (0.8, 6)),
    ],
)
def test_real_depth(data_dir: Path, tmp_path: Path, name: str, median: tuple[float, float]) -> None:
    image = read_depth(data_dir / name)
    assert median[0] < np.nanmedian(image.depth) < median[1]
    assert np.nanmax(image.depth) < 60
    data = (data_dir / name).read_bytes()
    for size in cuts(data)[::8]:
        with pytest.raises(GeohueError, match="cut short"):
            read_depth(saved(tmp_path, "d.png", data[:size]))


def test_real_pictures_agree_with_pillow(data_dir: Path, tmp_path: Path) -> None:
    for name in ("uoc_demo/data/demo/000000-color.png", "opencv_samples/left01.jpg"):
        file = next(data_dir.glob(name), None) or next(data_dir.rglob(Path(name).name))
        with Image.open(file) as picture:
            reference = np.asarray(picture.convert("RGB")).astype(int)
        assert np.abs(read_color(file) - reference).mean() < 1
        data = file.read_bytes()
        for size in cuts(data)[::8]:
            with pytest.raises(GeohueError, match="cut short"):
                read_color(saved(tmp_path, "c" + file.suffix, data[:size]))
