"""A calibration that is off is brought back by the edges."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from geohue import GeohueError
from geohue.read import read_color, read_depth
from geohue.read.cameras.rig import read_rig
from geohue.sensors import (
    Lens,
    PosedCamera,
    Rig,
    edge_agreement,
    refine_translation,
    register_depth,
)
from sensors.rigs import CAMERA, beside


def boxes() -> tuple[NDArray[np.uint8], NDArray[np.float32], Rig]:
    """Three boxes before a wall, seen by both cameras; the picture is painted by depth."""
    depth = np.full((80, 100), 2.5, np.float32)
    depth[10:40, 20:40] = 1.0
    depth[45:70, 30:60] = 1.4
    depth[20:60, 70:85] = 1.2
    rig = beside(0.05)
    seen = np.nan_to_num(register_depth(depth, rig), nan=2.5)
    grey = (seen * 90).astype(np.uint8)
    return np.repeat(grey[..., None], 3, axis=2), depth, rig


def test_finds_the_translation_back() -> None:
    rgb, depth, rig = boxes()
    true = rig.cameras[0]
    off = replace(true, translation=true.translation + np.array([0.025, -0.015, 0]))
    found, before, after = refine_translation([(rgb, depth)], Rig((off,), rig.depth))
    assert after > 1.5 * before
    assert found.cameras[0].translation == pytest.approx(true.translation, abs=0.006)
    assert "T was changed" in found.warnings[0]


def test_leaves_a_good_one_alone() -> None:
    rgb, depth, rig = boxes()
    found, before, after = refine_translation([(rgb, depth)], rig)
    assert found is rig
    assert before == after


def test_refuses_frames_without_edges() -> None:
    rig = Rig((PosedCamera(Lens(CAMERA)),), Lens(CAMERA))
    flat = np.full((80, 100), 2.0, np.float32)
    with pytest.raises(GeohueError, match="no edges"):
        refine_translation([(np.zeros((80, 100, 3), np.uint8), flat)], rig)
    with pytest.raises(GeohueError, match="at least one frame"):
        refine_translation([], rig)


def test_one_real_frame_serves_the_others(data_dir: Path) -> None:
    folder = data_dir / "ist_maizena2" / "cam1"
    rig = read_rig(folder.parent / "calibration.json")

    def frame(number: int) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        name = folder / f"{number:02d}"
        return read_color(f"{name}_rgb.png"), read_depth(f"{name}_depth.png").depth

    found, _, _ = refine_translation([frame(3)], rig)
    for number in (1, 8):
        rgb, depth = frame(number)
        better = edge_agreement(rgb, register_depth(depth, found))
        assert better > 1.8 * edge_agreement(rgb, depth)
        assert better > 1.4 * edge_agreement(rgb, register_depth(depth, rig))
