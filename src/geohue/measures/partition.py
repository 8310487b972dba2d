"""How alike two partitions are, by their regions: information, pairs and overlap.

Each measure is defined on the contingency table ``n_ij``: pixels in predicted region i and true
region j. The marginals are ``n_i.`` and ``n_.j``, their sum is ``n``. See
`contingency_table` for what `ignore` and `keep_unlabelled` leave out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from geohue.errors import GeohueError
from geohue.measures.contingency import Contingency, Counts, Labels, contingency_table


class VariationOfInformation(NamedTuple):
    """Variation of information and its two parts, in one unit.

    Attributes
    ----------
    total : float
        ``over + under``, from 0 (equal partitions) to log(n).
    over : float
        H(pred | gt): what the prediction splits that the truth does not (over-segmentation).
    under : float
        H(gt | pred): what the prediction merges that the truth does not (under-segmentation).
    """

    total: float
    over: float
    under: float


def variation_of_information(
    pred: Labels,
    gt: Labels,
    ignore: int | None = 0,
    *,
    base: float = 2,
    keep_unlabelled: bool = True,
) -> VariationOfInformation:
    r"""Measure the information that two partitions do not share; lower is better.

    .. math:: VoI = H(P|G) + H(G|P),\quad
              H(P|G) = -\sum_{ij} \frac{n_{ij}}{n} \log \frac{n_{ij}}{n_{.j}}

    Parameters
    ----------
    pred, gt : (...) integer
        Predicted and true labels, of one shape.
    ignore, keep_unlabelled
        See `contingency_table`.
    base : float, optional
        Base of the logarithm: 2 for bits, ``math.e`` for nats.

    Returns
    -------
    VariationOfInformation
        Total and parts, from 0 to log(n).

    Raises
    ------
    GeohueError
        If the labels cannot be compared or `base` is not above 1.

    References
    ----------
    M. Meila, "Comparing clusterings: an information based distance", J. Multivariate Analysis
    98, 2007.

    Examples
    --------
    >>> import numpy as np
    >>> variation_of_information(np.array([1, 2, 3, 3]), np.array([1, 1, 2, 2]))
    VariationOfInformation(total=0.5, over=0.5, under=0.0)
    """
    table = contingency_table(pred, gt, ignore, keep_unlabelled=keep_unlabelled)
    return information_of(table, base)


def rand_index(
    pred: Labels, gt: Labels, ignore: int | None = 0, *, keep_unlabelled: bool = True
) -> float:
    r"""Share of the pixel pairs that both partitions join or both separate; higher is better.

    .. math:: RI = 1 - \frac{\tfrac12 (\sum_i n_{i.}^2 + \sum_j n_{.j}^2) - \sum_{ij} n_{ij}^2}
              {n (n-1) / 2}

    Parameters
    ----------
    pred, gt : (...) integer
        Predicted and true labels, of one shape.
    ignore, keep_unlabelled
        See `contingency_table`.

    Returns
    -------
    float
        From 0 to 1; 1 for equal partitions and for a single pixel.

    Raises
    ------
    GeohueError
        If the labels cannot be compared.

    References
    ----------
    W. M. Rand, "Objective criteria for the evaluation of clustering methods", JASA 66, 1971.

    Examples
    --------
    >>> import numpy as np
    >>> round(rand_index(np.array([1, 2, 3, 3]), np.array([1, 1, 2, 2])), 4)
    0.8333
    """
    return rand_of(contingency_table(pred, gt, ignore, keep_unlabelled=keep_unlabelled))


def adjusted_rand_index(
    pred: Labels, gt: Labels, ignore: int | None = 0, *, keep_unlabelled: bool = True
) -> float:
    r"""Rand index corrected for chance; higher is better.

    With :math:`s_{PG}, s_P, s_G` the pairs joined by both, by the prediction and by the truth,
    and s the number of all pairs:

    .. math:: ARI = \frac{s_{PG} - s_P s_G / s}{\tfrac12 (s_P + s_G) - s_P s_G / s}

    Parameters
    ----------
    pred, gt : (...) integer
        Predicted and true labels, of one shape.
    ignore, keep_unlabelled
        See `contingency_table`.

    Returns
    -------
    float
        From -0.5 to 1: 1 for equal partitions, 0 on average for unrelated ones.

    Raises
    ------
    GeohueError
        If the labels cannot be compared.

    References
    ----------
    L. Hubert and P. Arabie, "Comparing partitions", J. Classification 2, 1985.

    Examples
    --------
    >>> import numpy as np
    >>> round(adjusted_rand_index(np.array([1, 2, 3, 3]), np.array([1, 1, 2, 2])), 4)
    0.5714
    """
    return adjusted_rand_of(contingency_table(pred, gt, ignore, keep_unlabelled=keep_unlabelled))


def probabilistic_rand_index(
    pred: Labels,
    truths: Sequence[Labels],
    ignore: int | None = 0,
    *,
    keep_unlabelled: bool = True,
) -> float:
    """Mean Rand index against several people's segmentations; higher is better.

    Equal to weighing each pair of pixels by the share of people who joined it, as long as all of
    them labelled the same pixels.

    Parameters
    ----------
    pred : (...) integer
        Predicted labels.
    truths : sequence of (...) integer
        True labels, one array a person, all of the shape of `pred`.
    ignore, keep_unlabelled
        See `contingency_table`; pixels are left out for each person separately.

    Returns
    -------
    float
        From 0 to 1.

    Raises
    ------
    GeohueError
        If `truths` is empty or the labels cannot be compared.

    References
    ----------
    R. Unnikrishnan, C. Pantofaru, M. Hebert, "Toward objective evaluation of image segmentation
    algorithms", PAMI 29, 2007.

    Examples
    --------
    >>> import numpy as np
    >>> pred = np.array([1, 1, 2])
    >>> round(probabilistic_rand_index(pred, [pred, np.array([1, 2, 3])]), 4)
    0.8333
    """
    if len(truths) == 0:
        raise GeohueError("truths is empty: give at least one array of true labels")
    scores = [rand_index(pred, gt, ignore, keep_unlabelled=keep_unlabelled) for gt in truths]
    return math.fsum(scores) / len(scores)


def segmentation_covering(
    pred: Labels, gt: Labels, ignore: int | None = 0, *, keep_unlabelled: bool = True
) -> float:
    r"""Overlap (IoU) of each true region with its best predicted one, by area; higher is better.

    .. math:: C(P \to G) = \frac1n \sum_j n_{.j} \max_i \frac{n_{ij}}{n_{i.} + n_{.j} - n_{ij}}

    The truth is covered by the prediction, as in the Berkeley benchmark.

    Parameters
    ----------
    pred, gt : (...) integer
        Predicted and true labels, of one shape.
    ignore, keep_unlabelled
        See `contingency_table`; areas count compared pixels only.

    Returns
    -------
    float
        Above 0, up to 1 for equal partitions.

    Raises
    ------
    GeohueError
        If the labels cannot be compared.

    References
    ----------
    P. Arbelaez, M. Maire, C. Fowlkes, J. Malik, "Contour detection and hierarchical image
    segmentation", PAMI 33, 2011, section 3.1.3.

    Examples
    --------
    >>> import numpy as np
    >>> segmentation_covering(np.array([1, 2, 3, 3]), np.array([1, 1, 2, 2]))
    0.75
    """
    return covering_of(contingency_table(pred, gt, ignore, keep_unlabelled=keep_unlabelled))


def undersegmentation_error(
    pred: Labels, gt: Labels, ignore: int | None = 0, *, keep_unlabelled: bool = True
) -> float:
    r"""Area by which predicted regions leak across true borders; lower is better.

    .. math:: UE = \frac1n \sum_{ij} \min(n_{ij},\ n_{i.} - n_{ij})

    Parameters
    ----------
    pred, gt : (...) integer
        Predicted and true labels, of one shape.
    ignore, keep_unlabelled
        See `contingency_table`.

    Returns
    -------
    float
        From 0 (every predicted region lies in one true region) to 1. Lies between 1 - ASA and
        2 (1 - ASA), with ASA the `achievable_segmentation_accuracy`.

    Raises
    ------
    GeohueError
        If the labels cannot be compared.

    References
    ----------
    P. Neubert and P. Protzel, "Superpixel benchmark and comparison", Forum Bildverarbeitung,
    2012.

    Examples
    --------
    >>> import numpy as np
    >>> undersegmentation_error(np.array([1, 1, 1, 1]), np.array([1, 2, 2, 2]))
    0.5
    """
    return leak_of(contingency_table(pred, gt, ignore, keep_unlabelled=keep_unlabelled))


def achievable_segmentation_accuracy(
    pred: Labels, gt: Labels, ignore: int | None = 0, *, keep_unlabelled: bool = True
) -> float:
    r"""Share of pixels right if each predicted region took its best true label.

    .. math:: ASA = \frac1n \sum_i \max_j n_{ij}

    Under-segmentation lowers it; over-segmentation does not, as with every measure made for
    superpixels. With the arguments exchanged (and no ignored pixels) it is the other way round.

    Parameters
    ----------
    pred, gt : (...) integer
        Predicted and true labels, of one shape.
    ignore, keep_unlabelled
        See `contingency_table`.

    Returns
    -------
    float
        Above 0, up to 1; higher is better.

    Raises
    ------
    GeohueError
        If the labels cannot be compared.

    References
    ----------
    M.-Y. Liu, O. Tuzel, S. Ramalingam, R. Chellappa, "Entropy rate superpixel segmentation",
    CVPR 2011.

    Examples
    --------
    >>> import numpy as np
    >>> achievable_segmentation_accuracy(np.array([1, 1, 1, 1]), np.array([1, 2, 2, 2]))
    0.75
    """
    return accuracy_of(contingency_table(pred, gt, ignore, keep_unlabelled=keep_unlabelled))


def information_of(table: Contingency, base: float = 2) -> VariationOfInformation:
    """`variation_of_information` of a table."""
    if not 1 < base < math.inf:
        raise GeohueError(f"base {base}: a logarithm needs a base above 1 (2 for bits, e for nats)")
    unit = table.n_pixels * math.log(base)
    over = np.dot(table.counts, np.log(table.gt_sizes[table.col] / table.counts)) / unit
    under = np.dot(table.counts, np.log(table.pred_sizes[table.row] / table.counts)) / unit
    return VariationOfInformation(float(over + under), float(over), float(under))


def rand_of(table: Contingency) -> float:
    """`rand_index` of a table."""
    both, in_pred, in_gt, pairs = _joined_pairs(table)
    return 1.0 if pairs == 0 else (pairs + 2 * both - in_pred - in_gt) / pairs


def adjusted_rand_of(table: Contingency) -> float:
    """`adjusted_rand_index` of a table."""
    both, in_pred, in_gt, pairs = _joined_pairs(table)
    # Whole numbers: the fraction of the docstring, both sides times 2 s.
    numerator = 2 * (pairs * both - in_pred * in_gt)
    denominator = pairs * (in_pred + in_gt) - 2 * in_pred * in_gt
    # The denominator is 0 only if both join all pairs or both join none: equal partitions.
    return 1.0 if denominator == 0 else numerator / denominator


def covering_of(table: Contingency) -> float:
    """`segmentation_covering` of a table."""
    n_pred, n_gt = table.pred_sizes[table.row], table.gt_sizes[table.col]
    best = np.zeros(table.gt_sizes.size)
    np.maximum.at(best, table.col, table.counts / (n_pred + n_gt - table.counts))
    return float(np.dot(best, table.gt_sizes) / table.n_pixels)


def leak_of(table: Contingency) -> float:
    """`undersegmentation_error` of a table."""
    outside = table.pred_sizes[table.row] - table.counts
    return int(np.minimum(table.counts, outside).sum()) / table.n_pixels


def accuracy_of(table: Contingency) -> float:
    """`achievable_segmentation_accuracy` of a table."""
    best = np.zeros_like(table.pred_sizes)
    np.maximum.at(best, table.row, table.counts)
    return int(best.sum()) / table.n_pixels


def _joined_pairs(table: Contingency) -> tuple[int, int, int, int]:
    """Pairs of pixels joined by both partitions, by pred, by gt, and all pairs."""
    n = table.n_pixels
    both, in_pred, in_gt = map(_pairs, (table.counts, table.pred_sizes, table.gt_sizes))
    return both, in_pred, in_gt, n * (n - 1) // 2


def _pairs(sizes: Counts) -> int:
    """Pairs within groups of the given sizes, exact below 4e9 pixels."""
    return int((sizes * (sizes - 1) // 2).sum())
