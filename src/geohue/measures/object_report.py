"""All object measures of a frame as one dict of numbers."""

from __future__ import annotations

from dataclasses import dataclass

from geohue.measures.contingency import Labels
from geohue.measures.objects import BackgroundFrom, kept, match_objects, object_scores_of
from geohue.measures.outlines import outline_scores_of


@dataclass(frozen=True, slots=True)
class ObjectProtocol:
    """What counts as an object.

    Attributes
    ----------
    background : tuple of int
        Labels of the true regions that are no objects.
    background_from : "truth" or "prediction"
        Which predicted segments are background; `geohue.measures.objects` says more.
    """

    background: tuple[int, ...] = ()
    background_from: BackgroundFrom = "truth"


def measure_objects(
    pred: Labels, gt: Labels, protocol: ObjectProtocol, ignore: int | None = 0
) -> dict[str, float]:
    """Measure objects by their overlaps and, on a grid, by their outlines.

    Parameters
    ----------
    pred, gt : (H, W) or (N,) integer
        Predicted and true labels, of one shape. Predicted pixels with -1 are background.
    protocol : ObjectProtocol
    ignore : int, optional
        Label of the true pixels that are left out, unless it is one of the background. None leaves
        out none.

    Returns
    -------
    dict of str to float
        objects_precision, objects_recall, objects_f, objects_detected; on a grid also
        objects_boundary_precision, objects_boundary_recall, objects_boundary_f; n_objects_pred and
        n_objects_gt.

    Raises
    ------
    GeohueError
        If the labels cannot be compared, or for another `background_from`.

    Examples
    --------
    >>> import numpy as np
    >>> gt, pred = np.array([[1, 1, 2, 2]]), np.array([[7, 7, 7, 8]])
    >>> scores = measure_objects(pred, gt, ObjectProtocol(background=(1,)))
    >>> scores["objects_precision"], scores["objects_recall"]
    (1.0, 0.5)
    """
    background = protocol.background
    matching = match_objects(pred, gt, background, ignore, protocol.background_from)
    overlap = object_scores_of(matching)
    scores = {f"objects_{name}": value for name, value in overlap._asdict().items()}
    if gt.ndim == 2:
        outline = outline_scores_of(matching, pred, gt, kept(ignore, background))
        found = outline._asdict()
        scores |= {f"objects_boundary_{name}": value for name, value in found.items()}
    return scores | {
        "n_objects_pred": int(matching.is_object.sum()),
        "n_objects_gt": int(matching.is_true_object.sum()),
    }
