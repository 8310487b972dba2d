"""Borders of segments of a cloud, which has no pixels: pairs of neighbours with two labels.

The pairs come from outside, so that all methods are measured on the same ones: those of
`geohue.regions.adjacency.adjacent_points`, say. A pair that is given twice counts twice.
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from geohue.compute.labels import compact
from geohue.errors import GeohueError
from geohue.measures.boundary import BoundaryScores, Mask
from geohue.measures.contingency import (
    UNLABELLED,
    Counts,
    Labels,
    as_labels,
    checked_labels,
)
from geohue.measures.objects import harmonic

Pairs: TypeAlias = tuple[NDArray[np.int64], NDArray[np.int64]]


def pair_boundary_precision_recall_f(
    pred: Labels, gt: Labels, pairs: Pairs, ignore: int | None = 0, *, slack: int = 0
) -> BoundaryScores:
    """Share of each border's pairs that the other border has, too; higher is better.

    A border is the set of the pairs whose ends have different labels.

    Parameters
    ----------
    pred, gt : (N,) integer
        Predicted and true labels. A prediction's -1 is a region like any other.
    pairs : ((E,), (E,)) int64
        Positions of the two ends of each pair of neighbours.
    ignore : int, optional
        Pairs with an end of this true label are left out. None leaves out none.
    slack : int, optional
        0: the same pair must be on both borders. 1: an end that both borders share is enough. s:
        from an end of the one, it may take s - 1 steps along pairs to an end of the other.

    Returns
    -------
    BoundaryScores
        Precision, 1 if nothing is predicted; recall, 1 if nothing is there to find; F.

    Raises
    ------
    GeohueError
        If the labels cannot be compared, the pairs do not fit them, or `slack` is negative.

    Examples
    --------
    >>> import numpy as np
    >>> chain = np.arange(5), np.arange(1, 6)
    >>> gt, pred = np.array([1, 1, 1, 2, 2, 2]), np.array([5, 5, 6, 6, 6, 7])
    >>> pair_boundary_precision_recall_f(pred, gt, chain)
    BoundaryScores(precision=0.0, recall=0.0, f=0.0)
    >>> pair_boundary_precision_recall_f(pred, gt, chain, slack=1)
    BoundaryScores(precision=0.5, recall=1.0, f=0.66...)
    """
    pred, gt = checked_labels(pred, gt)
    if slack < 0:
        raise GeohueError(f"slack {slack}: give a number of steps, 0 or more")
    pred, gt = pred.reshape(-1), gt.reshape(-1)
    one, other = _checked(pairs, gt.size)
    if ignore is not None:
        both = (gt[one] != ignore) & (gt[other] != ignore)
        one, other = one[both], other[both]
    in_pred, in_gt = pred[one] != pred[other], gt[one] != gt[other]
    precision = _found(in_pred, in_gt, (one, other), gt.size, slack)
    recall = _found(in_gt, in_pred, (one, other), gt.size, slack)
    return BoundaryScores(precision, recall, harmonic(precision, recall))


def pair_compactness(labels: Labels, pairs: Pairs) -> float:
    r"""How round segments are on a graph of neighbours; higher is better.

    The isoperimetric quotient of `geohue.measures.superpoints.compactness` with points for the area
    and pairs that leave the segment for its perimeter. A graph of more pairs than a grid has (its
    mean degree d is 4) cuts more for the same border, so they count 4/d each:

    .. math:: C = \sum_s \frac{n_s}{n} \min\left(1, \frac{4 \pi n_s}{P_s^2}\right),\quad
              P_s = \frac4d\, |\{(a, b): a \in s, b \notin s\}|

    It has no unit and does not depend on the density of the points. Where the cloud ends nothing
    is cut, so that a piece by itself is as round as can be. It is for comparing segmentations of
    one cloud with the same pairs, not for comparing clouds with images.

    Parameters
    ----------
    labels : (N,) integer
        Segments; points with -1 belong to none.
    pairs : ((E,), (E,)) int64
        Positions of the two ends of each pair of neighbours.

    Returns
    -------
    float
        From 0 to 1; 1 if no pair is cut.

    Raises
    ------
    GeohueError
        If labels are not integers, no point has one, or the pairs do not fit them.

    Examples
    --------
    >>> import numpy as np
    >>> chain = np.arange(5), np.arange(1, 6)
    >>> round(pair_compactness(np.array([1, 1, 1, 2, 2, 2]), chain), 3)
    1.0
    """
    flat = as_labels(labels, "labels").reshape(-1)
    one, other = _checked(pairs, flat.size)
    place, sizes = segments(flat)
    cut = flat[one] != flat[other]
    ends = np.concatenate([one[cut], other[cut]])
    cuts = np.bincount(place[ends][flat[ends] != UNLABELLED], minlength=sizes.size)
    connected = np.zeros(flat.size, bool)
    connected[one] = connected[other] = True
    degree = 2 * one.size / max(1, int(connected.sum()))
    return mean_roundness(sizes, cuts * 4 / degree if degree else cuts.astype(float))


def segments(flat: Labels) -> tuple[Counts, Counts]:
    """Return the index of each point's segment, and the sizes of the S segments.

    Points with -1 have no segment and any index.

    Raises
    ------
    GeohueError
        If no point has a label.
    """
    held = flat != UNLABELLED
    if not held.any():
        raise GeohueError(f"labels {flat.shape}: no point has a label, all are {UNLABELLED}")
    place = np.zeros(flat.shape, np.int64)
    _, place[held] = compact(flat[held])
    return place, np.bincount(place[held])


def mean_roundness(sizes: Counts, perimeters: NDArray[np.float64]) -> float:
    """Mean isoperimetric quotient of segments, by size, none above 1."""
    quotient = 4 * math.pi * sizes / np.maximum(perimeters, 1e-9) ** 2
    return float(np.dot(sizes, np.minimum(quotient, 1)) / sizes.sum())


def _found(these: Mask, those: Mask, pairs: Pairs, size: int, slack: int) -> float:
    """Share of these border pairs that lie within `slack` of those."""
    if not these.any():
        return 1.0
    if slack == 0:
        return float(those[these].mean())
    one, other = pairs
    near = np.zeros(size, bool)
    near[one[those]] = near[other[those]] = True
    for _ in range(slack - 1):
        grown = near.copy()
        grown[one[near[other]]] = grown[other[near[one]]] = True
        near = grown
    return float((near[one] | near[other])[these].mean())


def _checked(pairs: Pairs, size: int) -> Pairs:
    one, other = (np.asarray(side) for side in pairs)
    if one.ndim != 1 or one.shape != other.shape:
        raise GeohueError(
            f"pairs of shapes {one.shape} and {other.shape}: give the positions of both ends, (E,)"
        )
    for side in (one, other):
        if not np.issubdtype(side.dtype, np.integer):
            raise GeohueError(f"pairs of type {side.dtype}: positions are whole numbers")
        if side.size and not 0 <= side.min() <= side.max() < size:
            raise GeohueError(
                f"pairs from {side.min()} to {side.max()}: positions go from 0 to {size - 1}"
            )
    return one, other
