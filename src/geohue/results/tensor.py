"""An array as a file that PyTorch reads, written without it."""

from __future__ import annotations

import struct
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.results.atomic import atomic_write

_STORAGES = {
    "int64": "LongStorage",
    "int32": "IntStorage",
    "uint8": "ByteStorage",
    "float32": "FloatStorage",
    "float64": "DoubleStorage",
    "bool": "BoolStorage",
}


def write_tensor(path: str | Path, array: NDArray[Any]) -> None:
    """Write an array as one CPU tensor: ``torch.load(path, weights_only=True)`` gives it back.

    Parameters
    ----------
    path : path-like
        Usually ending in ``.pth`` or ``.pt``.
    array : any shape
        int64, int32, uint8, float32, float64 or bool.

    Raises
    ------
    GeohueError
        For another type of numbers, or if the file cannot be written.

    Notes
    -----
    The file is a ZIP archive without compression, as PyTorch writes it since 1.6: ``data.pkl``, the
    pickle of a call of ``torch._utils._rebuild_tensor_v2`` on a storage that is named by a
    persistent id; ``data/0``, the bytes of that storage; ``version`` and ``byteorder``.

    Examples
    --------
    >>> file = getfixture("tmp_path") / "labels.pth"
    >>> write_tensor(file, np.arange(3))
    >>> sorted(zipfile.ZipFile(file).namelist())
    ['archive/byteorder', 'archive/data.pkl', 'archive/data/0', 'archive/version']
    """
    storage = _STORAGES.get(array.dtype.name)
    if storage is None:
        kinds = ", ".join(_STORAGES)
        raise GeohueError(f"{path}: a tensor of {array.dtype} is not written; convert to {kinds}")
    flat = np.ascontiguousarray(array).astype(array.dtype.newbyteorder("<"), copy=False)
    parts = {
        "data.pkl": tensor_pickle(storage, array.shape),
        "byteorder": b"little",
        "data/0": flat.tobytes(),
        "version": b"3\n",
    }
    with atomic_write(path) as temporary, zipfile.ZipFile(temporary, "w") as archive:
        for name, content in parts.items():
            # Without a date of its own, so that the same array gives the same file.
            archive.writestr(zipfile.ZipInfo(f"archive/{name}"), content)


def tensor_pickle(storage: str, shape: tuple[int, ...]) -> bytes:
    """Return the pickle (protocol 2) of a contiguous tensor over the whole storage ``0``."""
    count = int(np.prod(shape, dtype=np.int64))
    strides = tuple(int(np.prod(shape[i + 1 :], dtype=np.int64)) for i in range(len(shape)))
    named = [_text("storage"), _global("torch", storage), _text("0"), _text("cpu"), _whole(count)]
    arguments = [
        _tuple(named) + b"Q",  # a persistent id
        _whole(0),  # where the tensor begins in the storage
        _tuple([_whole(side) for side in shape]),
        _tuple([_whole(stride) for stride in strides]),
        b"\x89",  # no gradient
        _global("collections", "OrderedDict") + b")R",  # no hooks
    ]
    call = _global("torch._utils", "_rebuild_tensor_v2") + _tuple(arguments) + b"R"
    return b"\x80\x02" + call + b"."


def _global(module: str, name: str) -> bytes:
    return f"c{module}\n{name}\n".encode()


def _text(text: str) -> bytes:
    return b"X" + struct.pack("<I", len(text)) + text.encode()


def _tuple(items: list[bytes]) -> bytes:
    return b"(" + b"".join(items) + b"t"


def _whole(number: int) -> bytes:
    if number < 2**31:
        return b"J" + struct.pack("<i", number)
    return b"\x8a\x08" + struct.pack("<q", number)
