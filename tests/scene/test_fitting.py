"""Depth of another resolution, turned pictures, and depth that is not to be used."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from geohue import GeohueError, Intrinsics, Scene
from geohue.sensors.orientation import swaps_sides, upright, upright_camera
from geohue.sensors.scaling import sample_nearest, scale_depth

RGB = np.zeros((24, 32, 3), np.uint8)


def plane(height: int, width: int) -> np.ndarray:
    """Depth of a slanted plane, by the same rays at any resolution."""
    y, x = ((np.arange(n) + 0.5) / n for n in (height, width))
    return 1 / (0.4 + 0.2 * x[None] + 0.1 * y[:, None])


class TestScaling:
    @given(st.integers(4, 9), st.integers(4, 9), st.integers(2, 5))
    def test_planes_are_exact(self, height: int, width: int, times: int) -> None:
        found = scale_depth(plane(height, width), (height * times, width * times))
        inside = (slice(times, -times),) * 2  # the margin repeats the outermost pixel
        wanted = plane(height * times, width * times)[inside]
        # Where depth differs by over 5 % from pixel to pixel the nearest counts.
        steep = np.abs(np.diff(plane(height, width))).max() > 0.04
        assert found[inside] == pytest.approx(wanted, rel=0.1 if steep else 1e-4)

    @given(st.integers(0, 2**32 - 1), st.integers(1, 4), st.integers(1, 4))
    def test_no_depth_between_two_surfaces(self, seed: int, down: int, across: int) -> None:
        depth = np.random.default_rng(seed).choice([1.0, 2.0, np.nan], (5, 7))
        found = scale_depth(depth, (5 * down, 7 * across))
        nearest = np.repeat(np.repeat(depth, down, 0), across, 1)
        assert np.array_equal(found, nearest, equal_nan=True)
        fewer = scale_depth(found, depth.shape)
        assert np.array_equal(fewer, depth, equal_nan=True)

    def test_the_scene_says_so(self) -> None:
        scene = Scene.from_rgbd(RGB, plane(6, 8), (30, 30, 15.5, 11.5))
        assert scene.depth is not None
        assert scene.depth.shape == (24, 32)
        assert scene.warnings == (
            "the depth map of 8 x 6 is taken to show the view of the image and scaled to its "
            "32 x 24; register it first if it does not",
        )

    def test_the_camera_of_the_depth_map(self) -> None:
        wanted = Intrinsics(30, 30, 15.5, 11.5, 32, 24)
        small = wanted.scaled_to(8, 6)
        four = (small.fx, small.fy, small.cx, small.cy)
        for camera in (wanted, small, four, (30, 30, 15.5, 11.5)):
            found = Scene.from_rgbd(RGB, plane(6, 8), camera).intrinsics
            assert found is not None
            assert (found.fx, found.cx, found.cy) == pytest.approx((30, 15.5, 11.5))

    def test_another_shape_asks_for_register(self) -> None:
        with pytest.raises(GeohueError) as caught:
            Scene.from_rgbd(np.zeros((108, 192, 3), np.uint8), np.ones((424, 512)))
        assert str(caught.value) == (
            "image and depth differ: 192 x 108 and 512 x 424; register the depth to the image "
            "first (geohue register, geohue.sensors.register_depth)"
        )

    @given(st.integers(1, 6), st.integers(1, 6))
    def test_nearest_undoes_itself(self, down: int, across: int) -> None:
        values = np.arange(12).reshape(3, 4)
        larger = sample_nearest(values, (3 * down, 4 * across))
        assert np.array_equal(sample_nearest(larger, (3, 4)), values)


class TestOrientation:
    @pytest.mark.parametrize("mark", range(1, 9))
    def test_as_pillow_turns_it(self, mark: int) -> None:
        from PIL import ImageOps

        pixels = np.random.default_rng(mark).integers(0, 255, (4, 6, 3)).astype(np.uint8)
        image = Image.fromarray(pixels)
        image.getexif()[0x0112] = mark
        assert np.array_equal(upright(pixels, mark), np.asarray(ImageOps.exif_transpose(image)))

    @pytest.mark.parametrize("mark", range(1, 9))
    def test_points_turn_with_their_pixels(self, mark: int) -> None:
        camera = Intrinsics(9.0, 8.0, 1.5, 2.5)
        depth = np.random.default_rng(0).uniform(1, 2, (4, 6)).astype(np.float32)
        before = upright(camera.unproject(depth), mark)
        turned = upright_camera(camera, mark, 6, 4)
        after = turned.unproject(upright(depth, mark))
        assert after[..., 2] == pytest.approx(before[..., 2])
        # Turning and mirroring keep the distance from the axis.
        away = [np.linalg.norm(points[..., :2], axis=-1) for points in (before, after)]
        assert away[1] == pytest.approx(away[0], rel=1e-5)

    @pytest.fixture
    def photo(self, tmp_path: Path) -> Path:
        """A picture that is stored lying, marked to be turned to the right."""
        pixels = np.zeros((24, 32, 3), np.uint8)
        pixels[:4] = (250, 10, 10)
        image = Image.fromarray(pixels)
        exif = image.getexif()
        exif[0x0112] = 6
        image.save(tmp_path / "photo.jpg", exif=exif, quality=95)
        return tmp_path / "photo.jpg"

    def test_all_that_lies_is_turned_together(self, photo: Path) -> None:
        lying, standing = plane(6, 8), upright(plane(6, 8), 6)
        camera = Intrinsics(30, 31, 15, 11, 32, 24)
        turned = upright_camera(camera, 6, 32, 24)
        scenes = [
            Scene.from_rgbd(photo, lying, camera),
            Scene.from_rgbd(photo, lying, turned),
            Scene.from_rgbd(photo, standing, turned),
            Scene.from_rgbd(photo, standing, camera),
            Scene.from_rgbd(photo, standing, (turned.fx, turned.fy, turned.cx, turned.cy)),
            Scene.from_rgbd(photo, lying, (camera.fx, camera.fy, camera.cx, camera.cy)),
        ]
        for scene in scenes:
            assert scene.shape == (32, 24)
            assert scene.colors[16, 22, 0] > 200  # the upper edge has come to the right
            assert scene.colors[16, 2, 0] < 50
            assert scene.points == pytest.approx(scenes[0].points, rel=1e-5)
        assert scenes[0].warnings[0] == (
            "the picture, its depth map and the intrinsics turned upright, as the picture's mark "
            "(EXIF orientation 6) says"
        )
        assert scenes[2].warnings[0].startswith("the picture turned upright")
        assert swaps_sides(6)
        assert not swaps_sides(3)

    def test_a_mask_of_either_orientation(self, photo: Path) -> None:
        mask = np.ones((24, 32), np.uint8)
        mask[:4] = 0
        depth = np.ones((24, 32))
        for given_mask in (mask, upright(mask, 6)):
            scene = Scene.from_rgbd(photo, depth, mask=given_mask)
            assert scene.left_out is not None
            assert scene.left_out[:, -4:].all()
            assert not scene.left_out[:, :-4].any()


class TestTrust:
    DEPTH = np.tile(np.array([0.5, 1.0, 2.0, 8.0]), (24, 8))

    def kept(self, **trust: object) -> list[float]:
        depth = Scene.from_rgbd(RGB, self.DEPTH, (30, 30, 15.5, 11.5), **trust).depth  # type: ignore[arg-type]
        assert depth is not None
        return sorted(set(depth[np.isfinite(depth)].tolist()))

    def test_limits(self) -> None:
        assert self.kept(min_depth=1.0, max_depth=2.0) == [1.0, 2.0]
        assert self.kept(max_depth=0.9) == [0.5]

    def test_confidence_of_any_size_and_type(self) -> None:
        sure = np.tile(np.array([0, 1, 2, 2], np.uint8), (24, 8))
        assert self.kept(confidence=sure) == [1.0, 2.0, 8.0]  # from half of the highest on
        assert self.kept(confidence=sure, least=2) == [2.0, 8.0]
        assert self.kept(confidence=sure * 100, least=150) == [2.0, 8.0]
        assert self.kept(confidence=(sure / 2).astype(np.float32)[..., None]) == [1.0, 2.0, 8.0]
        assert self.kept(confidence=np.repeat(np.repeat(sure, 2, 0), 2, 1)) == [1.0, 2.0, 8.0]
        scene = Scene.from_rgbd(RGB, self.DEPTH, (30, 30, 15.5, 11.5), confidence=sure)
        assert scene.warnings == ("depth with a confidence below 1 is left out (25% of it)",)

    @pytest.mark.parametrize(
        ("trust", "message"),
        [
            ({"min_depth": 3, "max_depth": 2}, "min_depth=3 and max_depth=2 leave no depth"),
            ({"min_depth": -1}, "min_depth is -1: expected metres"),
            ({"max_depth": 0.1}, "no depth is left within min_depth, max_depth"),
            ({"least": 2}, "give confidence too"),
            ({"confidence": np.ones((24, 30))}, "the confidence is 30 x 24, the depth map 32 x 24"),
            ({"confidence": RGB}, "a number for each pixel"),
            ({"mask": np.ones((5, 5))}, "the mask is 5 x 5, the image 32 x 24"),
        ],
    )
    def test_mistakes(self, trust: dict[str, object], message: str) -> None:
        with pytest.raises(GeohueError, match=message):
            self.kept(**trust)

    def test_files(self, tmp_path: Path) -> None:
        sure = np.tile(np.array([0, 1, 2, 2], np.uint8), (24, 8))
        cv2.imwrite(str(tmp_path / "conf.png"), sure)
        mask = np.full((24, 32, 3), 255, np.uint8)
        mask[:, 16:] = 0
        cv2.imwrite(str(tmp_path / "mask.png"), mask)
        scene = Scene.from_rgbd(
            RGB, self.DEPTH, confidence=tmp_path / "conf.png", mask=tmp_path / "mask.png"
        )
        assert scene.valid[:, :16].mean() == 0.75
        assert not scene.valid[:, 16:].any()
