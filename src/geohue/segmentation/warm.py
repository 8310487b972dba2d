"""Every compiled loop, compiled ahead of the first user."""

from __future__ import annotations

import numpy as np

from geohue.baselines import BASELINES
from geohue.scene import Scene
from geohue.segmentation.driver import segment
from geohue.settings import PRESETS


def compile_all() -> None:
    """Compile every loop by running every method on a small scene, so that no user waits for it.

    For images of machines and the like: what is compiled is kept in the folder that
    ``NUMBA_CACHE_DIR`` names, else beside the code, else in the user's cache.
    """
    part = np.arange(48) // 16
    rgb = np.random.default_rng(0).integers(0, 40, (36, 48, 3), np.uint8)
    rgb[..., 0] += (60 * part).astype(np.uint8)
    depth = np.tile(1.0 + part, (36, 1)).astype(np.float32)
    depth[10:20, 10:20] = np.nan
    depth[0, 0] = 90.0  # points far from all others take a loop of their own
    scene = Scene.from_rgbd(rgb, depth)
    for preset in PRESETS.own:
        segment(scene, preset=preset)
        segment(scene, k=3, preset=preset)
    for method, baseline in BASELINES.own.items():
        segment(scene, k=3, method=method, cues=baseline.cues[0])
    points = Scene.from_cloud(scene.points[scene.valid], scene.colors[scene.valid])
    segment(points, k=3)
