"""Normals of grids and clouds: what they are on known shapes, and how they turn."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from geohue import Intrinsics
from geohue.merge.normals import cloud_normals, grid_normals

Floats = NDArray[np.float64]
law = settings(deadline=None, max_examples=15)


def slanted(shape: tuple[int, int] = (40, 50)) -> tuple[Floats, Floats]:
    """A plane before a camera, and its normal, which points away from the camera."""
    normal = np.array([0.3, -0.2, 0.9])
    normal /= np.linalg.norm(normal)
    height, width = shape
    rays = Intrinsics(60, 60, width / 2, height / 2).unproject(np.ones(shape, np.float32))
    rays = rays.astype(np.float64)
    return rays * (2 / (rays @ normal))[..., None], normal


def angle(normals: Floats, expected: Floats) -> Floats:
    return np.asarray(np.degrees(np.arccos(np.clip((normals * expected).sum(axis=-1), -1, 1))))


class TestGrid:
    def test_plane(self) -> None:
        """Exact where the blur does not fold the image at its border."""
        points, normal = slanted()
        assert angle(grid_normals(points), normal)[6:-6, 6:-6].max() < 0.1

    def test_quantised_noisy_depth(self) -> None:
        """Steps of 10 mm at 2 m turn differences of single pixels by tens of degrees."""
        points, normal = slanted()
        rng = np.random.default_rng(0)
        depth = points[..., 2] + rng.normal(0, 0.003, points.shape[:2])
        rough = points / points[..., 2:] * (np.round(depth / 0.01) * 0.01)[..., None]
        blurred, bare = angle(grid_normals(rough), normal), angle(grid_normals(rough, 0.1), normal)
        assert np.percentile(blurred, 90) < 6 < 10 < np.percentile(bare, 90)

    def test_blur_has_one_and_a_half_pixels(self) -> None:
        """The normal beside a fold is that of Gaussian weights of the two sides."""
        y, x = np.mgrid[:9.0, :41.0]
        normals = grid_normals(np.stack([x, y, np.abs(x - 20)], axis=-1))[4]
        slope = -normals[:, 0] / normals[:, 2]
        offsets = np.arange(-5, 6)  # truncated at 3 sigma
        weights = np.exp(-(offsets**2) / (2 * 1.5**2))
        weights /= weights.sum()
        for at in (17, 18, 20, 22, 24):
            blurred = [weights @ np.abs(at + s + offsets - 20) for s in (-1, 1)]
            assert slope[at] == pytest.approx((blurred[1] - blurred[0]) / 2, abs=1e-12)

    @given(st.integers(0, 2**20), st.floats(1e-6, 1e6))
    @law
    def test_turn_with_the_points(self, seed: int, scale: float) -> None:
        rng = np.random.default_rng(seed)
        points = np.cumsum(rng.random((7, 9, 3)), axis=1) + rng.random((7, 9, 3))
        pose = Rotation.random(rng=rng)
        moved = pose.apply(points.reshape(-1, 3)).reshape(points.shape) * scale + rng.normal(size=3)
        expected = pose.apply(grid_normals(points).reshape(-1, 3)).reshape(points.shape)
        np.testing.assert_allclose(grid_normals(moved), expected, atol=1e-5)

    @pytest.mark.parametrize("shape", [(1, 1), (1, 5), (5, 1), (2, 2), (3, 4)])
    def test_no_surface_no_normal(self, shape: tuple[int, int]) -> None:
        assert (grid_normals(np.ones((*shape, 3))) == 0).all()
        line = np.arange(shape[0] * shape[1]).reshape(*shape, 1) * np.array([1.0, 2, 3])
        assert np.abs(grid_normals(line)).max() < 1.0 + 1e-12  # noise at most, never NaN
        if min(shape) == 1:
            assert (grid_normals(line) == 0).all()


class TestCloud:
    def test_plane(self) -> None:
        rng = np.random.default_rng(1)
        pose = Rotation.random(rng=rng)
        points = pose.apply(np.c_[rng.random((400, 2)), np.zeros(400)])
        normals = cloud_normals(points)
        towards = pose.apply([0, 0, 1])
        side = np.sign(normals[0] @ towards)
        np.testing.assert_allclose(normals, np.tile(side * towards, (400, 1)), atol=1e-7)

    def test_sphere_points_inward_everywhere(self) -> None:
        rng = np.random.default_rng(2)
        out = rng.normal(size=(1500, 3))
        out /= np.linalg.norm(out, axis=1, keepdims=True)
        normals = cloud_normals(3 * out + [5, 6, 7] + rng.normal(0, 0.005, out.shape))
        assert angle(normals, -out).max() < 20
        assert np.median(angle(normals, -out)) < 4

    def test_two_balls_apart_each_for_itself(self) -> None:
        """Signs reach no other piece, and of each piece most normals look to the middle of all."""
        rng = np.random.default_rng(3)
        out = rng.normal(size=(800, 3))
        out /= np.linalg.norm(out, axis=1, keepdims=True)
        far = np.where(np.arange(800) < 400, -30.0, 30.0)[:, None] * [1, 0, 0]
        side = (cloud_normals(out + far) * out).sum(axis=1)
        for part in (side[:400], side[400:]):
            assert abs(np.sign(part).sum()) == 400

    def test_sixteen_neighbours(self) -> None:
        """The least spread of the 16 nearest, point by point."""
        points = np.random.default_rng(4).normal(size=(60, 3))
        normals = cloud_normals(points)
        for i, point in enumerate(points):
            near = np.argsort(((points - point) ** 2).sum(axis=1))[:16]
            _, vectors = np.linalg.eigh(np.cov(points[near].T))
            assert abs(vectors[:, 0] @ normals[i]) == pytest.approx(1, abs=1e-9)

    def test_signs_go_along_the_tree_that_turns_least(self) -> None:
        """A strip that curls by more than half a turn: neighbours agree, its ends do not."""
        angles = np.repeat(np.linspace(0, 1.5 * np.pi, 120), 8)
        points = np.c_[np.cos(angles), np.sin(angles), np.tile(np.linspace(0, 0.2, 8), 120)]
        normals = cloud_normals(points)
        radial = (normals[:, :2] * points[:, :2]).sum(axis=1)
        assert (np.sign(radial) == np.sign(radial[0])).all()

    def test_box(self) -> None:
        """Signs go around the edges, where normals turn little by little, not through them."""
        rng = np.random.default_rng(5)
        points = rng.uniform(-1, 1, (2400, 3))
        side = np.arange(2400) % 6
        points[np.arange(2400), side // 2] = np.where(side % 2, 1.0, -1.0)
        points[:, 2] *= 0.15
        inward = -np.sign(points) * np.eye(3)[side // 2]
        right = (cloud_normals(points) * inward).sum(axis=1) > 0
        assert right.mean() > 0.97

    @given(st.integers(0, 2**20), st.floats(1e-3, 1e3))
    @law
    def test_turn_with_the_points(self, seed: int, scale: float) -> None:
        rng = np.random.default_rng(seed)
        out = rng.normal(size=(300, 3))
        points = out / np.linalg.norm(out, axis=1, keepdims=True) * [1, 2, 3]
        pose = Rotation.random(rng=rng)
        found = cloud_normals(pose.apply(points) * scale + rng.normal(size=3))
        expected = pose.apply(cloud_normals(points))
        np.testing.assert_allclose((found * expected).sum(axis=1), 1, atol=1e-6)

    @pytest.mark.parametrize("n", [0, 1, 2])
    def test_too_few_points(self, n: int) -> None:
        assert cloud_normals(np.ones((n, 3))).tolist() == [[0, 0, 0]] * n

    @pytest.mark.parametrize(
        "points",
        [np.ones((30, 3)), np.arange(30.0)[:, None] * [1, 1, 1], np.eye(3), 1e30 * np.eye(3)],
        ids=["one place", "a line", "three points", "far apart"],
    )
    def test_degenerate(self, points: Floats) -> None:
        normals = cloud_normals(points)
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-9)
