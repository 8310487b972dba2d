"""What speaks for and against merging two regions: one function each.

All are functions of the table: the sums of two regions, ``i`` and ``j``, and of the border ``e``
between them. Lengths are divided by the smaller unit of the two, so that neither the scale of the
scene nor a sensor's noise, which grows with depth, changes what they say. Logarithms make a factor
count the same wherever it stands, and a constant inside them is the size below which nothing is to
be seen.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from geohue.compute.compiled import compiled_part
from geohue.merge import table as t
from geohue.merge.eigen import covariance, eigenvalue, eigenvector
from geohue.merge.table import Table

NOISE = 0.004
"""Distance, relative to depth, that the noise of a sensor reaches: 4 mm at one metre."""

SAME_PLACE = 1e-6
"""Distance, in units, below which two places are one: their direction would be rounding."""

PRIOR = 20.0
"""Typical pairs that are added to those within a region, lest a few speak for it."""

Floats = NDArray[np.float64]

NAMES = (
    "offset",
    "color_step",
    "depth_step",
    "texture",
    "convexity",
    "one_plane",
    "whole_votes",
    "length",
    "gap",
    "contrast",
    "straightness",
    "perimeter",
    "smaller",
    "larger",
    "region_convexity",
)
"""The cues, in the order of the columns that `measure` writes."""


@compiled_part
def measure(table: Table, i: int, j: int, e: int, out: Floats, scratch: Floats) -> None:
    """Write all cues of a border into `out`; `scratch` has room for 6 numbers."""
    region, border = table.region, table.border
    unit = min(region[i, t.UNIT] / region[i, t.SIZE], region[j, t.UNIT] / region[j, t.SIZE])
    out[0] = offset(region, i, j, unit)
    out[1] = math.log(border[e, t.COLOR_STEP] / border[e, t.LENGTH] + 0.5)
    out[2] = math.log(border[e, t.DEPTH_STEP] / border[e, t.LENGTH] / NOISE + 0.5)
    out[3] = texture(region, i, j)
    out[4] = border[e, t.CONVEXITY] / border[e, t.LENGTH]
    out[5] = one_plane(region, i, j, unit, scratch)
    out[6] = whole_votes(table, i, j)
    out[7] = border[e, t.LENGTH] / math.sqrt(min(region[i, t.SIZE], region[j, t.SIZE]))
    out[8] = math.log(border[e, t.GAP] / border[e, t.LENGTH] / NOISE + 0.5)
    out[9] = contrast(table, i, j, e)
    out[10] = straightness(border, e, unit, scratch)
    out[11] = border[e, t.LENGTH] / max(min(region[i, t.PERIMETER], region[j, t.PERIMETER]), 1.0)
    out[12] = math.log(min(region[i, t.SIZE], region[j, t.SIZE]) / table.scene[t.POINTS])
    out[13] = math.log(max(region[i, t.SIZE], region[j, t.SIZE]) / table.scene[t.POINTS])
    out[14] = region_convexity(region, i, j, unit)


@compiled_part
def offset(region: Floats, i: int, j: int, unit: float) -> float:
    """How far one region's centroid is off the other's plane.

    Two planes that are parallel at a distance fit no common surface, however alike they look.
    """
    to_i, to_j = 0.0, 0.0
    for axis in range(3):
        way = (
            region[i, t.POSITION + axis] / region[i, t.SIZE]
            - region[j, t.POSITION + axis] / region[j, t.SIZE]
        )
        to_i += way * region[i, t.PLANE + axis]
        to_j += way * region[j, t.PLANE + axis]
    return math.log(max(abs(to_i), abs(to_j)) / unit / NOISE + 0.5)


@compiled_part
def texture(region: Floats, i: int, j: int) -> float:
    """Half the chi-squared distance of the two histograms of local steps of colour.

    A pattern and a plain surface of the same mean colour are two things.
    """
    total = 0.0
    for k in range(t.TEXTURE, t.TEXTURE + 8):
        a, b = region[i, k] / region[i, t.SIZE], region[j, k] / region[j, t.SIZE]
        total += (a - b) * (a - b) / (a + b + 1e-9)
    return float(total / 2)


@compiled_part
def one_plane(region: Floats, i: int, j: int, unit: float, scratch: Floats) -> float:
    """How much worse one plane fits both regions than a plane for each.

    Logarithm of the joint root mean square distance over that of two planes.
    """
    n, m = region[i, t.SIZE], region[j, t.SIZE]
    both = n + m
    for k in range(6):
        scratch[k] = (region[i, t.SPREAD + k] + region[j, t.SPREAD + k]) / both
    x = (region[i, t.POSITION] + region[j, t.POSITION]) / both
    y = (region[i, t.POSITION + 1] + region[j, t.POSITION + 1]) / both
    z = (region[i, t.POSITION + 2] + region[j, t.POSITION + 2]) / both
    scratch[0] -= x * x
    scratch[1] -= x * y
    scratch[2] -= x * z
    scratch[3] -= y * y
    scratch[4] -= y * z
    scratch[5] -= z * z
    joint = math.sqrt(max(eigenvalue(scratch, 0), 0.0)) / unit
    apart = math.sqrt((n * region[i, t.RESIDUAL] + m * region[j, t.RESIDUAL]) / both) / unit
    return math.log(joint / (apart + NOISE / 2) + 0.1)


@compiled_part
def whole_votes(table: Table, i: int, j: int) -> float:
    """Share of the cuts that part a point of one region from a point of the other.

    Over all such pairs of points, not only those along the border: cuts that disagree about where
    exactly the border runs still agree that these are two things.
    """
    same = 0.0
    for k in range(table.votes.shape[1]):
        same += table.votes[i, k] * table.votes[j, k]
    if table.votes.shape[1] == 0:
        return 0.0
    pairs = table.region[i, t.SIZE] * table.region[j, t.SIZE] * table.scene[t.CUTS]
    return float(1.0 - same / pairs)


@compiled_part
def contrast(table: Table, i: int, j: int, e: int) -> float:
    """How much more changes across the border than within the calmer of the two regions."""
    typical = table.scene[t.TYPICAL_STEP]
    calm = min(calmness(table.region, i, typical), calmness(table.region, j, typical))
    step = table.border[e, t.STEP] / table.border[e, t.LENGTH]
    return math.log(step / max(calm, 1e-6) + 0.05)


@compiled_part
def calmness(region: Floats, i: int, typical: float) -> float:
    """The mean step between neighbours within a region."""
    pairs = region[i, t.INNER_PAIRS] + PRIOR
    return float((region[i, t.INNER_STEP] + PRIOR * typical) / pairs)


@compiled_part
def straightness(border: Floats, e: int, unit: float, scratch: Floats) -> float:
    """How far the border bends: spread across its run over spread along it.

    Things end in straight lines and smooth curves; what noise and shadow part is ragged.
    """
    length = border[e, t.LENGTH]
    if length < 3:
        return 0.3
    covariance(border, e, t.MIDPOINT, t.MIDSPREAD, length, scratch)
    across, along = eigenvalue(scratch, 1), eigenvalue(scratch, 2)
    if along <= (SAME_PLACE * unit) ** 2:
        return 0.3
    return math.sqrt(max(across, 0.0) / along)


@compiled_part
def region_convexity(region: Floats, i: int, j: int, unit: float) -> float:
    """How the mean normals of the two regions turn along the way between their centroids."""
    length_i, length_j, dist, turn = 0.0, 0.0, 0.0, 0.0
    for axis in range(3):
        length_i += region[i, t.NORMAL + axis] ** 2
        length_j += region[j, t.NORMAL + axis] ** 2
    length_i, length_j = math.sqrt(length_i) + 1e-9, math.sqrt(length_j) + 1e-9
    for axis in range(3):
        way = (
            region[i, t.POSITION + axis] / region[i, t.SIZE]
            - region[j, t.POSITION + axis] / region[j, t.SIZE]
        )
        dist += way * way
        turn += (
            region[i, t.NORMAL + axis] / length_i - region[j, t.NORMAL + axis] / length_j
        ) * way
    dist = math.sqrt(dist)
    return turn / dist if dist > SAME_PLACE * unit else 0.0


@compiled_part
def fit_plane(region: Floats, i: int, scratch: Floats) -> None:
    """Write the normal of a region's plane and the mean squared distance of its points from it."""
    region[i, t.RESIDUAL] = 0.0
    for axis in range(3):
        region[i, t.PLANE + axis] = 0.0
    if region[i, t.SIZE] < 3:
        return
    covariance(region, i, t.POSITION, t.SPREAD, region[i, t.SIZE], scratch)
    least = eigenvalue(scratch, 0)
    eigenvector(scratch, least, region, i, t.PLANE)
    region[i, t.RESIDUAL] = max(least, 0.0)
