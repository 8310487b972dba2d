"""Depth maps that are bare arrays: NPY, NPZ and PFM."""

from __future__ import annotations

import io
import re
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.read.files import broken, read_bytes, reason

_MOST = 1 << 30  # bytes of an unpacked array


def read_npy(path: str | Path) -> NDArray[Any]:
    """Read an NPY file of plain numbers; GeohueError if it is anything else."""
    return _parse_npy(read_bytes(path), path)


def _parse_npy(data: bytes, path: str | Path) -> NDArray[Any]:
    stream = io.BytesIO(data)
    try:
        version = npy.read_magic(stream)
        if version not in ((1, 0), (2, 0)):
            raise ValueError(f"NPY version {version}")
        header = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
        shape, fortran, dtype = header(stream)
    except Exception as error:  # a damaged header is evaluated as Python text: anything may come
        raise broken(path, f"is not a whole NPY array ({reason(error)}); save it again") from error
    if dtype.kind not in "iuf" or dtype.itemsize == 0:
        raise broken(path, f"holds {str(dtype)[:60]}; save the depth as numbers")
    size = 1
    for side in shape:
        size *= side
    start = stream.tell()
    if any(side < 0 for side in shape) or len(data) - start < size * dtype.itemsize:
        raise broken(
            path, f"is cut short: {str(shape)[:60]} {dtype} needs more bytes; save it again"
        )
    array = np.frombuffer(data, dtype, size, start)
    return array.reshape(shape, order="F" if fortran else "C")


def read_npz(path: str | Path) -> NDArray[Any]:
    """Read the array ``depth`` of an NPZ file, or its only one; GeohueError if there is none."""
    data = read_bytes(path)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            names = [name for name in archive.namelist() if name.endswith(".npy")]
            name = "depth.npy" if "depth.npy" in names else names[0] if len(names) == 1 else None
            if name is None:
                found = ", ".join(n[:-4] for n in names[:10]) or "none"
                raise broken(path, f"has no array named 'depth' (found: {found}); rename one")
            return npz_member(archive, name[:-4], path)
    except GeohueError:
        raise
    except Exception as error:  # zipfile lets zlib, struct, encoding and other errors through
        raise broken(path, f"is not a whole NPZ file ({reason(error)}); save it again") from error


def npz_member(archive: zipfile.ZipFile, name: str, path: str | Path) -> NDArray[Any]:
    """Return an array of an opened NPZ file; GeohueError if it is not there or not whole."""
    if f"{name}.npy" not in archive.namelist():
        raise broken(path, f"has no array named {name!r}; give the file that geohue wrote")
    if archive.getinfo(f"{name}.npy").file_size > _MOST:
        raise broken(path, f"unpacks to more than {_MOST} bytes; make it smaller first")
    with archive.open(f"{name}.npy") as member:
        return _parse_npy(member.read(_MOST), path)


def read_pfm(path: str | Path) -> NDArray[np.float32]:
    """Read a PFM file of one channel, first row on top; GeohueError if it is anything else."""
    data = read_bytes(path)
    head = re.match(rb"(P[Ff])\s+(\d{1,9})\s+(\d{1,9})\s+([-+.\deE]{1,30})(?:\r\n|\s)", data[:200])
    if head is None:
        raise broken(path, "is not a PFM file, or its header is cut short; export it again")
    channels = 3 if head.group(1) == b"PF" else 1
    width, height = int(head.group(2)), int(head.group(3))
    needed = width * height * channels * 4
    if len(data) - head.end() < needed:
        raise broken(path, f"is cut short: {width} x {height} pixels need {needed} bytes")
    order = "<f4" if head.group(4).startswith(b"-") else ">f4"
    values = np.frombuffer(data, order, width * height * channels, head.end())
    shape = (height, width, 3) if channels == 3 else (height, width)
    return values.reshape(shape)[::-1].astype(np.float32)
