"""What is known of regions and of the borders between them: sums that add up when two merge."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geohue.merge.evidence import Evidence
from geohue.merge.smooth import smooth_within

Floats = NDArray[np.float64]

# Columns of a region.
SIZE, LAB, NORMAL, POSITION, SPREAD, TEXTURE = 0, 1, 4, 7, 10, 16
INNER_PAIRS, INNER_STEP, PERIMETER, UNIT = 24, 25, 26, 27
SUMS = 28
"""Columns up to here are sums; those after them follow from them."""
PLANE, RESIDUAL = 28, 31
REGION_COLUMNS = 32

# Columns of a border: all are sums over its pairs of neighbours.
LENGTH, STEP, COLOR_STEP, DEPTH_STEP, CONVEXITY, GAP, MIDPOINT, MIDSPREAD = 0, 1, 2, 3, 4, 5, 6, 9
BORDER_COLUMNS = 15

# What holds for the whole scene.
POINTS, TYPICAL_STEP, CUTS = 0, 1, 2

PRODUCTS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
"""The entries of a symmetric 3x3 matrix, in the order in which they are stored."""


class Table(NamedTuple):
    """Regions 0..R-1 and the borders between them, as compiled loops take them.

    Attributes
    ----------
    region : (R, 32) float64
        Sums over the points of each region.
    votes : (R, V) float64
        How many of its points each segment of each cut has.
    border : (B, 15) float64
        Sums over the pairs of neighbours across each border; zeros for regions that lie apart.
    ends : (B, 2) int64
        The two regions of each border, the lower one first.
    scene : (3,) float64
        Number of points, typical step between neighbours within a region, number of cuts.
    """

    region: Floats
    votes: Floats
    border: Floats
    ends: NDArray[np.int64]
    scene: Floats


def tabulate(evidence: Evidence, labels: NDArray[np.int32]) -> Table:
    """Sum up what is known of each region and of each border.

    Parameters
    ----------
    evidence : Evidence
        Points and pairs of neighbours.
    labels : (n,) int32
        Regions 0..R-1, none of them empty.

    Returns
    -------
    Table
    """
    n_regions = int(labels.max()) + 1
    low, high = labels[evidence.one], labels[evidence.other]
    apart = low != high
    region = _regions(evidence, labels, n_regions, apart)
    ends, border = _with_distant(evidence, labels, *_borders(evidence, labels, n_regions, apart))
    inner = max(float(region[:, INNER_PAIRS].sum()), 1.0)
    scene = np.array(
        [len(labels), region[:, INNER_STEP].sum() / inner, max(len(evidence.cuts), 1)], np.float64
    )
    return Table(region, _votes(evidence, labels, n_regions), border, ends, scene)


def _regions(
    evidence: Evidence, labels: NDArray[np.int32], n: int, apart: NDArray[np.bool_]
) -> Floats:
    table = np.zeros((n, REGION_COLUMNS))

    def put(column: int, values: NDArray[np.floating] | None, at: NDArray[np.int32]) -> None:
        table[:, column] = np.bincount(at, values, n)

    put(SIZE, None, labels)
    for axis in range(3):
        put(LAB + axis, evidence.lab[:, axis], labels)
        put(NORMAL + axis, evidence.normals[:, axis], labels)
        put(POSITION + axis, evidence.points[:, axis], labels)
    for column, (a, b) in enumerate(PRODUCTS):
        put(SPREAD + column, evidence.points[:, a] * evidence.points[:, b], labels)
    texture = np.bincount(labels * np.int64(8) + evidence.texture, minlength=8 * n)
    table[:, TEXTURE : TEXTURE + 8] = texture.reshape(n, 8)
    put(UNIT, evidence.unit, labels)
    inside = labels[evidence.one[~apart]]
    put(INNER_PAIRS, None, inside)
    put(INNER_STEP, evidence.step[~apart], inside)
    for side in (evidence.one, evidence.other):
        table[:, PERIMETER] += np.bincount(labels[side[apart]], minlength=n)
    return table


def _votes(evidence: Evidence, labels: NDArray[np.int32], n: int) -> Floats:
    parts = [np.zeros((n, 0))]
    for cut in evidence.cuts:
        flat = cut.reshape(-1)
        k = int(flat.max()) + 1
        joint = np.bincount(labels * np.int64(k) + flat, minlength=n * k)
        parts.append(joint.reshape(n, k).astype(np.float64))
    return np.ascontiguousarray(np.concatenate(parts, axis=1))


def _borders(
    evidence: Evidence, labels: NDArray[np.int32], n: int, apart: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], Floats]:
    one, other = evidence.one[apart], evidence.other[apart]
    a, b = labels[one].astype(np.int64), labels[other].astype(np.int64)
    keys, place = np.unique(np.minimum(a, b) * n + np.maximum(a, b), return_inverse=True)
    smooth = smooth_within(evidence, ~apart)
    middle = (evidence.points[one] + evidence.points[other]) / 2
    columns = [
        np.ones(len(one)),
        evidence.step[apart],
        *smooth.steps(one, other, evidence.unit),
        *middle.T,
        *(middle[:, i] * middle[:, j] for i, j in PRODUCTS),
    ]
    columns.insert(DEPTH_STEP, evidence.depth_step[apart])
    table = np.stack([np.bincount(place, column, len(keys)) for column in columns], axis=1)
    return np.stack([keys // n, keys % n], axis=1), np.ascontiguousarray(table)


def _with_distant(
    evidence: Evidence, labels: NDArray[np.int32], ends: NDArray[np.int64], border: Floats
) -> tuple[NDArray[np.int64], Floats]:
    """Add borders without a length between regions of pieces that lie apart."""
    pairs = np.sort(labels[evidence.distant].astype(np.int64), axis=1)
    _, first = np.unique(pairs, axis=0, return_index=True)
    pairs = pairs[np.sort(first)]
    n = int(labels.max(initial=0)) + 1
    known = np.isin(pairs[:, 0] * n + pairs[:, 1], ends[:, 0] * n + ends[:, 1])
    pairs = pairs[~known & (pairs[:, 0] != pairs[:, 1])]
    zeros = np.zeros((len(pairs), BORDER_COLUMNS))
    return np.concatenate([ends, pairs]), np.concatenate([border, zeros])
