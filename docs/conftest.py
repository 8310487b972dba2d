"""The files that the pages name, small and simulated: each page runs in a folder that has them."""

from __future__ import annotations

import shutil
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

STEP = 0.06  # metres from one camera to the next


@pytest.fixture(scope="session")
def named_files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Make a frame, a stereo pair, rigs, checkerboards, clouds and a TUM folder, once."""
    folder = tmp_path_factory.mktemp("pages")
    _frame(folder)
    _pair(folder)
    _rigs(folder)
    _boards(folder)
    _clouds(folder)
    _tum(folder / "rgbd_dataset_freiburg1_desk")
    return folder


@pytest.fixture(autouse=True)
def in_a_folder_with_these_files(
    named_files: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    doctest_namespace: dict[str, Any],
) -> None:
    """Run the page in a copy, so that what it writes is seen by no other page."""
    shutil.copytree(named_files, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    doctest_namespace["publisher"] = SimpleNamespace(publish=str)  # for a node of ROS


@cache
def _views() -> tuple[Any, Any, Any]:
    from geohue.simulate import CAMERA, WORLDS, render

    left, right = (render(WORLDS["shelf"](), CAMERA, shift, 1) for shift in (0.0, STEP))
    return left, right, CAMERA


def _frame(folder: Path) -> None:
    import cv2

    from geohue.results import write_png
    from geohue.simulate import CAMERA, WORLDS, render

    view = render(WORLDS["boxes"](), CAMERA, samples=1)
    rgb, depth = (np.repeat(np.repeat(a, 2, 0), 2, 1) for a in (view.colors, view.depth))
    write_png(folder / "rgb.png", rgb)
    cv2.imwrite(str(folder / "rgb.jpg"), rgb[..., ::-1])
    write_png(folder / "depth.png", np.rint(depth * 1000).astype(np.uint16))
    write_png(folder / "conf.png", np.where(depth < 1.5, 2, 0).astype(np.uint8))
    np.save(folder / "K.npy", np.array([[525, 0, 319.5], [0, 525, 239.5], [0, 0, 1]]))


def _pair(folder: Path) -> None:
    from geohue.results import write_png

    left, right, camera = _views()
    write_png(folder / "left.png", left.colors)
    write_png(folder / "right.png", right.colors)
    shift = camera.fx * STEP / left.depth
    write_png(folder / "disp.png", np.rint(shift * 256).astype(np.uint16))
    K = f"[{camera.fx} 0 {camera.cx}; 0 {camera.fy} {camera.cy}; 0 0 1]"
    lines = [f"cam0={K}", f"cam1={K}", "doffs=0", f"baseline={STEP * 1000}"]
    (folder / "calib.txt").write_text("\n".join([*lines, "width=320", "height=240", ""]))


def _rigs(folder: Path) -> None:
    from geohue.results import write_png
    from geohue.results.rig import write_rig
    from geohue.sensors import Lens, PosedCamera, Rig

    left, right, camera = _views()
    places = [("c1", 0.0), ("c2", STEP)]
    cameras = [
        PosedCamera(Lens(camera), np.eye(3), np.array([-x, 0, 0]), name) for name, x in places
    ]
    write_rig(folder / "calibration.json", Rig(tuple(cameras), Lens(camera)))
    for (name, _), view in zip(places, (left, right), strict=True):
        write_png(folder / f"{name}.png", view.colors)
    write_png(folder / "raw.png", np.rint(left.depth * 1000).astype(np.uint16))
    x, y, z = np.moveaxis(camera.unproject(left.depth.astype(np.float32)), -1, 0)[:, ::2, ::2]
    rows = np.stack([z, -x, -y, np.zeros_like(z)], axis=-1).reshape(-1, 4)
    rows.astype("<f4").tofile(folder / "lidar.bin")
    K = np.array([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]])
    poses = {f"P{2 + i}": np.c_[K, K @ [-s, 0, 0]] for i, s in enumerate((0.0, STEP))}
    turn = np.array([[0, -1, 0, 0], [0, 0, -1, 0], [1, 0, 0, 0]])
    lines = {**poses, "R0_rect": np.eye(3), "Tr_velo_to_cam": turn}
    text = "".join(f"{key}: {' '.join(map(str, m.ravel()))}\n" for key, m in lines.items())
    (folder / "kitti.txt").write_text(text)


def _boards(folder: Path) -> None:
    from geohue.results import write_png
    from sensors.boards import FIRST, SECOND, poses, seen

    for number, pose in enumerate(poses()):
        write_png(folder / "boards" / f"ir-{number}.png", seen(FIRST, *pose))
        write_png(folder / "boards" / f"color-{number}.png", seen(SECOND, *pose))


def _clouds(folder: Path) -> None:
    from geohue.results import write_ply

    view, _, camera = _views()
    points = camera.unproject(view.depth.astype(np.float32)).reshape(-1, 3)
    order = np.random.default_rng(0).permutation(len(points))
    for name, count in (("scan.ply", 6000), ("BIG.ply", 38400)):
        part, none = order[:count], np.zeros(count, np.int32)
        write_ply(folder / name, points[part], view.colors.reshape(-1, 3)[part], none)


def _tum(folder: Path) -> None:
    from geohue.results import write_png

    view, _, _ = _views()
    lists = {"rgb": "", "depth": ""}
    for number in range(2):
        write_png(folder / "rgb" / f"{number}.png", view.colors)
        write_png(folder / "depth" / f"{number}.png", np.rint(view.depth * 5000).astype(np.uint16))
        for kind in lists:
            lists[kind] += f"{number}.0 {kind}/{number}.png\n"
    for kind, text in lists.items():
        (folder / f"{kind}.txt").write_text(text)
