"""Raw disparities: values worked by hand, and the authors' own depth."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from geohue import GeohueError
from geohue.read import read_depth
from geohue.read.cameras.rig import read_rig
from geohue.read.images.raw_depth import read_range
from geohue.sensors import DisparityModel


def test_by_hand() -> None:
    model = DisparityModel(3.0, -0.0025)
    depth = model.depth(np.array([[0, 400, 1000, 1200, 2047]], np.uint16))
    assert depth[0, :3].tolist() == pytest.approx([1 / 3, 0.5, 2.0])
    assert np.isnan(depth[0, 3:]).all()  # beyond infinity; no measurement


def test_disparity_distortion() -> None:
    beta = np.array([[2.0, 0.0]])
    model = DisparityModel(3.0, -0.0025, (np.log(3.0), 0.0), beta)
    # 400 + 2 * 3 = 406: 1 / (3 - 1.015)
    depth = model.depth(np.array([[400, 400]]))
    assert depth[0].tolist() == pytest.approx([1 / 1.985, 0.5])
    with pytest.raises(GeohueError, match="has shape"):
        model.depth(np.zeros((2, 2)))


def test_farther_is_larger() -> None:
    depth = DisparityModel().depth(np.arange(300, 1050)[None])
    assert (np.diff(depth[0]) > 0).all()


@pytest.mark.parametrize("bad", [np.zeros((2, 2, 3)), np.full((2, 2), 5000)])
def test_refuses_what_is_no_disparity(bad: np.ndarray) -> None:
    with pytest.raises(GeohueError, match="raw Kinect disparities"):
        DisparityModel().depth(bad)
    with pytest.raises(GeohueError, match="c0 > 0 > c1"):
        DisparityModel(1.0, 0.5)


def test_real_disparities_agree_with_the_authors_depth(data_dir: Path) -> None:
    folder = data_dir / "herrera_kinect_2rgb"
    rig = read_rig(folder / "calibration.json")
    ours = read_range(folder / "0008-d.pgm", rig).depth
    theirs = read_depth(folder / "0008-depth_mm.png").depth
    both = np.isfinite(ours) & np.isfinite(theirs)
    assert both.mean() > 0.75
    # Without the distortion by pixel, which the folder does not have.
    assert np.median(np.abs(ours - theirs)[both] / theirs[both]) < 0.004
    typical = read_depth(folder / "0008-d.pgm", "kinect").depth
    assert np.median(np.abs(typical - theirs)[both] / theirs[both]) < 0.05
