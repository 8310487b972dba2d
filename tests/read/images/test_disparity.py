"""Disparity files: scales, guesses, and every mark for a missing value."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.read.images.disparity import parse_disparity_scale, read_disparity
from geohue.results import write_png

NAN = np.nan


def saved(folder: Path, name: str, values: NDArray[Any]) -> Path:
    file = folder / name
    if name.endswith(".npy"):
        np.save(file, values)
    elif name.endswith(".npz"):
        np.savez(file, disparity=values)
    elif name.endswith(".pfm"):
        head = f"Pf\n{values.shape[1]} {values.shape[0]}\n-1.0\n".encode()
        file.write_bytes(head + values[::-1].astype("<f4").tobytes())
    else:
        write_png(file, values)
    return file


def check(path: Path, expected: list[list[float]], scale: float | None = None) -> tuple[str, ...]:
    found = read_disparity(path, scale)
    assert found.disparity.dtype == np.float32
    np.testing.assert_allclose(found.disparity, expected, rtol=1e-6)
    return found.warnings


def test_eight_bits_with_a_scale(tmp_path: Path) -> None:
    file = saved(tmp_path, "d.png", np.array([[0, 60, 255]], np.uint8))
    assert check(file, [[NAN, 20, 85]], 1 / 3) == ()


def test_eight_bits_without_a_scale_is_a_guess(tmp_path: Path) -> None:
    file = saved(tmp_path, "d.png", np.array([[0, 60, 255]], np.uint8))
    (warning,) = check(file, [[NAN, 60, 255]])
    assert "taken as 1 pixels per unit (whole pixels)" in warning
    assert "disparity_scale" in warning


def test_kitti_is_recognised(tmp_path: Path) -> None:
    file = saved(tmp_path, "d.png", np.array([[0, 256, 5120, 65535]], np.uint16))
    (warning,) = check(file, [[NAN, 1, 20, NAN]])
    assert "1/256 pixels per unit (as KITTI writes it" in warning
    assert check(file, [[NAN, 1, 20, NAN]], 1 / 256) == ()


def test_sixteen_bits_of_small_values_are_pixels(tmp_path: Path) -> None:
    values = np.zeros((2, 100), np.uint16)
    values[0, 0] = 40
    found = read_disparity(saved(tmp_path, "d.png", values))
    assert found.scale == 1
    assert found.disparity[0, 0] == 40


def test_pfm_marks_missing_as_infinite(tmp_path: Path) -> None:
    values = np.array([[1.5, np.inf], [NAN, 0], [-2.5, 3]])
    assert check(saved(tmp_path, "d.pfm", values), [[1.5, NAN], [NAN, NAN], [-2.5, 3]]) == ()


@pytest.mark.parametrize("name", ["d.npy", "d.npz"])
def test_floats(tmp_path: Path, name: str) -> None:
    assert check(saved(tmp_path, name, np.array([[0.5, np.inf, 0]])), [[0.5, NAN, NAN]]) == ()
    assert check(saved(tmp_path, name, np.array([[0.5]])), [[2]], 4) == ()


def test_a_matchers_mark_is_missing(tmp_path: Path) -> None:
    """A whole negative value that is the lowest and frequent; single negatives stay."""
    values = np.linspace(-3.5, 90, 1000).reshape(20, 50)
    np.testing.assert_allclose(
        read_disparity(saved(tmp_path, "a.npy", values)).disparity, values, rtol=1e-6
    )
    values[:, 0] = -16
    found = read_disparity(saved(tmp_path, "b.npy", values)).disparity
    assert np.isnan(found[:, 0]).all()
    assert np.isfinite(found[:, 1:]).all()


def test_fixed_point(tmp_path: Path) -> None:
    file = saved(tmp_path, "d.npy", np.array([[-16, 32, 40]], np.int16))
    (warning,) = check(file, [[NAN, 2, 2.5]])
    assert "1/16" in warning


def test_mostly_negative_integers_stay_for_the_images_to_judge(tmp_path: Path) -> None:
    file = saved(tmp_path, "d.npy", np.array([[-16, -32, 0]], np.int32))
    check(file, [[-16, -32, NAN]], 1)


def test_nothing_known_is_said(tmp_path: Path) -> None:
    found = read_disparity(saved(tmp_path, "d.png", np.zeros((2, 2), np.uint8)), 1)
    assert "no pixel has a disparity" in found.warnings[0]


def test_grey_in_three_channels_is_read_and_colour_is_not(tmp_path: Path) -> None:
    grey = np.array([[3, 6]], np.uint8)[..., None].repeat(3, 2)
    check(saved(tmp_path, "g.png", grey), [[1, 2]], 1 / 3)
    grey[0, 0] = (1, 2, 3)
    with pytest.raises(GeohueError, match=r"colour picture; a disparity has one channel"):
        read_disparity(saved(tmp_path, "c.png", grey), 1)


@pytest.mark.parametrize("scale", [0, -1, np.inf, np.nan])
def test_impossible_scales(tmp_path: Path, scale: float) -> None:
    with pytest.raises(GeohueError, match="must be a positive number of pixels per unit"):
        read_disparity(tmp_path / "d.png", scale)


def test_broken_files(tmp_path: Path) -> None:
    with pytest.raises(GeohueError, match="no such file"):
        read_disparity(tmp_path / "none.png")
    (tmp_path / "text.png").write_text("no picture")
    with pytest.raises(GeohueError, match="not a picture"):
        read_disparity(tmp_path / "text.png")
    np.save(tmp_path / "words.npy", np.array([["a"]]))
    with pytest.raises(GeohueError, match="numbers"):
        read_disparity(tmp_path / "words.npy")


@pytest.mark.parametrize(
    ("text", "scale"), [("1/256", 1 / 256), ("0.25", 0.25), (" 1 / 3 ", 1 / 3), ("2", 2)]
)
def test_scales_as_text(text: str, scale: float) -> None:
    assert parse_disparity_scale(text) == scale


@pytest.mark.parametrize("text", ["", "a", "0", "-1/3", "1/0", "nan", "1e999"])
def test_texts_that_are_no_scale(text: str) -> None:
    with pytest.raises(GeohueError, match="positive number of pixels per unit"):
        parse_disparity_scale(text)
