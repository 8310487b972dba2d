r"""How well the outlines of predicted objects follow those of the true ones.

The boundary measures of the papers in `geohue.measures.objects`, with its pairs and its background.
The outline D(s) of an object is one pixel wide: its pixels and those beside it whose right, lower
or lower right neighbour lies on the other side. Within a slack of r pixels (a disc):

.. math:: P = \frac{\sum_i |\{p \in D(c_i): |p - D(g(c_i))| \le r\}|}{\sum_i |D(c_i)|},\quad
          R = \frac{\sum_i |\{q \in D(g(c_i)): |q - D(c_i)| \le r\}|}{\sum_j |D(g_j)|}

Only the outline of the paired object counts as found: unlike boundary F, a line between two objects
is of no use to an object that is paired with neither.

**Ignored pixels** follow the two rules at the top of `geohue.measures.boundary` with r as reach:
narrow gaps are closed, and the border of what stays ignored is no outline; a predicted outline
there that matches nothing is left out. With nothing ignored, this is the papers' measure.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from geohue.errors import GeohueError
from geohue.measures.boundary import BoundaryScores, Mask
from geohue.measures.contingency import Counts, Labels, checked_labels
from geohue.measures.objects import BackgroundFrom, Matching, harmonic, kept, match_objects

SLACK = 0.003
"""Default slack as a fraction of the image diagonal, rounded up to whole pixels."""

_STEPS = ((0, 1), (1, 0), (1, 1))
"""From a pixel to the neighbours that decide whether it lies on an outline."""


class _Outlines(NamedTuple):
    """The pixels of all objects' outlines, object by object.

    Attributes
    ----------
    start : (n + 1,) int64
        Object i has the pixels `start[i]` up to `start[i + 1]`.
    pixel : (m,) int64
        Flat positions, ascending for each object.
    """

    start: Counts
    pixel: Counts

    def of(self, index: int) -> Counts:
        """Flat positions of one object's outline."""
        return self.pixel[self.start[index] : self.start[index + 1]]


def object_boundary_precision_recall_f(
    pred: Labels,
    gt: Labels,
    background: Collection[int] = (),
    ignore: int | None = 0,
    *,
    background_from: BackgroundFrom = "truth",
    slack: float | None = None,
) -> BoundaryScores:
    """Agreement of the outlines of paired objects; see the top of this file.

    Parameters
    ----------
    pred, gt : (H, W) integer
        Predicted and true labels. Predicted pixels with -1 are background.
    background, ignore, background_from
        See `geohue.measures.objects.object_precision_recall_f`.
    slack : float, optional
        Largest distance of a match in pixels, 0 or more. None: 0.003 of the image diagonal, rounded
        up, 3 at VGA.

    Returns
    -------
    BoundaryScores
        Precision is 1 if no outline is predicted, recall if there is none to find.

    Raises
    ------
    GeohueError
        If the maps cannot be compared, or `slack` is negative or not finite.

    Examples
    --------
    >>> import numpy as np
    >>> gt = np.array([[1, 1, 1, 2, 2, 2, 2, 1, 1]])  # 1 is the table
    >>> pred = np.array([[5, 5, 5, 5, 5, 6, 6, 5, 5]])
    >>> object_boundary_precision_recall_f(pred, gt, background=[1], slack=1)
    BoundaryScores(precision=0.5, recall=0.5, f=0.5)
    """
    matching = match_objects(pred, gt, background, ignore, background_from)
    return outline_scores_of(matching, pred, gt, kept(ignore, background), slack)


def outline_scores_of(
    matching: Matching, pred: Labels, gt: Labels, ignore: int | None, slack: float | None = None
) -> BoundaryScores:
    """`object_boundary_precision_recall_f` of a matching of two label maps.

    Raises
    ------
    GeohueError
        If the labels are not maps, or `slack` is negative or not finite.
    """
    pred, gt = checked_labels(pred, gt)
    if gt.ndim != 2:
        raise GeohueError(f"pred and gt have shape {gt.shape}: outlines need (H, W) label maps")
    reach = math.ceil(SLACK * math.hypot(*gt.shape)) if slack is None else float(slack)
    if not 0 <= reach < math.inf:
        raise GeohueError(f"slack {slack}: give a distance in pixels, 0 or more")
    closed, known, near = _known(gt, ignore, reach)
    table = matching.table
    in_pred = _outlines(
        _places(pred, table.pred_labels, matching.is_object), known, table.pred_sizes.size
    )
    in_gt = _outlines(
        _places(closed, table.gt_labels, matching.is_true_object), known, table.gt_sizes.size
    )
    partner = np.full(table.pred_sizes.size, -1)
    partner[matching.pred] = matching.gt
    hits = compared = found = 0
    for i in np.flatnonzero(matching.is_object).tolist():
        mine = in_pred.of(i)
        theirs = in_gt.of(partner[i]) if partner[i] >= 0 else mine[:0]
        matched = _within(mine, theirs, reach, gt.shape)
        hits += int(matched.sum())
        compared += int((matched | ~near[mine]).sum())
        found += int(_within(theirs, mine, reach, gt.shape).sum())
    precision = hits / compared if compared else 1.0
    recall = found / in_gt.pixel.size if in_gt.pixel.size else 1.0
    return BoundaryScores(precision, recall, harmonic(precision, recall))


def _known(gt: Labels, ignore: int | None, reach: float) -> tuple[Labels, Mask, Mask]:
    """The truth with narrow gaps closed, its labelled pixels, and those near a gap (flat)."""
    if ignore is None or not (gt == ignore).any():
        return gt, np.ones(gt.shape, bool), np.zeros(gt.size, bool)
    labelled = gt != ignore
    distance, nearest = ndimage.distance_transform_edt(~labelled, return_indices=True)
    closed = np.where(distance <= reach, gt[tuple(nearest)], gt)
    # An outline lies up to one diagonal step before its border, which may be that of the gap.
    near = ndimage.distance_transform_edt(labelled) <= max(reach, math.sqrt(2))
    return closed, closed != ignore, np.asarray(near).reshape(-1)


def _places(labels: Labels, names: Counts, wanted: NDArray[np.bool_]) -> Counts:
    """Index of each pixel's label among `names`, -1 for others and for what is not wanted."""
    place = np.minimum(np.searchsorted(names, labels), names.size - 1)
    return np.where((names[place] == labels) & wanted[place], place, -1)


def _outlines(places: Counts, known: Mask, count: int) -> _Outlines:
    """Collect the outlines of all objects; between pixels that are both known."""
    height, width = places.shape
    flat = np.arange(places.size).reshape(places.shape)
    keys = [np.zeros(0, np.int64)]
    for down, right in _STEPS:
        here = np.s_[: height - down, : width - right]
        there = np.s_[down:, right:]
        border = (places[here] != places[there]) & known[here] & known[there]
        for side in (here, there):  # the pixel lies on the outlines of both sides
            place, pixel = places[side][border], flat[here][border]
            keys.append((place * places.size + pixel)[place >= 0])
    place, pixel = np.divmod(np.unique(np.concatenate(keys)), places.size)
    return _Outlines(np.searchsorted(place, np.arange(count + 1)), pixel)


def _within(these: Counts, those: Counts, reach: float, shape: tuple[int, ...]) -> Mask:
    """Which of these pixels lie within reach of one of those."""
    from scipy.spatial import cKDTree

    if these.size == 0 or those.size == 0:
        return np.zeros(these.size, bool)
    width = shape[1]
    tree = cKDTree(np.stack(np.divmod(those, width), axis=1))
    distance, _ = tree.query(np.stack(np.divmod(these, width), axis=1))
    return np.asarray(distance <= reach)
