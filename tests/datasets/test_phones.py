"""Folders as apps for phones with a LiDAR write them."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from geohue import GeohueError
from geohue.datasets import Dataset, open_dataset
from geohue.results import write_png

WIDTH, HEIGHT = 64, 48
K = [60.0, 0, 31.5, 0, 60.0, 23.5, 0, 0, 1]
DEPTH = np.full((12, 16), 1500, np.uint16)
SURE = np.full((12, 16), 2, np.uint8)
SURE[:, 8:] = 0


def picture(number: int) -> np.ndarray:
    image = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    image[:, :32] = (40 * number + 40, 0, 0)
    return image


def check(data: Dataset, layout: str, frames: int = 2) -> None:
    """Both frames have their picture at full size, their depth scaled, and half of it sure."""
    assert (data.layout, len(data)) == (layout, frames)
    for number, frame in enumerate(data):
        scene = frame.scene()
        assert scene.shape == (HEIGHT, WIDTH)
        assert scene.colors[24, 10, 0] == pytest.approx(40 * number + 40, abs=12)
        assert scene.colors[24, 50, 0] < 20
        assert scene.depth is not None
        assert scene.depth[24, 10] == pytest.approx(1.5)
        assert np.isnan(scene.depth[24, 40])
        assert scene.intrinsics is not None
        assert scene.intrinsics.fx == pytest.approx(60)
        assert frame.scene(least=0).valid.all()
    with pytest.raises(GeohueError, match="no depth is left"):
        data[0].scene(max_depth=1.0)


def test_stray_scanner(tmp_path: Path) -> None:
    film = cv2.VideoWriter(
        str(tmp_path / "rgb.mp4"), cv2.VideoWriter.fourcc(*"mp4v"), 30, (WIDTH, HEIGHT)
    )
    for number in range(2):
        film.write(np.ascontiguousarray(picture(number)[..., ::-1]))
        write_png(tmp_path / "depth" / f"{number:06}.png", DEPTH)
        write_png(tmp_path / "confidence" / f"{number:06}.png", SURE)
    film.release()
    rows = [K[3 * i : 3 * i + 3] for i in range(3)]
    (tmp_path / "camera_matrix.csv").write_text("\n".join(", ".join(map(str, r)) for r in rows))
    (tmp_path / "odometry.csv").write_text(
        "timestamp, frame, x, y, z, qx, qy, qz, qw\n0.1, 000000, 1, 2, 3, 0, 0, 0, 1\n"
    )
    data = open_dataset(tmp_path)
    check(data, "stray")
    pose = data[0].T_world_camera
    assert pose is not None
    assert pose[:3, 3].tolist() == [1, 2, 3]
    (tmp_path / "rgb.mp4").write_bytes(b"no film")
    with pytest.raises(GeohueError, match=r"rgb.mp4: has no frame 0 that can be decoded"):
        data[0].scene()


def metadata(folder: Path) -> None:
    about: dict[str, object] = {"w": WIDTH, "h": HEIGHT, "dw": 16, "dh": 12, "fps": 30}
    about |= {"K": np.array(K).reshape(3, 3).T.ravel().tolist()}  # column by column
    about |= {"poses": [[0, 0, 0, 1, 4, 5, 6]]}
    (folder / "metadata").write_text(json.dumps(about))


def test_record3d_packed(tmp_path: Path) -> None:
    lzfse = pytest.importorskip("liblzfse", reason="needs geohue[phones]")
    metadata(tmp_path)
    for number in range(2):
        write_png(tmp_path / "rgbd" / f"{number}.png", picture(number))
        metres = (DEPTH / 1000).astype("<f4").tobytes()
        (tmp_path / "rgbd" / f"{number}.depth").write_bytes(lzfse.compress(metres))
        (tmp_path / "rgbd" / f"{number}.conf").write_bytes(lzfse.compress(SURE.tobytes()))
    data = open_dataset(tmp_path)
    check(data, "record3d")
    pose = data[0].T_world_camera
    assert pose is not None
    assert pose[:3, 3].tolist() == [4, 5, 6]
    (tmp_path / "rgbd" / "0.depth").write_bytes(b"no such thing")
    with pytest.raises(GeohueError, match=r"0.depth: is no compressed map of 16 x 12"):
        data[0].scene()


def test_record3d_exr(tmp_path: Path) -> None:
    metadata(tmp_path)
    for number in range(2):
        write_png(tmp_path / "rgb" / f"{number}.png", picture(number))
        write_png(tmp_path / "conf" / f"{number}.png", SURE)
        (tmp_path / "depth").mkdir(exist_ok=True)
        (tmp_path / "depth" / f"{number}.exr").write_bytes(_exr((DEPTH / 1000).astype("<f4")))
    check(open_dataset(tmp_path), "record3d")


def _exr(depth: np.ndarray) -> bytes:
    """Write a map of one channel Z, float32, not compressed."""
    height, width = depth.shape
    box = np.array([0, 0, width - 1, height - 1], "<i4").tobytes()
    channel = b"Z\0" + np.array([2, 0, 1, 1], "<i4").tobytes() + b"\0"
    head = bytes.fromhex("762f3101") + np.array([2], "<i4").tobytes()
    for name, kind, value in (
        ("channels", "chlist", channel),
        ("compression", "compression", b"\0"),
        ("dataWindow", "box2i", box),
        ("displayWindow", "box2i", box),
        ("lineOrder", "lineOrder", b"\0"),
        ("pixelAspectRatio", "float", np.float32(1).tobytes()),
        ("screenWindowCenter", "v2f", np.zeros(2, "<f4").tobytes()),
        ("screenWindowWidth", "float", np.float32(1).tobytes()),
    ):
        size = np.array([len(value)], "<i4").tobytes()
        head += name.encode() + b"\0" + kind.encode() + b"\0" + size + value
    head += b"\0"
    line = 8 + 4 * width
    first = len(head) + 8 * height
    offsets = np.array([first + i * line for i in range(height)], "<u8").tobytes()
    rows = b"".join(
        np.array([y, 4 * width], "<i4").tobytes() + depth[y].astype("<f4").tobytes()
        for y in range(height)
    )
    return head + offsets + rows


def test_scanner_app(tmp_path: Path) -> None:
    for number in range(2):
        name = f"frame_{number:05}"
        cv2.imwrite(str(tmp_path / f"{name}.jpg"), picture(number)[..., ::-1])
        (tmp_path / f"{name}.json").write_text(json.dumps({"intrinsics": K, "frame_index": number}))
        write_png(tmp_path / f"depth_{number:05}.png", DEPTH)
        write_png(tmp_path / f"conf_{number:05}.png", SURE)
    check(open_dataset(tmp_path), "arkit")


def test_polycam(tmp_path: Path) -> None:
    place = tmp_path / "keyframes"
    camera = {"fx": 60.0, "fy": 60.0, "cx": 31.5, "cy": 23.5, "width": WIDTH, "height": HEIGHT}
    for number in range(2):
        name = f"{6000 + number}"
        for part in ("images", "cameras"):
            (place / part).mkdir(parents=True, exist_ok=True)
        cv2.imwrite(str(place / "images" / f"{name}.jpg"), picture(number)[..., ::-1])
        (place / "cameras" / f"{name}.json").write_text(json.dumps(camera))
        write_png(place / "depth" / f"{name}.png", DEPTH)
        write_png(place / "confidence" / f"{name}.png", SURE * 100)
    check(open_dataset(tmp_path), "arkit")


def test_arkitscenes(tmp_path: Path) -> None:
    for number in range(2):
        name = f"4104_{number}.25"
        for folder, image in (
            ("lowres_wide", picture(number)),
            ("lowres_depth", DEPTH),
            ("confidence", SURE),
        ):
            write_png(tmp_path / folder / f"{name}.png", image)
        place = tmp_path / "lowres_wide_intrinsics"
        place.mkdir(exist_ok=True)
        (place / f"{name}.pincam").write_text("64 48 60 60 31.5 23.5\n")
    check(open_dataset(tmp_path), "arkit")
    (place / "4104_0.25.pincam").write_text("64 48")
    with pytest.raises(GeohueError, match="six numbers"):
        open_dataset(tmp_path)
