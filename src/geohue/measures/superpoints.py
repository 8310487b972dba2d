"""How good an over-segmentation is: superpixels of a grid, superpoints of a cloud.

What can be made of its segments at best (achievable accuracy), what they leak over true borders
(two errors), the borders they find, how round they are and how alike their points. Every measure
takes time linear in the number of points.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.compute.labels import compact
from geohue.errors import GeohueError
from geohue.measures.boundary import boundary_precision_recall_f
from geohue.measures.contingency import (
    UNLABELLED,
    Contingency,
    Labels,
    as_labels,
    checked_labels,
    contingency_table,
)
from geohue.measures.pairs import (
    Pairs,
    mean_roundness,
    pair_boundary_precision_recall_f,
    pair_compactness,
    segments,
)
from geohue.measures.partition import accuracy_of, leak_of

TOLERANCE = 0.0025
"""Tolerance of borders as a fraction of the image diagonal, usual for superpixels (2 at VGA)."""


def superpoint_scores(
    pred: Labels,
    gt: Labels,
    ignore: int | None = 0,
    *,
    pairs: Pairs | None = None,
    values: NDArray[Any] | None = None,
    tolerance: float | None = None,
    slack: int = 1,
) -> dict[str, float]:
    """Measure an over-segmentation with every measure of this file.

    Parameters
    ----------
    pred : (H, W) or (N,) integer
        Segments; -1 is none.
    gt : (H, W) or (N,) integer
        True labels, of the same shape.
    ignore : int, optional
        Label of the true points that are left out. None leaves out none.
    pairs : ((E,), (E,)) int64, optional
        Pairs of neighbours of a cloud (`geohue.regions.adjacency.adjacent_points`); without them
        nothing is said of borders and of shape. A grid needs none.
    values : (H, W, C) or (N, C) float, optional
        What points of a segment should share: colours, positions.
    tolerance : float, optional
        Of borders on a grid, in pixels. None: 0.0025 of the diagonal, rounded.
    slack : int, optional
        Of borders on a cloud, in steps (`pair_boundary_precision_recall_f`).

    Returns
    -------
    dict of str to float
        n_superpoints; achievable_accuracy, higher is better; undersegmentation_error (Neubert and
        Protzel) and levinshtein_error, lower; boundary_recall, boundary_precision, compactness and
        explained_variation, higher.

    Raises
    ------
    GeohueError
        If the arrays do not fit together.

    Examples
    --------
    >>> import numpy as np
    >>> scores = superpoint_scores(np.array([[5, 6, 6, 7]]), np.array([[1, 1, 2, 2]]))
    >>> scores["achievable_accuracy"], scores["undersegmentation_error"]
    (0.75, 0.5)
    """
    pred, gt = checked_labels(pred, gt)
    table = contingency_table(pred, gt, ignore)
    scores = {
        "n_superpoints": float((table.pred_labels != UNLABELLED).sum()),
        "achievable_accuracy": accuracy_of(table),
        "undersegmentation_error": leak_of(table),
        "levinshtein_error": levinshtein_of(table),
    }
    if gt.ndim == 2 and pairs is None:
        reach = round(TOLERANCE * math.hypot(*gt.shape)) if tolerance is None else tolerance
        borders = boundary_precision_recall_f(pred, gt, ignore, tolerance=reach)
        shape = compactness(pred)
    elif pairs is not None:
        borders = pair_boundary_precision_recall_f(pred, gt, pairs, ignore, slack=slack)
        shape = pair_compactness(pred, pairs)
    if gt.ndim == 2 or pairs is not None:
        scores |= {
            "boundary_recall": borders.recall,
            "boundary_precision": borders.precision,
            "compactness": shape,
        }
    if values is not None:
        scores["explained_variation"] = explained_variation(pred, values)
    return scores


def levinshtein_undersegmentation_error(
    pred: Labels, gt: Labels, ignore: int | None = 0, *, keep_unlabelled: bool = True
) -> float:
    r"""Area that segments touching a true region have beyond it, by its own; lower is better.

    .. math:: UE_L = \frac1G \sum_j \frac{\left(\sum_{i: n_{ij} > 0} n_{i.}\right) - n_{.j}}{n_{.j}}

    A large segment counts in full for one pixel over the border, for each region that it touches.
    `geohue.measures.partition.undersegmentation_error` (Neubert and Protzel's correction) counts
    the smaller side only and is the one to prefer; the other correction in use, the share of pixels
    outside of each segment's best region, is 1 less the achievable accuracy.

    Parameters
    ----------
    pred, gt : (...) integer
        Predicted and true labels, of one shape.
    ignore, keep_unlabelled
        See `geohue.measures.contingency.contingency_table`.

    Returns
    -------
    float
        From 0 (every segment lies in one region); no upper bound.

    Raises
    ------
    GeohueError
        If the labels cannot be compared.

    References
    ----------
    A. Levinshtein, A. Stere, K. Kutulakos, D. Fleet, S. Dickinson, K. Siddiqi, "TurboPixels: fast
    superpixels using geometric flows", PAMI 31, 2009.

    Examples
    --------
    >>> import numpy as np
    >>> levinshtein_undersegmentation_error(np.array([1, 1, 1, 2]), np.array([1, 2, 2, 2]))
    1.1666666666666667
    """
    return levinshtein_of(contingency_table(pred, gt, ignore, keep_unlabelled=keep_unlabelled))


def levinshtein_of(table: Contingency) -> float:
    """`levinshtein_undersegmentation_error` of a table."""
    touching = np.zeros_like(table.gt_sizes)
    np.add.at(touching, table.col, table.pred_sizes[table.row])
    return float(np.mean((touching - table.gt_sizes) / table.gt_sizes))


def compactness(labels: Labels) -> float:
    r"""How round the segments of a grid are; higher is better.

    The isoperimetric quotient, by area. A perimeter is the number of pixel sides between the
    segment and others, the image's edge included:

    .. math:: C = \sum_s \frac{A_s}{A} \frac{4 \pi A_s}{P_s^2}

    Parameters
    ----------
    labels : (H, W) integer
        Segments; pixels with -1 belong to none.

    Returns
    -------
    float
        Above 0; pi / 4 for squares, which pixel sides cannot surpass.

    Raises
    ------
    GeohueError
        If `labels` is not an (H, W) array of integers or holds no segment.

    References
    ----------
    A. Schick, M. Fischer, R. Stiefelhagen, "Measuring and evaluating the compactness of
    superpixels", ICPR 2012.

    Examples
    --------
    >>> import numpy as np
    >>> 4 / np.pi * compactness(np.array([[1, 1, 2, 2], [1, 1, 2, 2]]))
    1.0
    """
    labels = as_labels(labels, "labels")
    if labels.ndim != 2:
        raise GeohueError(
            f"labels have shape {labels.shape}: give an (H, W) label map, or the points of a cloud "
            "with pairs of neighbours to pair_compactness"
        )
    place, sizes = segments(labels.reshape(-1))
    place = place.reshape(labels.shape)
    sides = np.zeros(labels.shape, np.int64)
    for axis in (0, 1):
        step = np.diff(labels, axis=axis) != 0
        first, last = (np.s_[:-1], np.s_[1:]) if axis == 0 else (np.s_[:, :-1], np.s_[:, 1:])
        sides[first] += step
        sides[last] += step
    for edge in (np.s_[0], np.s_[-1], np.s_[:, 0], np.s_[:, -1]):
        sides[edge] += 1
    sides[labels == UNLABELLED] = 0
    perimeters = np.bincount(place.reshape(-1), weights=sides.reshape(-1), minlength=sizes.size)
    return mean_roundness(sizes, perimeters.astype(np.float64))


def explained_variation(labels: Labels, values: NDArray[Any]) -> float:
    r"""Share of the variance of values that segments' means explain; higher is better.

    .. math:: EV = \frac{\sum_s n_s \|\mu_s - \mu\|^2}{\sum_x \|v_x - \mu\|^2}

    Parameters
    ----------
    labels : (...) integer
        Segments; -1 is one segment of its own.
    values : (..., C) or (...) float
        Values of the points: colours, positions, normals. Points with one that is not finite are
        left out.

    Returns
    -------
    float
        From 0 to 1; 1 if all values are equal.

    Raises
    ------
    GeohueError
        If `values` does not fit the labels, or no point has values.

    References
    ----------
    A. Moore, S. Prince, J. Warrell, U. Mohammed, G. Jones, "Superpixel lattices", CVPR 2008.

    Examples
    --------
    >>> import numpy as np
    >>> explained_variation(np.array([1, 1, 2, 2]), np.array([0.0, 2.0, 10.0, 12.0]))
    0.96...
    """
    labels = as_labels(labels, "labels")
    array = np.asarray(values)
    if array.shape[: labels.ndim] != labels.shape:
        raise GeohueError(
            f"values have shape {array.shape}, labels {labels.shape}: give values for each point"
        )
    rows = array.reshape(labels.size, -1).astype(np.float64)
    finite = np.isfinite(rows).all(axis=1)
    if not finite.any():
        raise GeohueError(f"values {array.shape}: no point has finite values only")
    rows = rows[finite] - rows[finite].mean(axis=0)
    _, place = compact(labels.reshape(-1)[finite])
    total = float(np.sum(rows**2))
    if total == 0:
        return 1.0
    sums = np.stack([np.bincount(place, weights=column) for column in rows.T])
    return float(np.sum(sums**2 / np.bincount(place)) / total)
