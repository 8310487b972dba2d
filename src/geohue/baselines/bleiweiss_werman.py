"""Bleiweiss and Werman [17]: mean shift on place, colour and depth together (Fig. 11f, 12f, 13c).

Re-implemented from the description: each pixel is the vector
``(x / h_s, y / h_s, L / h_r, u / h_r, v / h_r, D / h_d)``, with the bandwidths as weights set by
hand, and moves to its mode in the image plane (`filtering`). Depth counts by a confidence per
pixel: 1 where there is depth and 0 where it is missing, unless one is given. Modes closer than
half a bandwidth join, and small regions join a neighbour, as in the mean shift segmentation it
builds on (`regions`), without edges.

Parameters
----------
RADIUS, RANGE and DEPTH_RANGE are weights set by hand, once for all scenes, as the method has it:
16 pixels and 16 Luv units are among the bandwidths of Comaniciu and Meer's examples; the depth
has a bandwidth in shares of its deviation, so that it means the same in any unit.

Unclear: the original's weights of the depth confidence, its bandwidths and its unit of depth could
not be read; the paper, too, says only that the method was "implemented following the
description". How the confidence of two pixels combines (here: their product) is our reading.

References
----------
A. Bleiweiss, M. Werman, "Fusing time-of-flight depth and color for real-time segmentation and
tracking", Dynamic 3D Imaging, LNCS 5742, 2009.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.baselines.filtering import shift_filter
from geohue.baselines.planes import depth_of, luv_of
from geohue.baselines.regions import grow_regions
from geohue.baselines.registry import Job
from geohue.compute.parallel import Workers

RADIUS = 16.0
"""h_s, pixels."""

RANGE = 16.0
"""h_r, Luv units."""

DEPTH_RANGE = 0.4
"""h_d, in deviations of the depth."""

MIN_SIZE = 100
"""Pixels; smaller regions join a neighbour."""


def run(job: Job) -> NDArray[np.int32]:
    """Segment an image by colour and depth; the number of segments is found."""
    return segment_image(luv_of(job.scene.colors), depth_of(job.scene), job.team)


def segment_image(
    luv: NDArray[np.float32],
    depth: NDArray[np.float32],
    team: Workers,
    confidence: NDArray[np.float32] | None = None,
    radius: float = RADIUS,
    color_range: float = RANGE,
    depth_range: float = DEPTH_RANGE,
    min_size: int = MIN_SIZE,
) -> NDArray[np.int32]:
    """Filter, connect, join and prune.

    Parameters
    ----------
    luv : (H, W, 3) float32
    depth : (H, W) float32
        NaN where missing.
    team : Workers
    confidence : (H, W) float32, optional
        Of the depth, 0 to 1; by default 1. It is 0 where depth is missing in any case.
    radius, color_range, depth_range : float
        h_s in pixels, h_r in Luv units, h_d in deviations of the depth.
    min_size : int
        Pixels.

    Returns
    -------
    (H, W) int32
        Labels from 0; every pixel has one, with depth or without.
    """
    known = np.isfinite(depth)
    trust = known.astype(np.float32) if confidence is None else np.where(known, confidence, 0.0)
    spread = float(depth[known].std(dtype=np.float64)) if known.any() else 0.0
    unit = spread * depth_range
    relative = np.zeros(depth.shape, np.float32)
    if spread > 1e-6 * float(np.abs(depth[known]).max(initial=0)):
        relative[known] = (depth[known] - depth[known].mean(dtype=np.float64)) / unit
    ones, none = np.ones(depth.shape, np.float32), np.zeros(depth.shape, np.float32)
    values = luv / np.float32(color_range)
    modes = shift_filter(values, relative, trust.astype(np.float32), ones, radius, team)
    return grow_regions(modes, np.ones(depth.shape, bool), none, 1.0, min_size)
