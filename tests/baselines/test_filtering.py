"""The mean shift filter: by hand, against a slow twin, loosely against OpenCV."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from geohue.baselines.filtering import MOST_STEPS, STILL, shift_filter
from geohue.compute.parallel import workers

Floats = NDArray[np.float32]


def fast(
    values: Floats, depth: Floats, trust: Floats, weight: Floats, radius: float, threads: int = 1
) -> Floats:
    with workers(threads) as team:
        return shift_filter(values, depth, trust, weight, radius, team)


def slow_filter(
    values: Floats, depth: Floats, trust: Floats, weight: Floats, radius: float
) -> NDArray[np.float64]:
    """The definition, pixel by pixel over the whole image."""
    height, width = depth.shape
    y, x = np.mgrid[:height, :width].astype(float)
    v, d, c, w = (a.astype(float) for a in (values, depth, trust, weight))
    modes = np.empty((height, width, 5))
    for i in range(height):
        for j in range(width):
            py, px, pv, pd, pc = float(i), float(j), v[i, j], d[i, j], c[i, j]
            for _ in range(MOST_STEPS):
                near = (y - py) ** 2 + (x - px) ** 2 <= radius**2
                near &= ((v - pv) ** 2).sum(axis=2) + pc * c * (d - pd) ** 2 <= 1
                share = w * near
                total = share.sum()
                if total == 0:
                    break
                ny, nx = (share * y).sum() / total, (share * x).sum() / total
                nv = (share[..., None] * v).sum(axis=(0, 1)) / total
                sure = (share * c).sum()
                nd = (share * c * d).sum() / sure if sure > 0 else pd
                moved = ((ny - py) ** 2 + (nx - px) ** 2) / radius**2
                moved += ((nv - pv) ** 2).sum() + pc * (nd - pd) ** 2
                py, px, pv, pd, pc = ny, nx, nv, nd, sure / total
                if moved < STILL**2:
                    break
            modes[i, j] = [*pv, pd, pc]
    return modes


@pytest.mark.parametrize("with_depth", [False, True])
def test_equals_the_slow_twin(with_depth: bool) -> None:
    rng = np.random.default_rng(6)
    values = rng.normal(0, 0.35, (16, 18, 3)).astype(np.float32)
    values[:, 9:] += 1
    depth = rng.normal(0, 0.3, (16, 18)).astype(np.float32) * with_depth
    depth[8:] += np.float32(1.5 * with_depth)
    trust = rng.random((16, 18)).astype(np.float32) * with_depth
    weight = rng.random((16, 18)).astype(np.float32)
    got = fast(values, depth, trust, weight, 4.0)
    want = slow_filter(values, depth, trust, weight, 4.0)
    # A pixel at the very rim of a window may fall on either side by rounding.
    off = np.abs(got - want).max(axis=2) > 1e-3
    assert off.mean() < 0.01


def test_four_pixels_by_hand() -> None:
    # Values 0, 0.4, 0.8, 3 in a row, radius 1. Pixel 0 sees 0 and 0.4: moves to (0.5, 0.2);
    # from there pixels 0 and 1 again: at rest. Pixel 3 sees itself alone.
    values = np.zeros((1, 4, 3), np.float32)
    values[0, :, 0] = [0, 0.4, 0.8, 3]
    none, ones = np.zeros((1, 4), np.float32), np.ones((1, 4), np.float32)
    modes = fast(values, none, none, ones, 1.0)[0, :, 0]
    np.testing.assert_allclose(modes, [0.2, 0.4, 0.6, 3.0], atol=1e-6)
    weight = np.array([[1, 0, 1, 1]], np.float32)  # pixel 1 lies on an edge
    modes = fast(values, none, none, weight, 1.0)[0, :, 0]
    np.testing.assert_allclose(modes[[0, 2, 3]], [0, 0.8, 3], atol=1e-6)


def test_depth_parts_equal_colours_as_far_as_it_is_trusted() -> None:
    values = np.zeros((6, 8, 3), np.float32)
    depth = np.zeros((6, 8), np.float32)
    depth[:, 4:] = 3
    ones = np.ones((6, 8), np.float32)
    np.testing.assert_array_equal(fast(values, depth, ones, ones, 3.0)[..., 3], depth)
    blind = fast(values, depth, ones * 0, ones, 3.0)
    assert (blind[..., 3] == depth).all()  # without trust depth does not move, and parts nothing
    trust = ones.copy()
    trust[:, 0] = 0  # missing: takes on the depth around it
    depth[:, 0] = 99
    np.testing.assert_array_equal(fast(values, depth, trust, ones, 3.0)[:, 0, 3], 0)


def test_weightless_pixels_stay() -> None:
    values = np.random.default_rng(7).random((5, 5, 3)).astype(np.float32)
    none = np.zeros((5, 5), np.float32)
    np.testing.assert_array_equal(fast(values, none, none, none, 3.0)[..., :3], values)


def test_threads_change_nothing() -> None:
    values = np.random.default_rng(8).random((40, 20, 3)).astype(np.float32)
    none, ones = np.zeros((40, 20), np.float32), np.ones((40, 20), np.float32)
    one, three = (fast(values, none, none, ones, 5.0, n) for n in (1, 3))
    np.testing.assert_array_equal(one, three)


def test_smooths_like_opencv() -> None:
    # OpenCV's window is a square and it shifts at several scales: alike, not equal.
    rng = np.random.default_rng(9)
    image = np.full((40, 40, 3), 60.0)
    image[:, 20:] = 160
    noisy = np.clip(image + rng.normal(0, 6, image.shape), 0, 255).astype(np.uint8)
    theirs = cv2.pyrMeanShiftFiltering(noisy, 7, 30, maxLevel=0)
    none, ones = np.zeros((40, 40), np.float32), np.ones((40, 40), np.float32)
    values = (noisy / 30).astype(np.float32)
    ours = fast(values, none, none, ones, 7.0)[..., :3] * 30
    assert np.abs(ours - theirs).mean() < 2
    assert np.abs(ours - image).mean() < 2
