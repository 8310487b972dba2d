"""Labels for range points that no camera sees."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.scene import Scene

_REACH = 0.05  # of the extent of the labelled points


def label_unseen(labels: NDArray[np.int32], scene: Scene) -> NDArray[np.int32]:
    """Give points without a colour the label of the nearest labelled point.

    They take no part in the segmentation itself: geometry alone would pull them, and the points
    that share a surface with them have a colour and a label. Points farther from every labelled
    one than 5 % of the labelled scene's extent (behind a scanner's cameras) stay without a label.
    `geohue.segment` does this last; a second call changes nothing.

    Parameters
    ----------
    labels : shape of the scene, int32
        -1 for none.
    scene : Scene
        `Scene.from_range_and_cameras` made it; without `Scene.unseen` the labels stay as they are.

    Returns
    -------
    int32, same shape

    Examples
    --------
    >>> points = np.array([[0, 0, 1], [1, 0, 1], [1.01, 0, 1], [9, 9, 9]], np.float32)
    >>> unseen = np.array([False, False, True, True])
    >>> scene = Scene(np.zeros((4, 3), np.uint8), points, unseen=unseen)
    >>> label_unseen(np.array([0, 1, -1, -1], np.int32), scene)
    array([ 0,  1,  1, -1], dtype=int32)
    """
    if scene.unseen is None:
        return labels
    from scipy.spatial import cKDTree

    points = scene.points.reshape(-1, 3)
    flat = labels.reshape(-1).copy()
    lacking = scene.unseen.reshape(-1) & (flat < 0) & np.isfinite(points).all(axis=1)
    # Labels given here lend none in turn: a second call would reach farther than the first.
    known = ~scene.unseen.reshape(-1) & (flat >= 0) & np.isfinite(points).all(axis=1)
    if not lacking.any() or not known.any():
        return labels
    reach = _REACH * float(np.linalg.norm(np.ptp(points[known], axis=0)))
    distance, nearest = cKDTree(points[known]).query(points[lacking], distance_upper_bound=reach)
    near = np.isfinite(distance)
    flat[np.flatnonzero(lacking)[near]] = flat[known][np.asarray(nearest)[near]]
    return flat.reshape(labels.shape)
