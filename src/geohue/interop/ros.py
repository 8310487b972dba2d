"""PointCloud2 and Image messages of ROS, by their fields alone."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError

_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
_INT32 = 5


def cloud_fields(message: Any) -> dict[str, NDArray[Any]]:
    """Return each field of a PointCloud2, (N,), or (H, W) where it is organised.

    Raises
    ------
    GeohueError
        If the message has no coordinates or is shorter than it says.
    """
    height, width, step = int(message.height), int(message.width), int(message.point_step)
    row = int(message.row_step)
    data = np.frombuffer(bytes(message.data), np.uint8)
    names = {field.name for field in message.fields}
    if not {"x", "y", "z"} <= names:
        raise GeohueError(f"PointCloud2 with the fields {', '.join(sorted(names))}: no x, y, z")
    if data.size < height * row or row < width * step:
        raise GeohueError(
            f"PointCloud2 of {width} x {height} points with {data.size} bytes: cut off"
        )
    rows = np.ascontiguousarray(data[: height * row].reshape(height, row)[:, : width * step])
    order = ">" if message.is_bigendian else "<"
    found = {}
    for field in message.fields:
        if int(field.count) > 1 or int(field.datatype) not in _TYPES:
            continue
        kind = np.dtype(order + _TYPES[int(field.datatype)])
        at = int(field.offset)
        part = rows.reshape(height, width, step)[..., at : at + kind.itemsize]
        values = np.ascontiguousarray(part).view(kind)[..., 0].astype(kind.newbyteorder("="))
        found[field.name] = values[0] if height == 1 else values
    return found


def with_field(message: Any, name: str, values: NDArray[np.int32]) -> Any:
    """Return a copy of a PointCloud2 with another field of int32."""
    height, width, step = int(message.height), int(message.width), int(message.point_step)
    data = np.frombuffer(bytes(message.data), np.uint8)[: height * int(message.row_step)]
    rows = data.reshape(height, -1)[:, : width * step].reshape(height, width, step)
    order = ">" if message.is_bigendian else "<"
    more = values.astype(order + "i4").reshape(height, width, 1).view(np.uint8)
    field = copy.copy(message.fields[0])
    new = {"name": name, "offset": step, "datatype": _INT32, "count": 1}
    made = changed(field, **new)
    content = np.concatenate([rows, more], axis=2).reshape(-1)
    return changed(
        message,
        fields=[*message.fields, made],
        point_step=step + 4,
        row_step=width * (step + 4),
        data=_like(message.data, content),
    )


def with_pixels(message: Any, pixels: NDArray[np.uint16]) -> Any:
    """Return a copy of an Image with 16-bit pixels of one channel."""
    height, width = pixels.shape
    order = ">" if message.is_bigendian else "<"
    content = pixels.astype(order + "u2").reshape(-1).view(np.uint8)
    size = {"height": height, "width": width, "step": 2 * width}
    return changed(message, encoding="16UC1", data=_like(message.data, content), **size)


def changed(message: Any, **values: Any) -> Any:
    """Return a copy of a message with other values, whether it can be changed or not."""
    made = copy.copy(message)
    for name, value in values.items():
        try:
            setattr(made, name, value)
        except AttributeError:  # a frozen data class, as of rosbags
            object.__setattr__(made, name, value)
    return made


def _like(data: Any, content: NDArray[np.uint8]) -> Any:
    """Bytes in the type of the message's own."""
    if isinstance(data, np.ndarray):
        return content
    return list(content) if isinstance(data, list) else type(data)(content.tobytes())
