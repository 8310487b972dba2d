"""How alike two partitions are, by the borders between their regions.

**Ignored pixels.** Two rules, both with the tolerance r of the match:

1. Annotators leave thin unlabelled gaps between objects. An ignored pixel within r of a labelled
   one takes the nearest label, so a gap of up to 2 r closes, and two labels that meet in it make
   a true boundary on its middle line. Any line in the gap is within r of that.
2. The border of what stays ignored is not the border of an object: it is no true boundary and
   need not be found. A predicted boundary pixel on an ignored pixel or within r of one is left
   out, unless it matches a true boundary: the prediction is neither rewarded nor punished where
   nobody drew.
"""

from __future__ import annotations

import math
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from geohue.errors import GeohueError
from geohue.measures.contingency import Labels, as_labels, checked_labels

Mask: TypeAlias = NDArray[np.bool_]
Floats: TypeAlias = NDArray[np.float64]

TOLERANCE = 0.0075
"""Default tolerance as a fraction of the image diagonal (the Berkeley benchmark's ``maxDist``)."""


class BoundaryScores(NamedTuple):
    """Agreement of two boundary maps, each from 0 to 1; higher is better.

    Attributes
    ----------
    precision : float
        Share of the predicted boundary that lies near a true one.
    recall : float
        Share of the true boundary that lies near a predicted one.
    f : float
        Harmonic mean of both, 0 if both are 0.
    """

    precision: float
    recall: float
    f: float


class BoundaryDistances(NamedTuple):
    """Distances in pixels from each boundary pixel to the nearest one of the other map.

    Attributes
    ----------
    pred_to_gt : (P,) float64
        From the predicted boundary, less what the ignored pixels excuse.
    gt_to_pred : (G,) float64
        From the true boundary. Where the other map has no boundary: the image diagonal.
    tolerance : float
        The tolerance in pixels, its default resolved.
    """

    pred_to_gt: Floats
    gt_to_pred: Floats
    tolerance: float


def boundary_map(labels: Labels, ignore: int | None = None) -> Mask:
    """Mark the pixels whose right or lower neighbour has another label.

    The line is one pixel wide and lies on the upper left side of each border.

    Parameters
    ----------
    labels : (H, W) integer
        Label map.
    ignore : int, optional
        Borders of the pixels with this label are not marked. None: all borders are.

    Returns
    -------
    (H, W) bool
        True on the boundary.

    Raises
    ------
    GeohueError
        If `labels` is not an (H, W) array of integers.

    Examples
    --------
    >>> import numpy as np
    >>> boundary_map(np.array([[1, 1, 2], [1, 1, 2]])).astype(int)
    array([[0, 1, 0],
           [0, 1, 0]])
    """
    labels = as_labels(labels, "labels")
    _check_grid(labels, "labels")
    edge = np.zeros(labels.shape, bool)
    known = np.ones(labels.shape, bool) if ignore is None else labels != ignore
    edge[:, :-1] |= (labels[:, :-1] != labels[:, 1:]) & known[:, :-1] & known[:, 1:]
    edge[:-1] |= (labels[:-1] != labels[1:]) & known[:-1] & known[1:]
    return edge


def boundary_precision_recall_f(
    pred: Labels, gt: Labels, ignore: int | None = 0, *, tolerance: float | None = None
) -> BoundaryScores:
    """Share of each boundary that lies within a tolerance of the other; higher is better.

    A pixel matches if *any* pixel of the other boundary is near (a distance transform). The
    Berkeley benchmark instead matches pixels one to one (a bipartite assignment), so several
    lines beside one true line are punished there and not here: these figures are at least as
    high as the benchmark's and are not to be mixed with them.

    Parameters
    ----------
    pred, gt : (H, W) integer
        Predicted and true label maps. A prediction's -1 is a region like any other.
    ignore : int, optional
        Label of the true pixels that nobody labelled; the top of this file says what they
        excuse. None: every pixel counts.
    tolerance : float, optional
        Largest distance of a match in pixels, 0 or more. None: 0.0075 of the image diagonal.

    Returns
    -------
    BoundaryScores
        Precision, 1 if nothing is predicted; recall, 1 if nothing is there to find; F.

    Raises
    ------
    GeohueError
        If the maps cannot be compared or `tolerance` is negative or not finite.

    References
    ----------
    D. Martin, C. Fowlkes, J. Malik, "Learning to detect natural image boundaries using local
    brightness, color, and texture cues", PAMI 26, 2004.

    Examples
    --------
    >>> import numpy as np
    >>> gt = np.array([[1, 1, 1, 1, 2, 2, 2, 2]])
    >>> pred = np.array([[1, 1, 1, 2, 2, 2, 3, 3]])
    >>> boundary_precision_recall_f(pred, gt, tolerance=1)
    BoundaryScores(precision=0.5, recall=1.0, f=0.66...)
    """
    return scores_of(boundary_distances(pred, gt, ignore, tolerance=tolerance))


def boundary_displacement_error(
    pred: Labels, gt: Labels, ignore: int | None = 0, *, tolerance: float | None = None
) -> float:
    r"""Mean distance between the two boundaries in pixels; lower is better.

    .. math:: BDE = \tfrac12 \left( \frac1{|B_P|} \sum_{p \in B_P} \min_{g \in B_G} |p - g| +
              \frac1{|B_G|} \sum_{g \in B_G} \min_{p \in B_P} |p - g| \right)

    Parameters
    ----------
    pred, gt : (H, W) integer
        Predicted and true label maps. A prediction's -1 is a region like any other.
    ignore : int, optional
        Label of the true pixels that nobody labelled; the top of this file says what they
        excuse. None: every pixel counts.
    tolerance : float, optional
        Reach in pixels of that excuse; nothing else depends on it. None: 0.0075 of the image
        diagonal.

    Returns
    -------
    float
        From 0 to the image diagonal, which stands for a boundary in one map only. A mean over no
        pixel is left out; 0 if no boundary is in either.

    Raises
    ------
    GeohueError
        If the maps cannot be compared or `tolerance` is negative or not finite.

    References
    ----------
    J. Freixenet, X. Munoz, D. Raba, J. Marti, X. Cufi, "Yet another survey on image
    segmentation: region and boundary information integration", ECCV 2002.

    Examples
    --------
    >>> import numpy as np
    >>> gt = np.array([[1, 1, 1, 1, 2, 2, 2, 2]])
    >>> boundary_displacement_error(np.array([[1, 1, 1, 2, 2, 2, 3, 3]]), gt)
    1.25
    """
    return displacement_of(boundary_distances(pred, gt, ignore, tolerance=tolerance))


def boundary_distances(
    pred: Labels, gt: Labels, ignore: int | None = 0, *, tolerance: float | None = None
) -> BoundaryDistances:
    """Distances that the boundary measures share; see `boundary_precision_recall_f`.

    Raises
    ------
    GeohueError
        If the maps cannot be compared or `tolerance` is negative or not finite.
    """
    pred, gt = checked_labels(pred, gt)
    _check_grid(gt, "pred and gt")
    diagonal = math.hypot(*gt.shape)
    reach = TOLERANCE * diagonal if tolerance is None else float(tolerance)
    if not 0 <= reach < math.inf:
        raise GeohueError(f"tolerance {tolerance}: give a distance in pixels, 0 or more")
    ignored = np.zeros(gt.shape, bool) if ignore is None else gt == ignore
    if ignored.all():
        raise GeohueError(
            f"gt {gt.shape}: every pixel has the ignored label {ignore}, none is left to compare; "
            "check the crop and which label means 'none' (ignore=None compares every pixel)"
        )
    in_pred, in_gt = boundary_map(pred), _true_boundary(gt, ignore, reach)
    to_gt = _distance_to(in_gt, diagonal)
    excused = (to_gt > reach) & _near(ignored, reach)
    return BoundaryDistances(
        to_gt[in_pred & ~excused], _distance_to(in_pred, diagonal)[in_gt], reach
    )


def scores_of(distances: BoundaryDistances) -> BoundaryScores:
    """`boundary_precision_recall_f` of the distances."""
    precision = _share_within(distances.pred_to_gt, distances.tolerance)
    recall = _share_within(distances.gt_to_pred, distances.tolerance)
    total = precision + recall
    return BoundaryScores(precision, recall, 2 * precision * recall / total if total else 0.0)


def displacement_of(distances: BoundaryDistances) -> float:
    """`boundary_displacement_error` of the distances."""
    sides = [float(d.mean()) for d in (distances.pred_to_gt, distances.gt_to_pred) if d.size]
    return sum(sides) / len(sides) if sides else 0.0


def _share_within(distances: Floats, tolerance: float) -> float:
    return float(np.mean(distances <= tolerance)) if distances.size else 1.0


def _distance_to(mask: Mask, nowhere: float) -> Floats:
    """Distance of every pixel to the nearest True one; `nowhere` if there is none."""
    if not mask.any():
        return np.full(mask.shape, nowhere)
    distance: Floats = ndimage.distance_transform_edt(~mask)
    return distance


def _true_boundary(gt: Labels, ignore: int | None, reach: float) -> Mask:
    """Boundary of the true regions, over ignored gaps of up to twice `reach` (rule 1)."""
    if ignore is None:
        return boundary_map(gt)
    distance, nearest = ndimage.distance_transform_edt(gt == ignore, return_indices=True)
    closed = np.where(distance <= reach, gt[tuple(nearest)], gt)
    return boundary_map(closed, ignore)


def _near(ignored: Mask, reach: float) -> Mask:
    """Pixels in or beside the ignored area, or within `reach` of it (rule 2)."""
    return _distance_to(ignored, math.inf) <= max(reach, 1.0)


def _check_grid(labels: Labels, name: str) -> None:
    if labels.ndim != 2:
        raise GeohueError(
            f"{name} has shape {labels.shape}: boundaries need an (H, W) label map; "
            "for the points of a cloud use the measures in geohue.measures.partition"
        )
