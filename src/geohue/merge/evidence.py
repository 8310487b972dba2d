"""What the merging goes by: the points of the draft, their neighbours, and the cuts' votes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Positions = NDArray[np.int64]

GAP_CAP = 100.0
"""Gaps beyond so many typical ones are all the same: a border of depth."""

CLOUD_UNIT = 0.92
"""Length unit of a cloud: this times sqrt(n) times the median distance of neighbours."""

CLOUD_STEP = 0.005
"""A cloud's distance of neighbours, in medians, that counts like a relative step of depth."""


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """Points side by side, and what is known of each and of each two neighbours.

    Attributes
    ----------
    lab : (n, 3) float64
        CIELab; zeros where colour takes no part.
    points, normals : (n, 3) float64
        Positions around their mean, and unit normals; zeros where geometry takes no part.
    unit : (n,) float64
        The length that distances are measured in: the depth of a pixel, as the noise of a sensor
        and the size of a pixel grow with it; for a cloud one length for all, which follows from the
        density of the points.
    one, other : (E,) int64
        Pairs of neighbours.
    share : (E,) float64
        Share of the cuts that part them (`count_votes`).
    step : (E,) float64
        Distance of their balanced vectors.
    gap : (E,) float64
        How far they leave each other's tangent plane, in medians of the scene.
    depth_step : (E,) float64
        Relative step of depth, or what is like it in a cloud.
    texture : (n,) int64
        Which of 8 classes the local step of colour falls in, by octaves.
    cuts : sequence of (n,) int32
        Segmentations that vote.
    distant : (F, 2) int64
        Pairs of points of pieces that lie apart, the nearest first: of no evidence, but the last
        levels of the tree join them.
    """

    lab: Floats
    points: Floats
    normals: Floats
    unit: Floats
    one: Positions
    other: Positions
    share: Floats
    step: Floats
    gap: Floats
    depth_step: Floats
    texture: Positions
    cuts: Sequence[NDArray[np.int32]]
    distant: Positions


def gather(
    lab: Floats,
    points: Floats,
    normals: Floats,
    depth: Floats | None,
    one: Positions,
    other: Positions,
    share: Floats,
    step: Floats,
    cuts: Sequence[NDArray[np.int32]],
    distant: Positions,
) -> Evidence:
    """Derive what pairs of neighbours say from the points.

    Parameters
    ----------
    lab, points, normals, one, other, share, step, cuts, distant
        As in `Evidence`; the points need not be centred.
    depth : (n,) float64 or None
        Distance along the axis of the camera, positive; None for a cloud without a camera.

    Returns
    -------
    Evidence
    """
    points = points - points.mean(axis=0)
    away = points[other] - points[one]
    gap = gaps(normals, away, one, other)
    if depth is None:
        length = np.sqrt((away**2).sum(axis=1))
        spacing = float(np.median(length[length > 0])) if (length > 0).any() else 1.0
        unit = np.full(len(points), CLOUD_UNIT * np.sqrt(len(points)) * spacing)
        depth_step = CLOUD_STEP * length / spacing
    else:
        unit = depth
        nearer = np.minimum(depth[one], depth[other])
        depth_step = np.abs(depth[one] - depth[other]) / nearer
        middle = np.median(nearer) if len(nearer) else 1.0
        gap = gap * (middle / nearer) ** 2  # noise grows with the square of depth
    typical = float(np.median(gap)) if len(gap) else 0.0
    gap = np.minimum(gap / typical, GAP_CAP) if typical > 0 else np.where(gap > 0, GAP_CAP, 0.0)
    return Evidence(
        lab,
        points,
        normals,
        unit,
        one,
        other,
        share,
        step,
        gap,
        depth_step,
        _texture(lab, one, other),
        cuts,
        distant,
    )


def gaps(normals: Floats, away: Floats, one: Positions, other: Positions) -> Floats:
    """Return how far neighbours leave each other's tangent plane, ``|d . (n1 + n2)| / 2``."""
    return np.asarray(np.abs((away * (normals[one] + normals[other])).sum(axis=1)) / 2)


def turns(normals: Floats, away: Floats, one: Positions, other: Positions) -> Floats:
    """Return how normals that point away from the camera turn along the way between neighbours.

    ``(n2 - n1) . d / |d|``: positive where the surface is concave, as where one thing stands on
    another, negative along the edge of a box.
    """
    length = np.sqrt((away**2).sum(axis=1))
    turn = ((normals[other] - normals[one]) * away).sum(axis=1)
    rounding = 1e-12 * length.max(initial=0.0)
    return np.asarray(turn / np.maximum(length, rounding or 1.0))


def _texture(lab: Floats, one: Positions, other: Positions) -> Positions:
    """Class of each point's mean step of colour to its neighbours: log2, 8 classes."""
    n = len(lab)
    step = np.sqrt(((lab[one] - lab[other]) ** 2).sum(axis=1))
    total = np.bincount(one, step, n) + np.bincount(other, step, n)
    count = np.bincount(one, minlength=n) + np.bincount(other, minlength=n)
    octave = np.log2(total / np.maximum(count, 1) + 0.5) + 1
    return np.asarray(np.clip(octave, 0, 7), np.int64)
