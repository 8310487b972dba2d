"""EDISON [27]: mean shift in the image plane, held apart by edges (row 5 of Fig. 9).

The mean shift segmentation of Comaniciu and Meer with the synergistic edge weighting of
Christoudias, Georgescu and Meer: a filter in the joint domain of place and value, in which pixels
on edges weigh less (`filtering`, `edges`); then close plateaus join where no edge runs between
them, and small regions join a neighbour (`regions`).

Colour is the system as published: the Luv image. Geometry puts the normalised xyz of eq. 3 in the
place of Luv, with the edges those of the depth. Its range bandwidth is the published one divided
by `SPREAD`, the typical deviation of a Luv channel: as wide against the spread of the geometry as
it is against that of colours.

Parameters
----------
RADIUS, RANGE and MIN_SIZE are EDISON's own defaults (spatial 7, range 6.5, minimum region 20), as
are those of the weighting (gradient window 2, mixture 0.3, edge threshold 0.3).

Unclear: how the paper applied [27] to geometry. Where the articles are silent, this follows what
the published EDISON program does, but for three details of its code: it doubles differences of
bright L (above 80), ranks gradients among the distinct values rather than the pixels, and starts a
region's mode from its first pixel rather than the mean.

References
----------
D. Comaniciu, P. Meer, "Mean shift: a robust approach toward feature space analysis", IEEE Trans.
PAMI 24(5), 2002.
C. Christoudias, B. Georgescu, P. Meer, "Synergism in low level vision", ICPR 2002.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.baselines.edges import edge_strength
from geohue.baselines.filtering import shift_filter
from geohue.baselines.planes import depth_of, filled, luv_of
from geohue.baselines.regions import grow_regions
from geohue.baselines.registry import Job
from geohue.compute.parallel import Workers

RADIUS = 7.0
"""Spatial bandwidth, pixels."""

RANGE = 6.5
"""Range bandwidth, Luv units."""

MIN_SIZE = 20
"""Pixels; smaller regions join a neighbour."""

WINDOW, MIXTURE, EDGE = 2, 0.3, 0.3
"""Gradient window, share of the gradient against the confidence, edge threshold."""

SPREAD = 16.0
"""Mean deviation of the channels of a Luv image: 8-32 in 19 test scenes, 16 on average."""


def run(job: Job) -> NDArray[np.int32]:
    """Segment an image by colour or by geometry; the number of segments is found."""
    mask = np.zeros(job.features.shape, bool)
    mask.reshape(-1)[job.features.index] = True
    if job.features.cues == "color":
        luv = luv_of(job.scene.colors)
        return segment_planes(luv / np.float32(RANGE), luv[..., 0], mask, job.team)
    values = np.zeros((*mask.shape, 3), np.float32)
    values.reshape(-1, 3)[job.features.index] = job.features.geometry
    depth = filled(depth_of(job.scene), mask)
    return segment_planes(values * np.float32(SPREAD / RANGE), depth, mask, job.team)


def segment_planes(
    values: NDArray[np.float32],
    grey: NDArray[np.float32],
    mask: NDArray[np.bool_],
    team: Workers,
    radius: float = RADIUS,
    min_size: int = MIN_SIZE,
) -> NDArray[np.int32]:
    """Filter, connect, join and prune.

    Parameters
    ----------
    values : (H, W, 3) float32
        In units of their bandwidth; finite everywhere.
    grey : (H, W) float32
        Where the edges are found; finite everywhere.
    mask : (H, W) bool
        The pixels that take part.
    team : Workers
    radius : float
        Spatial bandwidth, pixels.
    min_size : int
        Pixels.

    Returns
    -------
    (H, W) int32
        Labels from 0; -1 outside the mask.
    """
    strength = edge_strength(grey, mask, WINDOW, MIXTURE)
    weight = np.where(mask, 1 - strength, 0).astype(np.float32)
    none = np.zeros(mask.shape, np.float32)
    modes = shift_filter(values, none, none, weight, radius, team)
    return grow_regions(modes, mask, strength, EDGE, min_size)
