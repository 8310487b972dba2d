"""Beyond Sec. IV: the weight whose segmentation others agree with, with borders on colour edges.

Q rewards depth that differs between segments, also where one surface is cut in pieces. This rule
asks for three other things, and needs no reference either (docs/evaluation.md has the figures):

- contrast: the colour step across the borders, over that between any neighbours;
- consensus: the segmentation is like those for all other weights;
- stability: it is like those for the neighbouring weights.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from geohue.compute.parallel import Workers
from geohue.features import lab_of
from geohue.regions.adjacency import adjacent_points
from geohue.scene import Scene
from geohue.settings.weight import HALF_OCTAVES
from geohue.weight.likeness import likeness

Labels = NDArray[np.int32]


def weight_by_agreement(
    split: Callable[[float], Labels],
    scene: Scene,
    workers: Workers,
    weights: Sequence[float] = HALF_OCTAVES,
) -> tuple[float, list[Labels]]:
    """Choose the weight with the most contrast, consensus and stability together.

    Each of the three is brought to mean 0 and deviation 1 over the weights; their sum decides,
    and of equal sums the weight nearest to 1.

    Parameters
    ----------
    split : callable
        Labels of `scene` for a weight; must be safe to call from several threads.
    scene : Scene
        The draft.
    workers : Workers
        Threads to use.
    weights : sequence of float
        Positive, in increasing order.

    Returns
    -------
    weight : float
        The best weight; 1 if no weight gives two segments.
    labels : list of int32 arrays
        The segmentations, one for each weight.

    Examples
    --------
    >>> from geohue.compute.parallel import workers
    >>> rgb = np.zeros((4, 6, 3), np.uint8)
    >>> rgb[:, 3:] = 255
    >>> scene = Scene.from_rgbd(rgb, np.ones((4, 6)))
    >>> good, bad = np.repeat([[0, 0, 0, 1, 1, 1]], 4, 0), np.repeat([[0, 1, 1, 1, 1, 1]], 4, 0)
    >>> with workers(1) as team:
    ...     weight, _ = weight_by_agreement(
    ...         lambda x: (good if x < 3 else bad).astype(np.int32), scene, team, (1.0, 2.0, 4.0)
    ...     )
    >>> weight
    1.0
    """
    contrast = BorderContrast(scene)
    maps = list(workers.map(split, weights))
    steps = np.array(list(workers.map(contrast, maps)))
    usable = np.flatnonzero(np.isfinite(steps))
    if len(usable) == 0:
        return 1.0, maps
    consensus, stability = likeness([maps[i] for i in usable])
    total = _standard(steps[usable]) + _standard(consensus) + _standard(stability)
    offset = np.abs(np.log2(np.array(weights)[usable]))
    best = np.lexsort((offset, -total.round(9)))[0]
    return float(weights[usable[best]]), maps


class BorderContrast:
    """The mean colour step across the borders of segments, over that between any neighbours.

    Neighbours are pixels side by side, or the nearest points of a cloud. The step is the distance
    in CIELab.

    Parameters
    ----------
    scene : Scene
        Points without geometry take no part.
    """

    def __init__(self, scene: Scene) -> None:
        self._one, self._other = adjacent_points(scene)
        lab = lab_of(scene.colors.reshape(-1, 3))
        self._step = np.linalg.norm(lab[self._one] - lab[self._other], axis=1).astype(np.float64)

    def __call__(self, labels: Labels) -> float:
        """Return the contrast of a segmentation, 0 or more; NaN without any border."""
        from geohue.weight.passes import add_steps  # compiled code takes a moment to load

        flat = np.ascontiguousarray(labels, np.int32).reshape(-1)
        counts, sums = np.zeros(2, np.int64), np.zeros(2)
        add_steps(flat, self._one, self._other, self._step, counts, sums)
        if counts[1] == 0:
            return float("nan")
        everywhere, across = sums / counts
        return float(across / everywhere) if everywhere > 0 else 0.0


def _standard(values: NDArray[np.float64]) -> NDArray[np.float64]:
    spread = float(values.std())
    return np.asarray((values - values.mean()) / (spread if spread > 1e-12 else 1.0))
