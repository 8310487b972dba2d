"""Every pair of the real data: read, matched, warped; a few segmented."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from geohue import Scene, segment
from geohue.errors import GeohueError
from geohue.read import read_color
from geohue.read.cameras.stereo_calibration import read_stereo_calibration
from geohue.read.images.disparity import read_disparity
from geohue.stereo import StereoPair, match, view_agreement, warp_right
from geohue.stereo.evidence import doubt_disparity, looks_unrectified, match_features

Image = NDArray[np.uint8]

# bad pixels (> 1 px) in per cent and density that the matching must reach, and the warping error
THIRD = {
    "Aloe": (5, 0.8, 4), "Baby1": (5, 0.85, 3), "Baby2": (5, 0.85, 3), "Bowling1": (9, 0.7, 3),
    "Cloth1": (2, 0.85, 4), "Flowerpots": (11, 0.75, 3), "Lampshade1": (9, 0.75, 2),
    "Midd1": (25, 0.55, 3), "Monopoly": (9, 0.6, 10), "Plastic": (23, 0.5, 4),
    "Wood1": (4, 0.75, 3),
}  # fmt: skip
OAK = (
    *("bedroom_chair", "corridor", "cycles", "desk", "donkey_toy", "kid_bedroom", "living_room"),
    *("pov_controllers", "pov_hands", "selfie", "stairs", "toy"),
)


def folder(data_dir: Path, name: str) -> Path:
    path = data_dir / name
    if not path.is_dir():
        pytest.skip(f"no {name}")
    return path


def third(data_dir: Path, name: str) -> tuple[Image, Image, NDArray[np.float32]]:
    scene = folder(data_dir, "middlebury2006_third") / name
    truth = read_disparity(scene / "disp1.png", 1 / 3)
    assert truth.warnings == ()
    return read_color(scene / "view1.png"), read_color(scene / "view5.png"), truth.disparity


def halved(image: Image) -> Image:
    size = (image.shape[1] // 2, image.shape[0] // 2)
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.uint8)


@pytest.mark.parametrize("name", THIRD)
def test_middlebury_third(data_dir: Path, name: str) -> None:
    bad, density, error = THIRD[name]
    left, right, truth = third(data_dir, name)
    found = match(left, right)
    both = np.isfinite(truth) & np.isfinite(found.left)
    assert 100 * (np.abs(found.left - truth)[both] > 1).mean() < bad
    assert found.density > density
    matched, true = warp_right(left, right, found.left, found.right), warp_right(left, right, truth)
    assert matched.error is not None
    assert true.error is not None
    assert max(matched.error, true.error) <= error
    assert doubt_disparity(left, right, truth) is None


@pytest.mark.parametrize(
    ("scene", "truth"), [("Aloe/Aloe", "Aloe/Aloe"), ("Baby/Baby1", "Baby/Baby")]
)
def test_middlebury_half(data_dir: Path, scene: str, truth: str) -> None:
    data = folder(data_dir, "middlebury_half")
    left, right = (read_color(data / scene / f"view{n}.png") for n in (1, 5))
    disparity = read_disparity(data / truth / "disp1.png", 1 / 2).disparity
    rig = read_stereo_calibration(data / scene / "dmin.txt")
    made = Scene.from_stereo(left, right, rig, disparity)
    assert [note for note in made.warnings if "Middlebury" not in note] == []
    assert made.depth is not None
    dmin = float((data / scene / "dmin.txt").read_text())
    expected = 3.740 * 160 / (2 * disparity + dmin)
    np.testing.assert_allclose(made.depth, expected, rtol=1e-4)


def test_full_size_aloe(data_dir: Path) -> None:
    data = folder(data_dir, "opencv_samples")
    left, right = (read_color(data / f"aloe{side}.jpg") for side in "LR")
    truth = read_disparity(data / "aloeGT.png")
    assert "whole pixels" in truth.warnings[0]
    error = warp_right(left, right, truth.disparity).error
    assert error is not None
    assert error <= 5


def test_kitti(data_dir: Path) -> None:
    data = folder(data_dir, "kitti_stereo_lidar") / "demo"
    rig = read_stereo_calibration(data / "calib.txt")
    assert rig.left.fx == pytest.approx(721.54, abs=0.01)
    assert rig.baseline == pytest.approx(0.5327, abs=1e-4)
    left, right = (read_color(data / f"{side}.png") for side in ("left", "right"))
    small = halved(left), halved(right)
    pair = StereoPair.prepare(*small, rig.scaled_to(1242, 375), disparity_range=(0, 90))
    warp = pair.warp()
    assert warp.error is not None
    assert warp.error <= 8
    assert np.isfinite(pair.depth).mean() > 0.5
    assert 4 < np.nanmedian(pair.depth) < 40


@pytest.mark.parametrize("name", OAK)
def test_oak_d(data_dir: Path, name: str) -> None:
    data = folder(data_dir, "stereodemo_oakd")
    rig = read_stereo_calibration(data / "stereodemo_calibration.json")
    left, right = (halved(read_color(data / f"{name}_{side}.png")) for side in ("left", "right"))
    pair = StereoPair.prepare(left, right, rig)
    assert pair.rig.baseline == 0.075
    assert all("scaled to" in note or "depth" in note for note in pair.warnings)
    error = pair.warp().error
    assert error is not None
    assert error <= 5
    assert 0.3 < np.nanmedian(pair.depth) < 6


def test_motorcycle() -> None:
    from skimage.data import stereo_motorcycle

    left, right, truth = stereo_motorcycle()
    found = match(left, right)
    both = np.isfinite(truth) & np.isfinite(found.left)
    assert (np.abs(found.left - truth)[both] > 2).mean() < 0.1
    error = warp_right(left, right, np.where(np.isfinite(truth), truth, np.nan)).error
    assert error is not None
    assert error <= 6


# --- bad input, on real pictures -----------------------------------------------------------------


def test_raw_values_are_noticed_as_a_wrong_scale(data_dir: Path) -> None:
    left, right, truth = third(data_dir, "Aloe")
    scene = Scene.from_stereo(left, right, disparity=truth * 3)
    assert any("divided by 3" in note for note in scene.warnings)


def test_exchanged_views_are_noticed(data_dir: Path) -> None:
    left, right, _ = third(data_dir, "Baby2")
    with pytest.raises(GeohueError, match="look exchanged"):
        Scene.from_stereo(right, left)


def test_the_disparity_of_the_other_view_is_no_error_but_a_wrong_sign_is(data_dir: Path) -> None:
    left, right, truth = third(data_dir, "Baby1")
    with pytest.raises(GeohueError, match=r"sign is wrong.*with the other sign"):
        Scene.from_stereo(left, right, disparity=-truth)


def test_checkerboard_pair_is_noticed_as_raw(data_dir: Path) -> None:
    data = folder(data_dir, "opencv_samples")
    left, right = (read_color(data / f"{side}01.jpg") for side in ("left", "right"))
    evidence = looks_unrectified(match_features(left, right))
    assert evidence is not None
    assert "10" in evidence


# --- segments ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["Aloe", "Baby2"])
def test_segments_from_matched_and_true_disparity_agree(data_dir: Path, name: str) -> None:
    from geohue.measures import evaluate

    left, right, truth = third(data_dir, name)
    labels = [
        segment(Scene.from_stereo(left, right, disparity=d), k=4, weight=2.0).labels
        for d in (None, truth)
    ]
    assert all((found >= 0).all() for found in labels)
    assert evaluate(labels[0], labels[1], ignore=None)["rand"] > 0.75


def test_both_views_of_a_real_pair_agree(data_dir: Path) -> None:
    left, right, _ = third(data_dir, "Baby2")
    pair = StereoPair.prepare(left, right)
    first = segment(Scene.from_pair(pair), k=3, weight=4.0).labels
    second = segment(Scene.from_pair(pair.swapped()), k=3, weight=4.0).labels[:, ::-1]
    share = view_agreement(first, second, pair.disparity).share
    assert share is not None
    assert share > 0.85


def test_grey_pair_is_segmented(data_dir: Path) -> None:
    data = folder(data_dir, "stereodemo_oakd")
    rig = read_stereo_calibration(data / "stereodemo_calibration.json")
    left, right = (halved(read_color(data / f"toy_{side}.png")) for side in ("left", "right"))
    assert segment(Scene.from_stereo(left, right, rig), k=4).k == 4
