"""Recordings of ROS 1 (.bag), ROS 2 (folder, .db3, .mcap) and of RealSense (.bag), by rosbags."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.camera import Intrinsics
from geohue.datasets.frames import Dataset, Frame
from geohue.errors import GeohueError
from geohue.read.extras import optional
from geohue.read.files import broken, reason

_FILES = (".bag", ".mcap", ".db3")
_APART = 50_000_000  # nanoseconds between what counts as one moment
_MOST_PIXELS = 1 << 26
_IMAGES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
_INFO = "sensor_msgs/msg/CameraInfo"
_DEPTH_UNITS = {"16UC1": 0.001, "mono16": 0.001, "32FC1": 1.0, "z16": 0.001}


@dataclass(frozen=True, slots=True)
class _Topics:
    color: str
    depth: str
    info: str | None


def matches(folder: Path) -> bool:
    """Whether it is a recording, by its name or the metadata.yaml in its folder."""
    if folder.is_dir():
        return (folder / "metadata.yaml").is_file()
    return folder.suffix.lower() in _FILES


def load(folder: Path) -> Dataset:
    """Pair the messages of the colour and the depth topic by their time."""
    try:
        topics, colors, depths, camera = _survey(folder)
    except GeohueError:
        raise
    except Exception as error:  # rosbags lets many kinds through for a damaged file
        raise broken(folder, f"is damaged or cut short ({reason(error)}); copy it again") from error
    times = np.array([time for time, _ in depths])
    frames = []
    for time, number in colors:
        i = int(np.argmin(np.abs(times - time)))
        if abs(int(times[i]) - time) <= _APART:
            color = _color_reader(folder, topics.color, number)
            depth = _depth_reader(folder, topics.depth, depths[i][1])
            frames.append(Frame(f"{time}", color, depth, camera))
    notes = [f"colour from {topics.color}, depth from {topics.depth}, camera from {topics.info}"]
    if not re.search(r"aligned|registered", topics.depth):
        notes.append("the depth topic does not say that it is registered to colour")
    return Dataset("ros", folder, frames, tuple(notes))


def _open(folder: Path) -> Any:
    highlevel = optional("rosbags.highlevel", "ros", folder)
    typesys = optional("rosbags.typesys", "ros", folder)
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    place = folder.parent if folder.suffix == ".db3" else folder
    return highlevel.AnyReader([place], default_typestore=store)


def _survey(
    folder: Path,
) -> tuple[_Topics, list[tuple[int, int]], list[tuple[int, int]], Intrinsics | None]:
    """Return the topics, time and number of each message on the two, and the camera."""
    with _open(folder) as bag:
        topics = _topics(folder, bag.connections)
        times: dict[str, list[tuple[int, int]]] = {topics.color: [], topics.depth: []}
        camera = None
        wanted = [c for c in bag.connections if c.topic in (*times, topics.info)]
        for connection, time, raw in bag.messages(connections=wanted):
            if connection.topic in times:
                places = times[connection.topic]
                places.append((time, len(places)))
            elif camera is None:
                camera = _camera(bag.deserialize(raw, connection.msgtype))
    if not times[topics.color] or not times[topics.depth]:
        raise broken(folder, f"has no messages on {topics.color} and {topics.depth}")
    return topics, times[topics.color], times[topics.depth], camera


def _topics(folder: Path, connections: list[Any]) -> _Topics:
    """Choose the colour and the depth topic; registered depth comes first."""
    images = sorted({c.topic for c in connections if c.msgtype in _IMAGES})
    depths = [t for t in images if re.search(r"(?i)depth", t)]
    colors = [t for t in images if re.search(r"(?i)(color|rgb)", t) and t not in depths]
    if not depths or not colors:
        names = ", ".join(images[:8]) or "none"
        raise broken(folder, f"has no colour and depth pictures (topics of pictures: {names})")
    depth = min(depths, key=lambda t: (not re.search(r"aligned|registered", t), len(t), t))
    color = min(colors, key=lambda t: (len(t), t))
    infos = sorted({c.topic for c in connections if c.msgtype == _INFO})
    base = color.rsplit("/image", 1)[0]
    near = [t for t in infos if t.startswith(base)] or [t for t in infos if "depth" not in t]
    return _Topics(color, depth, near[0] if near else None)


def _camera(message: Any) -> Intrinsics:
    K = getattr(message, "k", None)
    K = message.K if K is None else K
    size = (int(message.width), int(message.height))
    return Intrinsics(float(K[0]), float(K[4]), float(K[2]), float(K[5]), *size)


def _message(folder: Path, topic: str, number: int) -> Any:
    try:
        with _open(folder) as bag:
            wanted = [c for c in bag.connections if c.topic == topic]
            for i, (connection, _, raw) in enumerate(bag.messages(connections=wanted)):
                if i == number:
                    return bag.deserialize(raw, connection.msgtype)
    except GeohueError:
        raise
    except Exception as error:
        raise broken(folder, f"is damaged ({reason(error)}); copy it again") from error
    raise broken(folder, f"has no message {number} on {topic}")


def _color_reader(folder: Path, topic: str, number: int) -> Callable[[], NDArray[np.uint8]]:
    return lambda: decode_color(_message(folder, topic, number), folder)


def _depth_reader(folder: Path, topic: str, number: int) -> Callable[[], NDArray[np.float32]]:
    return lambda: decode_depth(_message(folder, topic, number), folder)


def decode_color(message: Any, folder: Path) -> NDArray[np.uint8]:
    """Decode rgb8, bgr8, rgba8, bgra8, mono8 or a compressed picture."""
    if not hasattr(message, "encoding"):
        pixels = _uncompressed(bytes(message.data), folder)
        return np.ascontiguousarray(pixels[..., 2::-1] if pixels.ndim == 3 else _grey(pixels))
    kind = message.encoding.lower()
    channels = {"rgb8": 3, "bgr8": 3, "rgba8": 4, "bgra8": 4, "mono8": 1, "8uc3": 3, "8uc1": 1}
    if kind not in channels:
        raise broken(folder, f"has pictures in the encoding {kind[:30]!r}, which is not read")
    pixels = _pixels(message, np.dtype(np.uint8), channels[kind], folder)
    if channels[kind] == 1:
        return _grey(pixels[..., 0])
    order = slice(2, None, -1) if kind.startswith("bgr") else slice(0, 3)
    return np.ascontiguousarray(pixels[..., order][..., :3])


def _grey(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return np.repeat(pixels[..., None], 3, axis=2)


def decode_depth(message: Any, folder: Path) -> NDArray[np.float32]:
    """Decode 16-bit millimetres or float metres, also as a compressed PNG (12 bytes before it)."""
    if not hasattr(message, "encoding"):
        data = bytes(message.data)
        start = data.find(b"\x89PNG", 0, 64)
        raw, scale = _uncompressed(data[max(start, 0) :], folder), 0.001
    else:
        if message.encoding not in _DEPTH_UNITS:
            raise broken(folder, f"has depth in the encoding {message.encoding[:30]!r}")
        scale = _DEPTH_UNITS[message.encoding]
        kind = np.dtype(np.float32 if message.encoding == "32FC1" else np.uint16)
        raw = _pixels(message, kind, 1, folder)[..., 0]
    depth = raw.astype(np.float32) * np.float32(scale)
    depth[~(np.isfinite(depth) & (depth > 0))] = np.nan
    return depth


def _pixels(message: Any, kind: np.dtype[Any], channels: int, folder: Path) -> NDArray[Any]:
    height, width, step = int(message.height), int(message.width), int(message.step)
    data = np.asarray(message.data, np.uint8)
    row = width * channels * kind.itemsize
    if not (0 < height * width <= _MOST_PIXELS and row <= step and height * step <= data.size):
        raise broken(folder, f"has a picture of {width} x {height} with {data.size} bytes: damaged")
    rows = np.ascontiguousarray(data[: height * step].reshape(height, step)[:, :row])
    order = kind.newbyteorder(">" if message.is_bigendian else "<")
    return rows.view(order).reshape(height, width, channels).astype(kind)


def _uncompressed(data: bytes, folder: Path) -> NDArray[Any]:
    import cv2

    from geohue.read.images.integrity import check_picture

    check_picture(data, folder)
    pixels = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED) if data else None
    if pixels is None:
        raise broken(folder, "has a damaged compressed picture")
    return np.asarray(pixels)
