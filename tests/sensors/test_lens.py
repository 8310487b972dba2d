"""Lenses: projections worked by hand, OpenCV as the second opinion, and inverses."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from geohue import GeohueError, Intrinsics
from geohue.sensors import Lens
from sensors.rigs import BENT, CAMERA

OPENCV: Any = cv2
LENSES = [
    Lens(CAMERA),
    Lens(CAMERA, BENT),
    Lens(CAMERA, (0.1, -0.05, 0.001, 0.002)),
    Lens(CAMERA, (0.4, 0.1, 0.0005, -0.0003, 0.02, 0.7, 0.2, 0.05)),
    Lens(CAMERA, (*BENT, 0.0, 0.0, 0.0, 0.001, 0.0, -0.002, 0.0)),
    Lens(CAMERA, (0.02, -0.01, 0.003, -0.001), "fisheye"),
    Lens(CAMERA, BENT, "inverse"),
]


def matrix(camera: Intrinsics) -> NDArray[np.float64]:
    return np.array([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]])


def points(seed: int = 0) -> NDArray[np.float64]:
    rng = np.random.default_rng(seed)
    z = rng.uniform(0.5, 5, 200)
    return np.stack([rng.uniform(-0.5, 0.5, 200) * z, rng.uniform(-0.4, 0.4, 200) * z, z], axis=1)


def test_projects_by_hand() -> None:
    lens = Lens(Intrinsics(200.0, 100.0, 10.0, 20.0))
    assert lens.project(np.array([[1.0, -2.0, 4.0]])).tolist() == [[60.0, -30.0]]
    # r = 0.5, so r2 = 0.25: the radial factor is 1 + 0.4 * 0.25 = 1.1
    bent = Lens(Intrinsics(100.0, 100.0, 0.0, 0.0), (0.4, 0.0, 0.0, 0.0))
    assert bent.project(np.array([[1.0, 0.0, 2.0]])) == pytest.approx(np.array([[55.0, 0.0]]))


@pytest.mark.parametrize("lens", LENSES[:5], ids=lambda lens: str(len(lens.distortion)))
def test_brown_is_that_of_opencv(lens: Lens) -> None:
    expected, _ = OPENCV.projectPoints(
        points(), np.zeros(3), np.zeros(3), matrix(CAMERA), np.array(lens.distortion or (0.0,) * 5)
    )
    assert lens.project(points()) == pytest.approx(expected.reshape(-1, 2), abs=1e-4)


def test_fisheye_is_that_of_opencv() -> None:
    lens = LENSES[5]
    expected, _ = OPENCV.fisheye.projectPoints(
        points().reshape(-1, 1, 3),
        np.zeros(3),
        np.zeros(3),
        matrix(CAMERA),
        np.array(lens.distortion),
    )
    assert lens.project(points()) == pytest.approx(expected.reshape(-1, 2), abs=1e-4)


@pytest.mark.parametrize("lens", LENSES, ids=lambda lens: f"{lens.model}{len(lens.distortion)}")
def test_rays_project_to_their_pixels(lens: Lens) -> None:
    rays = lens.rays(80, 100)
    rows, columns = np.mgrid[0:80, 0:100]
    pixels = lens.project(3.0 * rays.reshape(-1, 3)).reshape(80, 100, 2)
    assert pixels[..., 0] == pytest.approx(columns, abs=2e-3)
    assert pixels[..., 1] == pytest.approx(rows, abs=2e-3)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.floats(-0.3, 0.3), min_size=2, max_size=2),
    st.lists(st.floats(-0.01, 0.01), min_size=2, max_size=2),
)
def test_straightening_undoes_bending_or_gives_nothing(
    radial: list[float], tangential: list[float]
) -> None:
    lens = Lens(CAMERA, (*radial, *tangential))
    pixels = np.random.default_rng(1).uniform(0, 80, (50, 2))
    flat = lens.unproject(pixels)
    known = np.isfinite(flat).all(axis=1)
    rays = np.hstack([flat[known], np.ones((int(known.sum()), 1))])
    again = lens.project(rays)
    seen = np.isfinite(again).all(axis=1)
    assert again[seen] == pytest.approx(pixels[known][seen], abs=1e-2)


def test_points_beyond_the_model_and_behind_are_nowhere() -> None:
    lens = Lens(CAMERA, (-0.3, 0.0, 0.0, 0.0))  # the radius turns back at r = 1.05
    wide = np.array([[3.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, 0.0, 0.0], [0.5, 0.0, 1.0]])
    assert np.isfinite(lens.project(wide)).all(axis=1).tolist() == [False, False, False, True]


@pytest.mark.parametrize(
    ("distortion", "model", "cause"),
    [
        ((0.1,), "brown", "1 distortion coefficients"),
        ((0.0,) * 5, "fisheye", "expected 0 or 4"),
        ((np.nan, 0.0, 0.0, 0.0), "brown", "not finite"),
        ((0.0,) * 12 + (0.1, 0.0), "brown", "tilted"),
        ((), "cubic", "choose one of"),
    ],
)
def test_refuses_what_is_no_lens(distortion: tuple[float, ...], model: Any, cause: str) -> None:
    with pytest.raises(GeohueError, match=cause):
        Lens(CAMERA, distortion, model)
