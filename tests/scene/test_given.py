"""What may stand in place of an 8-bit array, an `Intrinsics` and a coloured cloud."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import geohue
from geohue import GeohueError, GeohueWarning, Intrinsics, Scene
from geohue.results import write_ply, write_png
from geohue.sensors import Lens, PosedCamera, Rig
from geohue.stereo import StereoRig

RNG = np.random.default_rng(3)
RGB = RNG.integers(0, 256, (6, 8, 3)).astype(np.uint8)
DEPTH = np.ones((6, 8), np.float32)
K = np.array([[7.0, 0, 3.5], [0, 8.0, 2.5], [0, 0, 1]])
CAMERA = Intrinsics(7.0, 8.0, 3.5, 2.5)


def colors_of(rgb: Any) -> Any:
    return Scene.from_rgbd(rgb, DEPTH, CAMERA).colors


class TestImages:
    def test_every_type_of_a_colour_image(self) -> None:
        for rgb in (RGB.astype(np.uint16) * 257, RGB / 255, RGB.astype(np.int64), RGB.tolist()):
            assert np.array_equal(colors_of(rgb), RGB)
        assert np.array_equal(colors_of((RGB / 255).astype(np.float32)), RGB)

    def test_alpha_is_left_out_and_grey_repeated(self) -> None:
        alpha = np.concatenate([RGB, np.zeros((6, 8, 1), np.uint8)], axis=2)
        assert np.array_equal(colors_of(alpha), RGB)
        grey = np.repeat(RGB[..., :1], 3, axis=2)
        assert np.array_equal(colors_of(RGB[..., 0]), grey)
        assert np.array_equal(colors_of(RGB[..., :1]), grey)

    @given(st.integers(0, 65535))
    def test_sixteen_bits_become_the_upper_eight(self, value: int) -> None:
        image = np.full((6, 8), value, np.uint16)
        image[0, 0] = 65535
        assert colors_of(image)[1, 1, 0] == value >> 8


class TestDepth:
    def test_a_channel_of_its_own_and_integers_with_a_scale(self) -> None:
        for depth, scale in (
            (DEPTH[..., None], None),
            ((1000 * DEPTH).astype(np.uint16), 0.001),
            ((1000 * DEPTH).astype(np.int32)[..., None], 0.001),
            ((5000 * DEPTH).astype(np.uint16), "tum"),
        ):
            scene = Scene.from_rgbd(RGB, depth, CAMERA, scale)
            assert scene.depth is not None
            assert scene.depth == pytest.approx(DEPTH)

    def test_millimetres_given_as_metres(self) -> None:
        with pytest.warns(GeohueWarning, match="give depth_scale=0.001"):
            scene = Scene.from_rgbd(RGB, 1500 * DEPTH, CAMERA)
        assert "1500 m" in scene.warnings[0]
        assert Scene.from_rgbd(RGB, 99 * DEPTH, CAMERA).warnings == ()
        assert Scene.from_rgbd(RGB, 1500 * DEPTH, CAMERA, 1.0).warnings == ()


class TestCameras:
    @pytest.mark.parametrize(
        "camera",
        [
            K,
            K.T,  # column by column
            K.tolist(),
            np.hstack([K, np.zeros((3, 1))]),
            (7.0, 8.0, 3.5, 2.5),
            "7,8,3.5,2.5",
            {"fx": 7, "fy": 8, "cx": 3.5, "cy": 2.5},
            {"K": K},
            {"cameraIntrinsics": K.tolist()},
            {"camera": {"ppx": 3.5, "ppy": 2.5, "fx": 7, "fy": 8}},
            CAMERA,
        ],
    )
    def test_one_camera_in_many_ways(self, camera: Any) -> None:
        assert Scene.from_rgbd(RGB, DEPTH, camera).intrinsics == CAMERA

    def test_files(self, tmp_path: Path) -> None:
        np.save(tmp_path / "K.npy", K)
        (tmp_path / "phone.json").write_text(json.dumps({"cameraIntrinsics": K.T.ravel().tolist()}))
        (tmp_path / "kalibr.yaml").write_text(
            "cam0:\n  camera_model: pinhole\n  distortion_coeffs: [0, 0, 0, 0]\n"
            "  intrinsics: [7.0, 8.0, 3.5, 2.5]\n  resolution: [8, 6]\n  rostopic: /rgb\n"
        )
        for name in ("K.npy", "phone.json", "kalibr.yaml"):
            camera = Scene.from_rgbd(RGB, DEPTH, tmp_path / name).intrinsics
            assert camera is not None
            assert (camera.fx, camera.fy, camera.cx, camera.cy) == (7, 8, 3.5, 2.5)

    @pytest.mark.parametrize("camera", [np.eye(2), [1, 2], {"f": 3}, np.zeros((3, 3)), "x.json"])
    def test_no_camera(self, camera: Any) -> None:
        with pytest.raises(GeohueError):
            Scene.from_rgbd(RGB, DEPTH, camera)

    def test_a_guessed_camera_warns(self) -> None:
        with pytest.warns(GeohueWarning, match="no intrinsics given"):
            Scene.from_rgbd(RGB, DEPTH)


class TestStereo:
    LEFT = RNG.integers(0, 256, (40, 60, 3)).astype(np.uint8)
    RIGHT = np.roll(LEFT, -5, axis=1)
    SHIFTS = np.full((40, 60), 5.0)

    def depth(self, rig: Any) -> float:
        scene = Scene.from_stereo(self.LEFT, self.RIGHT, rig, self.SHIFTS)
        assert scene.depth is not None
        return float(np.nanmedian(scene.depth))

    def test_one_rig_in_many_ways(self, tmp_path: Path) -> None:
        K1 = np.array([[50.0, 0, 29.5], [0, 50, 19.5], [0, 0, 1]])
        (tmp_path / "rig.json").write_text('{"f": 50, "baseline": 0.2, "cx0": 29.5, "cy": 19.5}')
        camera = Intrinsics(50.0, 50.0, 29.5, 19.5)
        for rig in (
            StereoRig(camera, camera, 0.2),
            (50, 0.2),
            [50, 0.2, 0.0],
            {"f": 50, "baseline": 0.2},
            {"K1": K1, "K2": K1, "R": np.eye(3), "T": [-0.2, 0, 0]},
            (K1, None, K1, None, np.eye(3), np.array([[-0.2], [0], [0]])),
            "50,0.2",
            tmp_path / "rig.json",
        ):
            assert self.depth(rig) == pytest.approx(50 * 0.2 / 5)

    def test_paths(self, tmp_path: Path) -> None:
        names = [tmp_path / f"{name}.png" for name in ("left", "right", "disparity")]
        for name, image in zip(names, (self.LEFT, self.RIGHT, self.SHIFTS * 4), strict=True):
            write_png(name, image.astype(np.uint8))
        left, right, disparity = names
        scene = Scene.from_stereo(left, right, (50, 0.2), disparity, disparity_scale="1/4")
        assert scene.depth is not None
        assert float(np.nanmedian(scene.depth)) == pytest.approx(2.0)

    def test_kalibr_chain(self, tmp_path: Path) -> None:
        camera = "  distortion_coeffs: [0, 0, 0, 0]\n  distortion_model: radtan\n"
        camera += "  intrinsics: [50, 50, 29.5, 19.5]\n  resolution: [60, 40]\n"
        pose = "  T_cn_cnm1:\n  - [1.0, 0.0, 0.0, -0.2]\n  - [0.0, 1.0, 0.0, 0.0]\n"
        pose += "  - [0.0, 0.0, 1.0, 0.0]\n  - [0.0, 0.0, 0.0, 1.0]\n"
        (tmp_path / "camchain.yaml").write_text(f"cam0:\n{camera}cam1:\n{pose}{camera}")
        assert self.depth(tmp_path / "camchain.yaml") == pytest.approx(2.0)

    @pytest.mark.parametrize("rig", [(1,), {"f": 3}, np.eye(3), (1, 2, 3, 4)])
    def test_no_rig(self, rig: Any) -> None:
        with pytest.raises(GeohueError, match="K1 D1 K2 D2 R T"):
            self.depth(rig)


class TestRange:
    def test_a_rig_as_a_dict_and_a_file(self, tmp_path: Path) -> None:
        lens = {"K": K, "width": 8, "height": 6}
        rig = {"depth": lens, "rgb": lens, "R": np.eye(3), "T": np.zeros(3)}
        plain = Rig((PosedCamera(Lens(CAMERA)),), Lens(CAMERA))
        wanted = Scene.from_range_and_cameras(DEPTH, [RGB], plain)
        (tmp_path / "rig.json").write_text(
            json.dumps(rig, default=lambda value: np.asarray(value).tolist())
        )
        write_png(tmp_path / "rgb.png", RGB)
        np.save(tmp_path / "depth.npy", DEPTH)
        for scene in (
            Scene.from_range_and_cameras(DEPTH, [RGB], rig),
            Scene.from_range_and_cameras(
                tmp_path / "depth.npy", [tmp_path / "rgb.png"], tmp_path / "rig.json"
            ),
        ):
            assert np.array_equal(scene.colors, wanted.colors)
            assert np.array_equal(scene.points, wanted.points)


class TestClouds:
    POINTS = RNG.normal(size=(300, 3)) + 4 * (np.arange(300) % 2)[:, None]

    def test_alpha_and_sixteen_bits(self) -> None:
        colors = RNG.integers(0, 256, (300, 4)).astype(np.uint8)
        for given_colors in (colors, colors / 255, colors.astype(np.uint16) * 257):
            scene = Scene.from_cloud(self.POINTS, given_colors)
            assert np.array_equal(scene.colors, colors[:, :3])

    def test_without_colours_the_geometry_counts(self) -> None:
        bare = Scene.from_cloud(self.POINTS)
        assert not bare.has_colors
        found = geohue.segment(bare, k=2, preset="paper")
        assert found.cues == "geometry"
        assert "no colours" in found.warnings[0]
        grey = Scene.from_cloud(self.POINTS, np.zeros((300, 3)))
        same = geohue.segment(grey, k=2, preset="paper", cues="geometry")
        assert np.array_equal(found.labels, same.labels)
        with pytest.raises(GeohueError, match='cues="geometry"'):
            geohue.segment(bare, cues="color")

    def test_a_file(self, tmp_path: Path) -> None:
        colors = RNG.integers(0, 256, (300, 3)).astype(np.uint8)
        write_ply(tmp_path / "a.ply", self.POINTS, colors, np.zeros(300, np.int32))
        scene = Scene.from_cloud(tmp_path / "a.ply")
        assert np.array_equal(scene.colors, colors)
        assert geohue.segment(tmp_path / "a.ply", k=2, preset="paper").labels.shape == (300,)
        with pytest.raises(GeohueError, match="leave out the others"):
            Scene.from_cloud(tmp_path / "a.ply", colors)

    def test_odd_points_are_counted(self) -> None:
        points = self.POINTS.copy()
        points[:3], points[3] = [[np.nan] * 3, [np.inf] * 3, [1e300, 0, 0]], 1e9
        scene = Scene.from_cloud(points, np.zeros((300, 3)))
        assert scene.warnings == (
            "3 of 300 points have no finite coordinates and are left out",
            "1 of 300 points lies over 10000 times farther out than most: remove what is garbage, "
            "since the extent of the scene counts",
        )


class TestSegment:
    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            ((None,), r"segment\(None\): give a scene, such as geohue.Scene.from_rgbd\(rgb, depth"),
            ((RGB,), r"\(6, 8, 3\) is no scene: write geohue.segment\(geohue.Scene.from_rgbd"),
            ((np.zeros((9, 3)),), r"write geohue.segment\(geohue.Scene.from_cloud\(points"),
            ((RGB, DEPTH), r"segment takes one scene, .* write geohue.segment\(geohue.Scene.from_"),
            (("photo.png", "depth.png"), "has 'depth.png' as its k"),
            ((7,), r"segment\(a int\): give a scene"),
            (("missing.ply",), "missing.ply: no such file"),
        ],
    )
    def test_what_to_write_instead(self, arguments: tuple[Any, ...], message: str) -> None:
        with pytest.raises(GeohueError, match=message):
            geohue.segment(*arguments)

    def test_pictures(self, tmp_path: Path) -> None:
        write_png(tmp_path / "photo.png", np.repeat(np.repeat(RGB, 4, 0), 4, 1))
        file = tmp_path / "photo.png"
        with pytest.raises(GeohueError, match=r"photo.png: is an image without depth; write geoh"):
            geohue.segment(file)
        by_path = geohue.segment(file, k=2, cues="color", preset="paper")
        by_array = geohue.segment(geohue.read.read_color(file), k=2, cues="color", preset="paper")
        assert np.array_equal(by_path.labels, by_array.labels)
        with pytest.raises(GeohueError, match=r"is a folder; write geohue.segment\(geohue.open_da"):
            geohue.segment(tmp_path)


def test_rooms_are_reachable() -> None:
    truth = np.array([[1, 1, 2]])
    assert geohue.evaluate(truth - 1, truth)["rand"] == 1.0
    for room in ("read", "stereo", "sensors", "measures", "datasets", "results", "simulate"):
        assert room in dir(geohue)
        assert getattr(geohue, room).__name__ == f"geohue.{room}"
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = geohue.nothing


class TestMask:
    def test_what_is_masked_has_no_label(self) -> None:
        scene = geohue.load_sample("boxes")
        mask = np.ones(scene.shape, np.uint8)
        mask[:, :40] = 0
        for cues in ("fusion", "color"):
            labels = geohue.segment(scene.masked(mask), k=2, cues=cues, preset="fast").labels
            assert (labels[:, :40] == -1).all()
            assert (labels[:, 40:] >= 0).all()
        with pytest.raises(GeohueError, match="keeps nothing"):
            scene.masked(np.zeros(scene.shape))
        with pytest.raises(GeohueError, match="shape of the labels"):
            scene.masked(mask[:5])
