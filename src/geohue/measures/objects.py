r"""How many true objects a segmentation finds, and how well: each object with one segment.

The measures of the papers on instance segmentation of unseen objects (table tops, OSD and OCID).
Objects g_j are the true regions but the background; c_i are the predicted objects. One c_i and one
g_j make a pair if they share a pixel; the pairs are those of the assignment, one to one, that
maximises the sum of the pairs' F (Hungarian algorithm):

.. math:: F_{ij} = \frac{2\,|c_i \cap g_j|}{|c_i| + |g_j|},\quad
          P = \frac{\sum_i |c_i \cap g(c_i)|}{\sum_i |c_i|},\quad
          R = \frac{\sum_i |c_i \cap g(c_i)|}{\sum_j |g_j|},\quad F = \frac{2 P R}{P + R}

The sums below the lines run over all objects, paired or not: what is missed lowers R, what is
invented or cut off lowers P. `geohue.measures.outlines` does the same with boundaries.

**The background.** Those papers' methods say themselves what is background. A segmentation into
regions does not: its floor is one segment among others. Two ways, `background_from`:

- "truth": a segment with more pixels on the background than on any one object is background.
  So the background is given, and it is measured how well objects are told from it and from each
  other. An object that the background swallows is missed; a piece of the background that is a
  segment by itself costs nothing.
- "prediction": every segment is an object; only pixels without a label (-1) are background. This
  is the papers' protocol, for predictions that leave the background out. A segmentation of all
  pixels scores a low P here.

C. Xie, Y. Xiang, A. Mousavian, D. Fox, "Unseen object instance segmentation for robotic
environments", T-RO 37, 2021; A. Dave, P. Tokmakov, D. Ramanan, "Towards segmenting anything that
moves", ICCV workshops, 2019.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.measures.contingency import UNLABELLED, Contingency, Counts, Labels, contingency_table

BackgroundFrom: TypeAlias = Literal["truth", "prediction"]

DETECTED = 0.75
"""F from which on an object counts as found; public code of the protocol asks for more than it."""

_TIE = 1e-9
"""Of assignments with equal sums of F, the one with the larger overlap is taken: its share of the
pixels is added with this weight, which is less than two sums of F of usual images differ by."""


class ObjectScores(NamedTuple):
    """Agreement of predicted and true objects, each from 0 to 1; higher is better.

    Attributes
    ----------
    precision : float
        Share of the predicted objects' pixels that lie in the paired true object.
    recall : float
        Share of the true objects' pixels that lie in the paired predicted one.
    f : float
        Harmonic mean of both, 0 if both are 0.
    detected : float
        Share of the true objects that are paired with F >= 0.75.
    """

    precision: float
    recall: float
    f: float
    detected: float


@dataclass(frozen=True, slots=True, eq=False)
class Matching:
    """Which predicted object stands for which true one.

    Attributes
    ----------
    table : Contingency
        The overlaps of the P predicted and G true regions.
    is_object, is_true_object : (P,), (G,) bool
        Which of the regions are objects.
    pred, gt : (M,) int64
        Indices of the paired regions in the table.
    overlap : (M,) int64
        Pixels that each pair shares, at least 1.
    """

    table: Contingency
    is_object: NDArray[np.bool_]
    is_true_object: NDArray[np.bool_]
    pred: Counts
    gt: Counts
    overlap: Counts


def object_precision_recall_f(
    pred: Labels,
    gt: Labels,
    background: Collection[int] = (),
    ignore: int | None = 0,
    *,
    background_from: BackgroundFrom = "truth",
) -> ObjectScores:
    """Overlap of predicted and true objects, one to one; see the top of this file.

    Parameters
    ----------
    pred, gt : (...) integer
        Predicted and true labels, of one shape. Predicted pixels with -1 are background.
    background : collection of int, optional
        Labels of the true regions that are no objects: 1, the table, in the frames of mOSD.
    ignore : int, optional
        Label of the true pixels that are left out, unless it is one of `background`. None leaves
        out none.
    background_from : "truth" or "prediction", optional
        Which predicted segments are background.

    Returns
    -------
    ObjectScores
        Precision is 1 if no object is predicted, recall if there is none to find. Without true
        objects, `detected` is 1 if none is predicted, else 0.

    Raises
    ------
    GeohueError
        If the labels cannot be compared, or for another `background_from`.

    Examples
    --------
    >>> import numpy as np
    >>> gt = np.array([1, 1, 1, 1, 2, 2, 3, 3])  # 1 is the table
    >>> pred = np.array([5, 5, 5, 6, 6, 6, 7, 5])
    >>> object_precision_recall_f(pred, gt, background=[1])
    ObjectScores(precision=0.75, recall=0.75, f=0.75, detected=0.5)
    """
    return object_scores_of(match_objects(pred, gt, background, ignore, background_from))


def match_objects(
    pred: Labels,
    gt: Labels,
    background: Collection[int] = (),
    ignore: int | None = 0,
    background_from: BackgroundFrom = "truth",
) -> Matching:
    """Pair predicted with true objects; arguments as for `object_precision_recall_f`.

    Raises
    ------
    GeohueError
        If the labels cannot be compared, or for another `background_from`.
    """
    if background_from not in get_args(BackgroundFrom):
        raise GeohueError(f"background_from {background_from!r}: choose among truth, prediction")
    table = contingency_table(pred, gt, kept(ignore, background))
    is_true_object = ~np.isin(table.gt_labels, list(background))
    is_object = table.pred_labels != UNLABELLED
    if background_from == "truth":
        is_object &= ~_on_background(table, is_true_object)
    pairs = _assign(table, is_object, is_true_object)
    return Matching(table, is_object, is_true_object, *pairs)


def kept(ignore: int | None, background: Collection[int]) -> int | None:
    """Return the label to leave out: what is named as background is compared."""
    return None if ignore in background else ignore


def object_scores_of(matching: Matching) -> ObjectScores:
    """`object_precision_recall_f` of a matching."""
    table = matching.table
    found = int(matching.overlap.sum())
    predicted = int(table.pred_sizes[matching.is_object].sum())
    true = int(table.gt_sizes[matching.is_true_object].sum())
    precision = found / predicted if predicted else 1.0
    recall = found / true if true else 1.0
    return ObjectScores(precision, recall, harmonic(precision, recall), _detected(matching))


def harmonic(precision: float, recall: float) -> float:
    """Harmonic mean, 0 if both are 0.

    Examples
    --------
    >>> harmonic(1.0, 0.5), harmonic(0.0, 0.0)
    (0.6666666666666666, 0.0)
    """
    total = precision + recall
    return 2 * precision * recall / total if total else 0.0


def _detected(matching: Matching) -> float:
    table = matching.table
    count = int(matching.is_true_object.sum())
    if count == 0:
        return 0.0 if matching.is_object.any() else 1.0
    sizes = table.pred_sizes[matching.pred] + table.gt_sizes[matching.gt]
    return int((2 * matching.overlap >= DETECTED * sizes).sum()) / count


def _on_background(table: Contingency, is_true_object: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Predicted regions with more pixels on the background than on any one object, (P,)."""
    on_object = is_true_object[table.col]
    background = np.zeros_like(table.pred_sizes)
    np.add.at(background, table.row[~on_object], table.counts[~on_object])
    best = np.zeros_like(table.pred_sizes)
    np.maximum.at(best, table.row[on_object], table.counts[on_object])
    return np.asarray(background > best)


def _assign(
    table: Contingency, is_object: NDArray[np.bool_], is_true_object: NDArray[np.bool_]
) -> tuple[Counts, Counts, Counts]:
    """Pair objects so that the sum of F is largest: regions of both and their overlaps."""
    from scipy.optimize import linear_sum_assignment

    both = is_object[table.row] & is_true_object[table.col]
    row, col, counts = table.row[both], table.col[both], table.counts[both]
    rows, place_row = np.unique(row, return_inverse=True)
    cols, place_col = np.unique(col, return_inverse=True)
    overlap = np.zeros((rows.size, cols.size), np.int64)
    overlap[place_row, place_col] = counts
    value = np.zeros(overlap.shape)
    value[place_row, place_col] = 2 * counts / (table.pred_sizes[row] + table.gt_sizes[col])
    one, other = linear_sum_assignment(value + _TIE * overlap / table.n_pixels, maximize=True)
    shared = overlap[one, other]
    real = shared > 0
    return rows[one[real]], cols[other[real]], shared[real]
