"""The table of overlaps between two partitions, which every region measure is read from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from geohue.compute.labels import compact
from geohue.errors import GeohueError

Labels: TypeAlias = NDArray[np.integer[Any]]
Counts: TypeAlias = NDArray[np.int64]

UNLABELLED = -1
"""The label of predicted pixels that no segment holds."""


@dataclass(frozen=True, slots=True, eq=False)
class Contingency:
    """Sizes of the overlaps between P predicted and G true regions, zeros left out.

    Attributes
    ----------
    counts : (M,) int64
        Pixels in each non-empty overlap, at least 1, ordered by `row`, then `col`.
    row, col : (M,) int64
        Index of the predicted (0..P-1) and of the true (0..G-1) region of each overlap.
    pred_sizes, gt_sizes : (P,), (G,) int64
        Pixels in each region: the sums of the rows and of the columns.
    pred_labels, gt_labels : (P,), (G,) int64
        The regions' labels, ascending.
    """

    counts: Counts
    row: Counts
    col: Counts
    pred_sizes: Counts
    gt_sizes: Counts
    pred_labels: Counts
    gt_labels: Counts

    @property
    def n_pixels(self) -> int:
        """Number of compared pixels."""
        return int(self.counts.sum())

    def toarray(self) -> Counts:
        """Return the (P, G) int64 table with its zeros."""
        table = np.zeros((self.pred_sizes.size, self.gt_sizes.size), np.int64)
        table[self.row, self.col] = self.counts
        return table


def contingency_table(
    pred: Labels, gt: Labels, ignore: int | None = 0, *, keep_unlabelled: bool = True
) -> Contingency:
    """Count the pixels that each predicted region shares with each true region.

    A region is the set of pixels with one label, connected or not.

    Parameters
    ----------
    pred : (...) integer
        Predicted labels: a label map (H, W) or the labels (N,) of a cloud.
    gt : (...) integer
        True labels, of the same shape.
    ignore : int, optional
        Label of the true pixels that are left out. None leaves out none.
    keep_unlabelled : bool, optional
        Predicted pixels without a label (-1) count as one region of their own: a method that
        labels little is not rewarded. False leaves them out instead.

    Returns
    -------
    Contingency
        The overlaps of the compared pixels.

    Raises
    ------
    GeohueError
        If the shapes differ, labels are not integers, or no pixel is left to compare.

    Examples
    --------
    >>> import numpy as np
    >>> table = contingency_table(np.array([5, 5, 7, -1]), np.array([1, 2, 2, 0]))
    >>> table.toarray()
    array([[1, 1],
           [0, 1]])
    """
    pred, gt = checked_labels(pred, gt)
    keep = np.ones(gt.shape, bool) if ignore is None else gt != ignore
    if not keep_unlabelled:
        keep &= pred != UNLABELLED
    if not keep.any():
        raise GeohueError(
            f"pred {pred.shape} and gt {gt.shape}: no pixel is left to compare "
            f"(ignore={ignore}, keep_unlabelled={keep_unlabelled}); "
            "check the crop and which label means 'none' (ignore=None compares every pixel)"
        )
    pred_labels, row = compact(pred[keep])
    gt_labels, col = compact(gt[keep])
    overlap, key = compact(row * gt_labels.size + col)
    row, col = np.divmod(overlap, gt_labels.size)
    counts = np.bincount(key).astype(np.int64, copy=False)
    return Contingency(
        counts,
        row,
        col,
        _sums(counts, row, pred_labels.size),
        _sums(counts, col, gt_labels.size),
        pred_labels,
        gt_labels,
    )


def checked_labels(pred: Labels, gt: Labels) -> tuple[Labels, Labels]:
    """Return both label arrays, or refuse a pair that cannot be compared.

    Raises
    ------
    GeohueError
        If the shapes differ or labels are not integers.
    """
    pred, gt = as_labels(pred, "pred"), as_labels(gt, "gt")
    if pred.shape != gt.shape:
        raise GeohueError(
            f"pred has shape {pred.shape}, gt has shape {gt.shape}: both must be the same; "
            "crop the larger, or resize with nearest neighbour"
        )
    return pred, gt


def as_labels(labels: Labels, name: str) -> Labels:
    """Return `labels` as an integer array (a mask has the labels 0 and 1).

    Raises
    ------
    GeohueError
        If labels are not integers.
    """
    array = np.asarray(labels)
    if array.dtype == np.bool_:
        return array.astype(np.int64)
    if not np.issubdtype(array.dtype, np.integer):
        raise GeohueError(
            f"{name} has shape {array.shape} and type {array.dtype}: labels must be integers; "
            "convert with .astype(int) (first replace NaN by the label that means 'none')"
        )
    return array


def _sums(counts: Counts, index: Counts, size: int) -> Counts:
    """Sum `counts` by `index`, exact in int64."""
    sums = np.zeros(size, np.int64)
    np.add.at(sums, index, counts)
    return sums
