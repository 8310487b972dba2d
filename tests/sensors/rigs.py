"""Cameras and rigs that several tests use."""

from __future__ import annotations

import numpy as np

from geohue import Intrinsics
from geohue.sensors import Lens, PosedCamera, Rig

CAMERA = Intrinsics(100.0, 100.0, 49.5, 39.5, 100, 80)
BENT = (0.12, -0.2, 0.002, -0.001, 0.05)


def rotation(axis: int, degrees: float) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Rotation about x, y or z."""
    angle = np.radians(degrees)
    i, j = [k for k in range(3) if k != axis]
    R = np.eye(3)
    R[i, i] = R[j, j] = np.cos(angle)
    R[i, j], R[j, i] = -np.sin(angle), np.sin(angle)
    return R


def beside(shift: float, camera: Intrinsics = CAMERA, depth: Intrinsics = CAMERA) -> Rig:
    """A colour camera `shift` metres to the right of the depth camera, the axes parallel."""
    return Rig((PosedCamera(Lens(camera), np.eye(3), np.array([-shift, 0, 0])),), Lens(depth))
