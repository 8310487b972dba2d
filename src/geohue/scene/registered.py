"""A scene of a colour picture and a depth map that was not registered to it (Sec. VI)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.compute.checks import check_image
from geohue.scene.given import tell
from geohue.scene.scene import Scene
from geohue.sensors.registration import color_view, register_depth
from geohue.sensors.rig import Rig


def registered_scene(
    rgb: NDArray[np.uint8], depth: NDArray[np.floating[Any]], rig: Rig, camera: int = 0
) -> Scene:
    """Make a scene of a colour picture and an unregistered depth map.

    As `register_depth`, and the points lie on the true rays of the colour camera, so that the
    picture needs no undistortion.

    Parameters
    ----------
    rgb : (H, W, 3) or (H, W) uint8
        The colour picture.
    depth : (h, w) float
        Metres, of the rig's depth camera.
    rig : Rig
        Depth camera and colour cameras.
    camera : int
        Which of the rig's colour cameras took the picture.

    Returns
    -------
    Scene
        On the grid of the colour picture.
    """
    height, width = np.asarray(rgb).shape[:2]
    view, _, _ = color_view(rig, camera, (width, height))
    metres = register_depth(depth, rig, (width, height), camera)
    points = view.lens.rays(height, width) * metres[..., None]
    points[~np.isfinite(points).all(axis=-1)] = np.nan
    scene = Scene(check_image(rgb), points, metres, view.lens.camera, warnings=rig.warnings)
    tell(scene.warnings)
    return scene
