"""How good a segmentation is, measured against true labels."""

from __future__ import annotations

import math

from geohue.measures.boundary import (
    boundary_displacement_error,
    boundary_distances,
    boundary_map,
    boundary_precision_recall_f,
    displacement_of,
    scores_of,
)
from geohue.measures.contingency import (
    UNLABELLED,
    Contingency,
    Labels,
    checked_labels,
    contingency_table,
)
from geohue.measures.crop import Crop, window
from geohue.measures.hierarchy import best_levels, hierarchy_curve
from geohue.measures.object_report import ObjectProtocol, measure_objects
from geohue.measures.objects import object_precision_recall_f
from geohue.measures.outlines import object_boundary_precision_recall_f
from geohue.measures.partition import (
    achievable_segmentation_accuracy,
    adjusted_rand_index,
    adjusted_rand_of,
    covering_of,
    information_of,
    leak_of,
    probabilistic_rand_index,
    rand_index,
    rand_of,
    segmentation_covering,
    undersegmentation_error,
    variation_of_information,
)
from geohue.measures.superpoints import superpoint_scores
from geohue.measures.temporal import flicker, identity_switches, steadiness

__all__ = [
    "ObjectProtocol",
    "achievable_segmentation_accuracy",
    "adjusted_rand_index",
    "best_levels",
    "boundary_displacement_error",
    "boundary_map",
    "boundary_precision_recall_f",
    "contingency_table",
    "evaluate",
    "flicker",
    "hierarchy_curve",
    "identity_switches",
    "object_boundary_precision_recall_f",
    "object_precision_recall_f",
    "probabilistic_rand_index",
    "rand_index",
    "segmentation_covering",
    "steadiness",
    "superpoint_scores",
    "undersegmentation_error",
    "variation_of_information",
]


def evaluate(
    pred: Labels,
    gt: Labels,
    ignore: int | None = 0,
    crop: Crop | None = None,
    tolerance: float | None = None,
    objects: ObjectProtocol | None = None,
) -> dict[str, float]:
    """Measure a segmentation against true labels with every measure of this package.

    Parameters
    ----------
    pred : (H, W) or (N,) integer
        Predicted labels; -1 (no label) counts as one region of its own.
    gt : (H, W) or (N,) integer
        True labels, of the same shape.
    ignore : int, optional
        Label of the true pixels that are left out. None leaves out none.
    crop : (top, bottom, left, right), optional
        Compare ``[top:bottom, left:right]`` only, e.g. (44, 471, 40, 601) for NYU Depth V2.
    tolerance : float, optional
        Of the boundary measures, in pixels. None: 0.0075 of the (cropped) diagonal.
    objects : ObjectProtocol, optional
        Measure objects, too, each with one segment (`measure_objects` names what is added).

    Returns
    -------
    dict of str to float
        Finite numbers, ready for JSON:

        - voi_bits, voi_nats: variation of information, lower is better, and its parts
          over_bits, H(pred|gt), and under_bits, H(gt|pred);
        - rand, adjusted_rand, covering: higher is better; undersegmentation_error: lower;
        - boundary_precision, boundary_recall, boundary_f: higher is better;
          boundary_displacement, in pixels: lower. Left out for (N,) labels, which have no
          boundaries;
        - n_pred, n_gt: regions in the compared pixels (-1 is not one); n_pixels: those pixels.

    Raises
    ------
    GeohueError
        If the labels cannot be compared, or the crop is not inside them.

    Examples
    --------
    >>> import numpy as np
    >>> scores = evaluate(np.array([[1, 2, 3, 3]]), np.array([[1, 1, 2, 2]]))
    >>> scores["voi_bits"], scores["covering"], scores["n_pred"]
    (0.5, 0.75, 3)
    """
    pred, gt = checked_labels(pred, gt)
    if crop is not None:
        part = window(crop, gt.shape)
        pred, gt = pred[part], gt[part]
    table = contingency_table(pred, gt, ignore)
    scores = _region_scores(table)
    if gt.ndim == 2:
        scores |= _boundary_scores(pred, gt, ignore, tolerance)
    if objects is not None:
        scores |= measure_objects(pred, gt, objects, ignore)
    return scores | {
        "n_pred": int((table.pred_labels != UNLABELLED).sum()),
        "n_gt": table.gt_labels.size,
        "n_pixels": table.n_pixels,
    }


def _region_scores(table: Contingency) -> dict[str, float]:
    bits = information_of(table, base=2)
    return {
        "voi_bits": bits.total,
        "voi_nats": bits.total * math.log(2),
        "over_bits": bits.over,
        "under_bits": bits.under,
        "rand": rand_of(table),
        "adjusted_rand": adjusted_rand_of(table),
        "covering": covering_of(table),
        "undersegmentation_error": leak_of(table),
    }


def _boundary_scores(
    pred: Labels, gt: Labels, ignore: int | None, tolerance: float | None
) -> dict[str, float]:
    distances = boundary_distances(pred, gt, ignore, tolerance=tolerance)
    scores = scores_of(distances)
    return {
        "boundary_precision": scores.precision,
        "boundary_recall": scores.recall,
        "boundary_f": scores.f,
        "boundary_displacement": displacement_of(distances),
    }
