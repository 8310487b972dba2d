"""How far the segmentations of the two views agree."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.compute.labels import check_labels
from geohue.stereo.warping import check_pair, find_occlusions


@dataclass(frozen=True, slots=True, eq=False)
class ViewAgreement:
    """How far the labels of the two views agree at corresponding pixels.

    Attributes
    ----------
    share : float or None
        Share of the compared pixels whose labels are partners, 0 to 1; None if none compare.
    partner : (K_left,) int32
        The label of the right view that goes with each of the left, -1 = none. No two share one.
    compared : int
        Pixels that have a label in both views and are seen by both.
    """

    share: float | None
    partner: NDArray[np.int32]
    compared: int


def view_agreement(
    left_labels: NDArray[np.integer[Any]],
    right_labels: NDArray[np.integer[Any]],
    disparity: NDArray[np.floating[Any]],
) -> ViewAgreement:
    """Compare the labels of the two views through the disparity.

    Each view is cut on its own and numbers its segments as it likes. So the labels are first
    paired one to one such that as many corresponding pixels as possible agree.

    Parameters
    ----------
    left_labels, right_labels : (H, W) integer
        Labels, -1 = none.
    disparity : (H, W) float
        Of the left image; NaN where missing. Occluded pixels (`find_occlusions`) are left out.

    Returns
    -------
    ViewAgreement

    Raises
    ------
    GeohueError
        If the sizes differ or the labels are not whole numbers from -1.

    Examples
    --------
    >>> view = view_agreement(np.array([[0, 0, 1]]), np.array([[5, 2, 2]]), np.zeros((1, 3)))
    >>> round(view.share, 3), view.partner.tolist()
    (0.667, [5, 2])
    """
    left, right = check_labels(left_labels, ndim=2), check_labels(right_labels, ndim=2)
    check_pair(left, right, disparity)
    width = left.shape[1]
    known = np.isfinite(disparity)
    x = np.rint(np.arange(width) - np.where(known, disparity, 0.0))
    known &= (x >= 0) & (x <= width - 1) & ~find_occlusions(disparity)
    there = np.take_along_axis(right, np.clip(x, 0, width - 1).astype(np.int64), axis=1)
    both = known & (left >= 0) & (there >= 0)
    partner = np.full(int(left.max(initial=-1)) + 1, -1, np.int32)
    if not both.any():
        return ViewAgreement(None, partner, 0)
    table = _overlaps(left[both], there[both])
    from scipy.optimize import linear_sum_assignment  # a tenth of a second to import

    rows, columns = linear_sum_assignment(table, maximize=True)
    used = table[rows, columns] > 0
    partner[rows[used]] = columns[used]
    compared = int(both.sum())
    return ViewAgreement(float(table[rows, columns].sum()) / compared, partner, compared)


def _overlaps(left: NDArray[np.int32], right: NDArray[np.int32]) -> NDArray[np.int64]:
    """Count the pixels of each pair of labels."""
    span = int(right.max()) + 1
    counts = np.bincount(left.astype(np.int64) * span + right)
    table = np.zeros((int(left.max()) + 1) * span, np.int64)
    table[: counts.size] = counts
    return table.reshape(-1, span)
