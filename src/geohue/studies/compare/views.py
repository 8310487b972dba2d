"""What a plate shows of a scene and of each cell, as pictures of one size."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.results.picture import NO_LABEL, picture
from geohue.scene import Scene
from geohue.studies.compare.cells import Comparison, Result
from geohue.studies.compare.match import match_labels

Image = NDArray[np.uint8]


def input_views(
    scene: Scene, truth: NDArray[np.integer] | None = None, reference: Result | None = None
) -> dict[str, Image]:
    """Show what a comparison begins with.

    Parameters
    ----------
    scene : Scene
    truth : integer, shape of the scene, optional
        True labels, 0 for none.
    reference : Result, optional
        Its colours are those of the truth.

    Returns
    -------
    dict of str to (H, W, 3) uint8
        ``image``; ``depth``, bright where near, on grids with geometry; ``ground truth``.
    """
    shown = {"image": _half(picture(scene, np.full(scene.shape, -1, np.int32)), 0)}
    if scene.is_grid and scene.valid.any():
        depth = scene.points[..., 2] if scene.depth is None else scene.depth
        shown["depth"] = paint_depth(depth)
    if truth is not None:
        labels = _numbered(truth)
        if reference is not None and reference.labels is not None:
            labels = match_labels(labels, reference.labels)
        shown["ground truth"] = _half(picture(scene, labels), 1)
    return shown


def cell_views(scene: Scene, comparison: Comparison) -> dict[str, Image]:
    """Show the segments of each cell that is done, by its name; (H, W, 3) uint8 each.

    A part that several methods find has one colour, that of the first cell.
    """
    first = reference_of(comparison)
    shown = {}
    for result in comparison.results:
        if result.labels is not None and first is not None and first.labels is not None:
            labels = match_labels(result.labels, first.labels)
            shown[result.cell.name] = _half(picture(scene, labels), 1)
    return shown


def reference_of(comparison: Comparison) -> Result | None:
    """Return the first cell that is done: its colours go for all."""
    return next((r for r in comparison.results if r.status == "done"), None)


def paint_depth(depth: NDArray[np.floating]) -> Image:
    """Show a depth map: bright is near, the colour of no label is missing.

    Examples
    --------
    >>> near, far, missing = paint_depth(np.array([[1.0, 9.0, np.nan]]))[0].tolist()
    >>> sum(near) > sum(far), missing
    (True, [40, 40, 40])
    """
    import cv2

    known = np.isfinite(depth)
    low, high = np.quantile(depth[known], (0.01, 0.99)) if known.any() else (0.0, 1.0)
    share = (high - np.where(known, depth, high)) / max(float(high - low), 1e-30)
    bytes_ = (255 * np.clip(share, 0, 1)).astype(np.uint8)
    shown = np.asarray(cv2.applyColorMap(bytes_, cv2.COLORMAP_VIRIDIS)[..., ::-1], np.uint8)
    return np.asarray(np.where(known[..., None], shown, np.uint8(NO_LABEL[0])), np.uint8)


def scaled(image: Image, size: int) -> Image:
    """Scale a picture such that its longer side has `size` pixels."""
    import cv2

    height, width = image.shape[:2]
    factor = size / max(height, width)
    shape = max(1, round(width * factor)), max(1, round(height * factor))
    way = cv2.INTER_AREA if factor < 1 else cv2.INTER_NEAREST
    return np.asarray(cv2.resize(image, shape, interpolation=way), np.uint8)


def _numbered(truth: NDArray[np.integer]) -> NDArray[np.int32]:
    """Number true labels from 0; -1 for none."""
    values, place = np.unique(np.maximum(truth, 0), return_inverse=True)
    return np.asarray(place.reshape(truth.shape) - int(values[0] == 0), np.int32)


def _half(pair: Image, which: int) -> Image:
    """Return the scene (0) or the segments (1) of `geohue.results.picture.picture`."""
    return np.hsplit(pair, 2)[which]
