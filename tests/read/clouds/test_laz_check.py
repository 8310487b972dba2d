"""LAZ files whose sizes lie: refused before the decoder, which would end the whole process."""

from __future__ import annotations

import random
import struct
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from geohue import GeohueError
from geohue.read import read_cloud
from geohue.read.clouds.chunks import open_chunks
from geohue.results.las import write_las

N = 30
MEMORY = 3 << 30  # bytes; the decoder asks for more where a size lies
SIZES = (0, 1, N - 1, N + 1, 255, 65_535, 10**6, 2**24, 2**28, 2**31 - 1, 2**31, 2**32 - 2, 2**40)
CASES = 2000


def whole(folder: Path) -> bytearray:
    """A file of one chunk with layers: its record, table and chunk at known places."""
    pytest.importorskip("lazrs", reason="needs geohue[clouds]")
    rng = np.random.default_rng(0)
    colors = rng.integers(0, 256, (N, 3)).astype(np.uint8)
    write_las(folder / "whole.laz", rng.normal(0, 3, (N, 3)), colors, np.arange(N))
    return bytearray((folder / "whole.laz").read_bytes())


def places(data: bytearray) -> dict[str, int]:
    """Where the numbers that announce sizes lie."""
    size, start, _, _, width = struct.unpack_from("<HIIBH", data, 94)
    (table,) = struct.unpack_from("<q", data, start)
    record = data.find(b"laszip encoded") - 2 + 54
    chunk = start + 8
    named = {"header": 94, "start": 96, "records": 100, "width": 105, "extended": 235}
    named |= {"n_extended": 243, "count": 247, "record": record - 36, "compressor": record}
    named |= {"chunk_size": record + 12, "n_items": record + 32, "kind": record + 34}
    named |= {"item": record + 36, "version": record + 38, "table": start}
    named |= {"chunks": table + 4, "code": table + 8, "in_chunk": chunk + width}
    return named | {f"layer{i}": chunk + width + 4 + 4 * i for i in range(9)}


def read_in_pieces(file: Path) -> int:
    chunks = open_chunks(file)
    try:
        return len(chunks.read(0, min(chunks.n_points, 1000))[0])
    finally:
        chunks.close()


def test_the_places_are_those_of_the_format(tmp_path: Path) -> None:
    data = whole(tmp_path)
    place = places(data)
    assert struct.unpack_from("<H", data, place["compressor"]) == (3,)
    assert struct.unpack_from("<I", data, place["chunk_size"]) == (50_000,)
    assert struct.unpack_from("<HHH", data, place["kind"]) == (10, 30, 3)
    assert struct.unpack_from("<I", data, place["chunks"]) == (1,)
    assert struct.unpack_from("<I", data, place["in_chunk"]) == (N,)


@pytest.mark.parametrize("read", [read_cloud, read_in_pieces])
@pytest.mark.parametrize(
    ("name", "form", "value", "says"),
    [
        ("records", "<I", 12_000_000, "announces 12000000 records"),
        ("extended", "<Q", 2**40, "extended records"),
        ("count", "<Q", 60_000, "do not fit"),
        ("chunk_size", "<I", 0, "damaged laszip record"),
        ("chunk_size", "<I", N - 1, "its chunks do not fit"),
        ("n_items", "<H", 0, "damaged laszip record"),
        ("item", "<H", 31, "for other points"),
        ("compressor", "<H", 2, "contradicts itself"),
        ("version", "<H", 2, "contradicts itself"),
        ("chunks", "<I", 0, "announces 0 chunks"),
        ("layer0", "<I", 2**31, "damaged layers"),
        ("layer8", "<I", 1, "damaged layers"),
    ],
)
def test_each_size_that_lies_is_refused(
    tmp_path: Path, read: Callable[[Path], object], name: str, form: str, value: int, says: str
) -> None:
    data = whole(tmp_path)
    if name == "extended":
        struct.pack_into("<I", data, places(data)["n_extended"], 1)
    struct.pack_into(form, data, places(data)[name], value)
    (tmp_path / "a.laz").write_bytes(data)
    with pytest.raises(GeohueError, match=says):
        read(tmp_path / "a.laz")


def run_apart(code: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run code in a process with little memory: an abort ends that process alone."""
    pytest.importorskip("resource", reason="memory is not limited here")
    limit = f"import resource; resource.setrlimit(resource.RLIMIT_AS, ({MEMORY}, {MEMORY}))\n"
    return subprocess.run(
        [sys.executable, "-X", "faulthandler=0", "-c", limit + code, str(folder)],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


@pytest.mark.parametrize("size", [10**6, 2**31, 2**32 - 2])
def test_one_chunk_may_have_room_for_more_points_than_there_are(tmp_path: Path, size: int) -> None:
    """A true file may say so; the decoder with threads would ask for room for all of them."""
    data = whole(tmp_path)
    struct.pack_into("<I", data, places(data)["chunk_size"], size)
    (tmp_path / "a.laz").write_bytes(data)
    code = (
        "import sys; from geohue.read import read_cloud\n"
        "print(read_cloud(sys.argv[1] + '/a.laz').points.shape)"
    )
    done = run_apart(code, tmp_path)
    assert (done.returncode, done.stdout.strip()) == (0, f"({N}, 3)"), done.stderr[-400:]


def test_no_size_that_lies_ends_the_process(tmp_path: Path) -> None:
    """Both readers over files with one to three sizes changed; each gives a cloud or one error."""
    data = whole(tmp_path)
    rng = random.Random(0)
    named = sorted(places(data).values())
    for case in range(CASES):
        lying = bytearray(data)
        for place in rng.choices(named, k=rng.randint(1, 3)):
            size = rng.choice([1, 2, 4, 8])
            value = rng.choice([*SIZES, rng.getrandbits(32)]) % (1 << 8 * size)
            lying[place : place + size] = value.to_bytes(size, "little")
        (tmp_path / f"{case}.laz").write_bytes(lying)
    code = (
        "import sys; from pathlib import Path; from geohue import GeohueError\n"
        "from geohue.read import read_cloud; from geohue.read.clouds.chunks import open_chunks\n"
        "ends = {'read': 0, 'refused': 0}\n"
        "for file in sorted(Path(sys.argv[1]).glob('[0-9]*.laz')):\n"
        "    for read in (read_cloud, lambda f: open_chunks(f).read(0, 1)):\n"
        "        try: read(file); ends['read'] += 1\n"
        "        except GeohueError as error:\n"
        "            assert str(file) in str(error); ends['refused'] += 1\n"
        "print(ends['read'], ends['refused'])"
    )
    done = run_apart(code, tmp_path)
    assert done.returncode == 0, done.stderr[-2000:]
    read, refused = map(int, done.stdout.split())
    assert read + refused == 2 * CASES
    assert refused > CASES
