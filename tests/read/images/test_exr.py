"""EXR depth maps: files built by the specification, and damaged ones."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue import GeohueError
from geohue.read import read_depth
from geohue.read.images.exr import read_exr

DEPTH = np.random.default_rng(0).uniform(0.5, 9, (37, 11)).astype(np.float32)
NONE, RLE, ZIPS, ZIP = range(4)


def attribute(name: str, kind: str, value: bytes) -> bytes:
    return f"{name}\0{kind}\0".encode() + struct.pack("<I", len(value)) + value


def coded(raw: bytes, compression: int) -> bytes:
    """Predict and compress a block; as it is if that does not help."""
    if compression == NONE:
        return raw
    values = np.frombuffer(raw, np.uint8)
    halves = np.concatenate([values[0::2], values[1::2]]).astype(np.int64)
    steps = halves.copy()
    steps[1:] = halves[1:] - halves[:-1] + 128
    predicted = (steps & 255).astype(np.uint8).tobytes()
    if compression == RLE:
        parts = [predicted[i : i + 100] for i in range(0, len(predicted), 100)]
        packed = b"".join(struct.pack("<b", -len(p)) + p for p in parts)
        run = predicted[:1] * 5  # the longest start of equal bytes, if there is one
        if predicted.startswith(run):
            rest = predicted[5:]
            parts = [rest[i : i + 100] for i in range(0, len(rest), 100)]
            packed = b"\x04" + run[:1] + b"".join(struct.pack("<b", -len(p)) + p for p in parts)
    else:
        packed = zlib.compress(predicted)
    return packed if len(packed) < len(raw) else raw


def exr(
    channels: dict[str, NDArray[np.generic]], compression: int = ZIP, version: int = 2
) -> bytes:
    kinds = {"u": 0, "f2": 1, "f4": 2}
    names = sorted(channels)
    height, width = channels[names[0]].shape
    listing = b""
    for name in names:
        dtype = channels[name].dtype
        kind = kinds["u" if dtype.kind == "u" else dtype.str[1:]]
        listing += name.encode() + b"\0" + struct.pack("<4i", kind, 0, 1, 1)
    window = struct.pack("<4i", 3, -2, width + 2, height - 3)  # does not begin at zero
    header = struct.pack("<I", 20000630) + struct.pack("<I", version)
    header += attribute("channels", "chlist", listing + b"\0")
    header += attribute("compression", "compression", bytes([compression]))
    header += attribute("dataWindow", "box2i", window) + b"\0"
    lines = 16 if compression == ZIP else 1
    blocks = []
    for top in range(0, height, lines):
        rows = range(top, min(top + lines, height))
        raw = b"".join(channels[name][row].tobytes() for row in rows for name in names)
        block = coded(raw, compression)
        blocks.append(struct.pack("<iI", top - 2, len(block)) + block)
    start = len(header) + 8 * len(blocks)
    offsets = np.cumsum([start, *(len(block) for block in blocks)])[:-1]
    return header + struct.pack(f"<{len(blocks)}Q", *offsets.tolist()) + b"".join(blocks)


@pytest.mark.parametrize("compression", [NONE, RLE, ZIPS, ZIP])
@pytest.mark.parametrize("name", ["Z", "ViewLayer.Depth.Z", "depth", "Y"])
def test_reads_what_the_specification_says(tmp_path: Path, compression: int, name: str) -> None:
    file = tmp_path / "a.exr"
    file.write_bytes(exr({name: DEPTH, "A": np.ones_like(DEPTH)}, compression))
    assert np.array_equal(read_exr(file), DEPTH)
    assert np.array_equal(read_depth(file).depth, DEPTH)


def test_flat_data_compresses_and_comes_back(tmp_path: Path) -> None:
    flat = np.full((40, 30), 2.5, np.float32)
    for compression in (RLE, ZIPS, ZIP):
        (tmp_path / "a.exr").write_bytes(exr({"Z": flat}, compression))
        assert np.array_equal(read_exr(tmp_path / "a.exr"), flat)


def test_half_and_whole_numbers(tmp_path: Path) -> None:
    for values in (DEPTH.astype(np.float16), (DEPTH * 100).astype(np.uint32)):
        (tmp_path / "a.exr").write_bytes(exr({"V": values}))
        assert np.array_equal(read_exr(tmp_path / "a.exr"), values.astype(np.float32))


def test_infinite_background_is_missing(tmp_path: Path) -> None:
    depth = DEPTH.copy()
    depth[0] = 1e10
    depth[1] = np.inf
    (tmp_path / "a.exr").write_bytes(exr({"Z": depth}))
    assert np.isnan(read_depth(tmp_path / "a.exr").depth[1]).all()


@pytest.mark.parametrize(
    ("data", "cause"),
    [
        (exr(dict.fromkeys("RGB", DEPTH)), "picture in colour"),
        (exr({"Z": DEPTH}, version=2 | 0x200), "tiles"),
        (
            exr({"Z": DEPTH}).replace(
                b"compression\0\x01\0\0\0\x03", b"compression\0\x01\0\0\0\x04"
            ),
            "ZIP",
        ),
        (exr({"Z": DEPTH})[:-40], "cut short"),
        (b"EXR?", "not an EXR"),
    ],
    ids=["color", "tiles", "piz", "short", "magic"],
)
def test_refuses_what_it_does_not_read(tmp_path: Path, data: bytes, cause: str) -> None:
    (tmp_path / "a.exr").write_bytes(data)
    with pytest.raises(GeohueError, match=cause):
        read_depth(tmp_path / "a.exr")


@settings(
    max_examples=300, deadline=5000, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(place=st.floats(0, 1), piece=st.binary(min_size=1, max_size=8), head=st.booleans())
def test_damaged_files(tmp_path: Path, place: float, piece: bytes, head: bool) -> None:
    data = exr({"Z": DEPTH})
    at = int(place * (200 if head else len(data)))
    file = tmp_path / "a.exr"
    file.write_bytes(data[:at] + piece + data[at + len(piece) :])
    try:
        shape = read_depth(file).depth.shape
    except GeohueError:
        return
    assert 0 < shape[0] * shape[1] <= 1 << 27
