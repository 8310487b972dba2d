"""Labels of a draft for the whole scene, with borders where colour and geometry change."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from geohue.prepared import PreparedScene
from geohue.regions.adjacency import first_of_each, nearest_known
from geohue.scene import Scene

NEAREST = 4
"""Points of the draft that a point may take its label from."""

Labels = NDArray[np.int32]
Source = Callable[[NDArray[np.int64]], NDArray[np.int64]]
"""From positions in the scene, (M,), to positions in the draft, (M, `NEAREST`) or fewer."""

_BLOCK = 65_536


def spread(labels: Labels, prepared: PreparedScene) -> Labels:
    """Give each point the label of the nearby point of the draft that it is most like.

    Nearby are the four points of the draft around it, likeness is the distance of the balanced
    vectors (`Features.mixed` at weight 1): joint upsampling by the nearest example.

    Parameters
    ----------
    labels : (h, w) or (m,) int32
        Labels of the draft, -1 where it has no point.
    prepared : PreparedScene
        The scene and its draft.

    Returns
    -------
    (H, W) or (N,) int32
        -1 where the scene has no point.

    Examples
    --------
    >>> from geohue.prepared import prepare_scene
    >>> from geohue.settings import Preset
    >>> rgb = np.zeros((4, 8, 3), np.uint8)
    >>> rgb[:, 5:] = 255
    >>> prepared = prepare_scene(Scene.from_rgbd(rgb, np.ones((4, 8))), Preset(draft_points=8))
    >>> prepared.positions.tolist()
    [[9, 11, 13, 15], [25, 27, 29, 31]]
    >>> spread((prepared.positions % 8 > 4).astype(np.int32), prepared)[0]
    array([0, 0, 0, 0, 0, 1, 1, 1], dtype=int32)
    """
    scene, draft, features = prepared.scene, prepared.positions, prepared.features
    flat = labels.reshape(-1)
    if draft.size == scene.size:
        whole = np.empty(scene.size, np.int32)
        whole[draft.reshape(-1)] = flat
        return whole.reshape(scene.shape)
    examples = np.flatnonzero(flat >= 0)
    if scene.is_grid:
        around = _around_pixel(labels, draft, scene)
    else:
        around = _around_point(draft, examples, scene)
    vectors = features.mixed(1.0)
    row_of = np.zeros(flat.size, np.int64)
    row_of[examples] = np.searchsorted(features.index, draft.reshape(-1)[examples])

    def choose(block: slice) -> Labels:
        near = around(features.index[block])
        choices = flat[near]
        torn = np.flatnonzero((choices != choices[:, :1]).any(axis=1))
        away = vectors[row_of[near[torn]]] - vectors[block][torn, None]
        nearest = np.einsum("ijk,ijk->ij", away, away).argmin(axis=1)
        choices[torn, 0] = choices[torn, nearest]
        return choices[:, 0]

    parts = prepared.workers.map_blocks(choose, len(features), _BLOCK)
    return features.to_scene(np.concatenate(list(parts)))


def _around_pixel(labels: Labels, draft: NDArray[np.int64], scene: Scene) -> Source:
    """The four pixels of the draft around each; where one has no label, the nearest to it that has.

    The draft of a grid is every n-th row and column.
    """
    height, width = scene.shape
    cell = nearest_known(labels >= 0)
    rows = _two_nearest(height, draft[:, 0] // width)
    columns = _two_nearest(width, draft[0] % width)

    def around(positions: NDArray[np.int64]) -> NDArray[np.int64]:
        y, x = rows[positions // width], columns[positions % width]
        return np.asarray(cell[y[:, :, None], x[:, None, :]].reshape(-1, NEAREST))

    return around


def _two_nearest(n: int, kept: NDArray[np.int64]) -> NDArray[np.int64]:
    """The places in `kept`, evenly spaced among 0..n-1, of the two nearest to each, (n, 2)."""
    step = kept[1] - kept[0] if len(kept) > 1 else 1
    exact = (np.arange(n) - kept[0]) / step
    lower = np.clip(np.floor(exact), 0, max(len(kept) - 2, 0))
    both = np.stack([lower, np.minimum(lower + 1, len(kept) - 1)], axis=1).astype(np.int64)
    nearer = np.abs(exact - both[:, 1]) < np.abs(exact - both[:, 0])
    return np.where(nearer[:, None], both[:, ::-1], both)


def _around_point(draft: NDArray[np.int64], examples: NDArray[np.int64], scene: Scene) -> Source:
    """The four points of the draft nearest to each in space."""
    from scipy.spatial import cKDTree

    examples = examples[first_of_each(scene.points[draft[examples]])[0]]
    tree = cKDTree(scene.points[draft[examples]])
    k = min(NEAREST, len(examples))

    def around(positions: NDArray[np.int64]) -> NDArray[np.int64]:
        _, near = tree.query(scene.points[positions], k)
        return examples[np.asarray(near).reshape(len(positions), k)]

    return around
