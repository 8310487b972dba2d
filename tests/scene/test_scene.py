from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue import GeohueError, Intrinsics, Scene

RGB = np.zeros((4, 6, 3), np.uint8)
DEPTH = np.ones((4, 6), np.float32)


class TestFromRgbd:
    def test_points_by_hand(self) -> None:
        camera = Intrinsics(2.0, 4.0, 1.0, 3.0)
        points = Scene.from_rgbd(RGB, 8 * DEPTH, camera).points
        assert points[3, 1].tolist() == [0, 0, 8]
        assert points[1, 5].tolist() == [(5 - 1) / 2 * 8, (1 - 3) / 4 * 8, 8]

    def test_invalid_depth_becomes_a_gap(self) -> None:
        depth = DEPTH.copy()
        depth[0, :5] = [0, -1, np.nan, np.inf, -np.inf]
        scene = Scene.from_rgbd(RGB, depth)
        assert scene.valid[0].tolist() == [False] * 5 + [True]
        assert np.isnan(scene.points[0, 0]).all()

    def test_integer_depth_takes_metres_per_unit(self) -> None:
        scene = Scene.from_rgbd(RGB, np.full((4, 6), 1500, np.uint16), depth_scale=0.001)
        assert scene.depth is not None
        assert scene.depth[0, 0] == 1.5

    def test_camera_of_another_size_is_scaled_and_said_so(self) -> None:
        scene = Scene.from_rgbd(RGB, DEPTH, Intrinsics(12, 12, 5.5, 3.5, 12, 8))
        assert scene.intrinsics == Intrinsics(6, 6, 2.5, 1.5, 6, 4)
        assert "12 x 8" in scene.warnings[0]

    def test_guessed_camera_is_said_so(self) -> None:
        assert "no intrinsics" in Scene.from_rgbd(RGB, DEPTH).warnings[0]
        assert Scene.from_rgbd(RGB, DEPTH, Intrinsics.guess(6, 4)).warnings == ()

    def test_grey_images(self) -> None:
        scene = Scene.from_rgbd(np.full((4, 6), 7, np.uint8), DEPTH)
        assert scene.colors[0, 0].tolist() == [7, 7, 7]

    @pytest.mark.parametrize(
        ("rgb", "depth", "message"),
        [
            (RGB, np.ones((4, 7)), "6 x 4 and 7 x 4"),
            (RGB, np.ones((4, 6, 3)), "one channel"),
            (RGB, np.ones((4, 6), np.uint16), "depth_scale=0.001"),
            (RGB, np.ones((4, 6), complex), "complex128"),
            (RGB + 200.0, DEPTH, "divide it by 255"),
            (RGB - 1.0, DEPTH, "expected uint8"),
            (RGB.astype(np.int32) + 256, DEPTH, "expected uint8"),
            (np.zeros((4, 6, 2), np.uint8), DEPTH, r"\(4, 6, 2\)"),
            (np.zeros((0, 6, 3), np.uint8), np.ones((0, 6)), r"\(0, 6, 3\)"),
        ],
    )
    def test_bad_input(self, rgb: np.ndarray, depth: np.ndarray, message: str) -> None:
        with pytest.raises(GeohueError, match=message):
            Scene.from_rgbd(rgb, depth)

    @pytest.mark.parametrize("scale", [0.0, -1.0, np.nan, np.inf])
    def test_bad_scale(self, scale: float) -> None:
        with pytest.raises(GeohueError, match="metres per unit"):
            Scene.from_rgbd(RGB, DEPTH, depth_scale=scale)

    @pytest.mark.parametrize("bad", [{"fx": 0.0}, {"fy": -1.0}, {"cx": np.nan}, {"width": 0}])
    def test_bad_intrinsics(self, bad: dict[str, float]) -> None:
        values: dict[str, float] = {"fx": 1, "fy": 1, "cx": 0, "cy": 0, "width": 4, "height": 4}
        with pytest.raises(GeohueError, match="intrinsics"):
            Intrinsics(**(values | bad))  # type: ignore[arg-type]


class TestFromCloud:
    def test_far_coordinates_keep_their_detail(self) -> None:
        points = np.array([[500_000.001, 4e6, 100], [500_000.002, 4e6, 100]])
        scene = Scene.from_cloud(points, np.zeros((2, 3), np.uint8))
        assert np.diff(scene.points[:, 0])[0] == pytest.approx(0.001, rel=1e-3)

    def test_not_finite_points_are_missing(self) -> None:
        points = np.array([[0, 0, np.nan], [np.inf, 0, 0], [1, 2, 3], [1e300, 0, 0]])
        scene = Scene.from_cloud(points, np.zeros((4, 3)))
        assert scene.valid.tolist() == [False, False, True, False]

    def test_organised(self) -> None:
        scene = Scene.from_cloud(np.zeros((2, 3, 3)), np.zeros((2, 3, 3)))
        assert scene.is_grid
        assert scene.shape == (2, 3)

    @pytest.mark.parametrize(
        ("points", "colors", "message"),
        [
            (np.zeros((5, 2)), np.zeros((5, 3)), r"\(5, 2\)"),
            (np.zeros((5, 3)), np.zeros((4, 3)), "differ in shape"),
            (np.zeros((5, 3)), np.full((5, 3), 200.0), "0..1"),
            (np.zeros((5, 3)), np.full((5, 3), np.nan), "0..1"),
            (np.zeros((5, 3)), np.full((5, 3), 1 << 20), "int64"),
            (np.array([["a", "b", "c"]]), np.zeros((1, 3)), "numbers"),
        ],
    )
    def test_bad_input(self, points: np.ndarray, colors: np.ndarray, message: str) -> None:
        with pytest.raises(GeohueError, match=message):
            Scene.from_cloud(points, colors)


class TestThinning:
    def test_a_grid_keeps_a_grid(self) -> None:
        scene = Scene.from_rgbd(np.zeros((48, 64, 3), np.uint8), np.ones((48, 64)))
        positions = scene.thinning(200, np.random.default_rng(0))
        assert positions.shape == (12, 16)
        assert scene.take(positions).shape == (12, 16)
        assert np.diff(positions[0]).tolist() == [4] * 15

    def test_a_cloud_is_drawn_by_value_not_by_order(self) -> None:
        rng = np.random.default_rng(0)
        points, colors = rng.normal(size=(500, 3)), rng.integers(0, 255, (500, 3)).astype(np.uint8)
        order = rng.permutation(500)
        one = Scene.from_cloud(points, colors)
        two = Scene.from_cloud(points[order], colors[order])
        drawn = [s.take(s.thinning(50, np.random.default_rng(3))).points for s in (one, two)]
        assert np.array_equal(drawn[0], drawn[1])

    def test_small_scenes_stay_whole(self) -> None:
        scene = Scene.from_image(np.zeros((3, 3, 3), np.uint8))
        assert scene.thinning(100, np.random.default_rng(0)).ravel().tolist() == list(range(9))

    def test_distances_beyond_float32_come_last(self) -> None:
        points = np.array([[1, 0, 0], [-1, 3.4e38, 3.4e38], [-1, -3.4e38, 0], [1, 1, 1]])
        scene = Scene.from_cloud(points, np.zeros((4, 3), np.uint8))
        assert sorted(scene.thinning(9, np.random.default_rng(0)).tolist()) == [0, 1, 2, 3]


def test_the_median_of_depths_near_the_end_of_float32() -> None:
    scene = Scene.from_rgbd(np.zeros((1, 2, 3), np.uint8), np.full((1, 2), 3.4e38))
    assert any("3.4e+38 m" in note for note in scene.warnings)


class TestNormals:
    @given(seed=st.integers(0, 999), grid=st.booleans(), scale=st.sampled_from([1e-3, 1.0, 500.0]))
    def test_have_length_1_and_go_with_their_points(
        self, seed: int, grid: bool, scale: float
    ) -> None:
        rng = np.random.default_rng(seed)
        shape = (4, 5, 3) if grid else (20, 3)
        points, given_ = rng.normal(size=shape), rng.normal(0, scale, shape)
        flat = given_.reshape(-1, 3)
        flat[3], flat[7, 1], flat[9, 2] = 0, np.nan, np.inf
        scene = Scene.from_cloud(points, np.zeros(shape, np.uint8), given_)
        positions = rng.permutation(20)[:12].reshape(3, 4)
        part = scene.take(positions)
        assert scene.normals is not None
        assert part.normals is not None
        assert scene.normals.dtype == np.float32
        assert scene.normals.shape == shape
        assert part.normals.shape == part.points.shape == (3, 4, 3)
        for i, normal in zip(positions.ravel(), part.normals.reshape(-1, 3), strict=True):
            if i in (3, 7, 9):
                assert np.isnan(normal).all()
            else:
                assert normal == pytest.approx(flat[i] / np.linalg.norm(flat[i]), abs=1e-6)

    def test_are_none_where_none_are_given(self) -> None:
        scene = Scene.from_cloud(np.eye(3), np.zeros((3, 3), np.uint8))
        assert scene.normals is None
        assert scene.take(np.array([1])).normals is None

    @pytest.mark.parametrize("normals", [np.zeros((2, 3)), np.zeros(3), np.full((3, 3), "x")])
    def test_of_another_shape_or_kind_are_refused(self, normals: NDArray[Any]) -> None:
        with pytest.raises(GeohueError, match=r"normals have shape .* of the points, \(3, 3\)"):
            Scene.from_cloud(np.eye(3), np.zeros((3, 3), np.uint8), normals)
