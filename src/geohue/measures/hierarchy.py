"""How good a hierarchy of segmentations is: at one threshold for all frames, and at each's best.

A hierarchy gives a segmentation for every threshold, the coarser the higher. Two summaries over a
data set, after the Berkeley benchmark:

- ODS (optimal data set scale): the best value that one threshold, common to all frames, reaches;
- OIS (optimal image scale): the value if each frame takes the threshold that is best for it, which
  needs the truth: what there is to gain by a better choice of the level.

VoI, Rand and covering are means over frames, so their OIS is never worse than their ODS. Precision
and recall of boundaries are those of all frames' boundary pixels together, as in that benchmark,
and F is that of the two; OIS takes the level with the best F of each frame.

P. Arbelaez, M. Maire, C. Fowlkes, J. Malik, "Contour detection and hierarchical image
segmentation", PAMI 33, 2011, section 3.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.measures.boundary import boundary_distances
from geohue.measures.contingency import Counts, Labels, contingency_table
from geohue.measures.partition import covering_of, information_of, rand_of

Floats: TypeAlias = NDArray[np.float64]
Levels: TypeAlias = Sequence[tuple[float, Labels]] | Callable[[float], Labels]

REGION_MEASURES = ("voi_bits", "rand", "covering")
LOWER_IS_BETTER = frozenset({"voi_bits"})


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """The measures of one frame's hierarchy at each threshold.

    Attributes
    ----------
    thresholds : (T,) float64
        Ascending. Between two, the segmentation is that of the lower one; below the first, of it.
    regions : (3, T) float64
        The REGION_MEASURES.
    boundary : (4, T) int64 or None
        Boundary pixels: predicted ones that match, predicted, true ones that are found, true.
        None for clouds, and where they were not asked for.
    """

    thresholds: Floats
    regions: Floats
    boundary: Counts | None


class Best(NamedTuple):
    """A measure of a set of hierarchies.

    Attributes
    ----------
    ods : float
        At the best common threshold.
    threshold : float
        That threshold; of several, the lowest.
    ois : float
        At each frame's own best threshold.
    """

    ods: float
    threshold: float
    ois: float


def hierarchy_curve(
    levels: Levels,
    gt: Labels,
    ignore: int | None = 0,
    *,
    thresholds: Sequence[float] | None = None,
    boundaries: bool = True,
    tolerance: float | None = None,
) -> Curve:
    """Measure a frame's hierarchy at each threshold.

    Parameters
    ----------
    levels : sequence of (threshold, labels), or callable
        Labels are (H, W) or (N,) integer, of the shape of `gt`; -1 is none. A sequence may come in
        any order. A callable is given a threshold and returns labels.
    gt : (H, W) or (N,) integer
        True labels.
    ignore : int, optional
        Label of the true pixels that are left out. None leaves out none.
    thresholds : sequence of float, optional
        Where to call a callable. A sequence of levels has its own.
    boundaries : bool, optional
        Whether to measure boundaries, too, which takes most of the time; (N,) labels have none.
    tolerance : float, optional
        Of boundaries, in pixels (`geohue.measures.boundary_precision_recall_f`).

    Returns
    -------
    Curve

    Raises
    ------
    GeohueError
        If there is no level, a threshold is given twice or not a number, thresholds are missing or
        not wanted, or labels cannot be compared.

    Examples
    --------
    >>> import numpy as np
    >>> gt = np.array([[1, 1, 2, 2]])
    >>> levels = [(0.0, np.array([[1, 2, 3, 4]])), (1.0, gt), (2.0, np.array([[1, 1, 1, 1]]))]
    >>> hierarchy_curve(levels, gt).regions[0].tolist()
    [1.0, 0.0, 1.0]
    """
    pairs = _listed(levels, thresholds)
    regions = np.empty((len(REGION_MEASURES), len(pairs)))
    counts = np.empty((4, len(pairs)), np.int64)
    wanted = boundaries and np.ndim(gt) == 2
    for i, (_, labels) in enumerate(pairs):
        table = contingency_table(labels, gt, ignore)
        regions[:, i] = information_of(table).total, rand_of(table), covering_of(table)
        if wanted:
            there, back, reach = boundary_distances(labels, gt, ignore, tolerance=tolerance)
            counts[:, i] = (there <= reach).sum(), there.size, (back <= reach).sum(), back.size
    return Curve(np.array([t for t, _ in pairs]), regions, counts if wanted else None)


def best_levels(curves: Sequence[Curve]) -> dict[str, Best]:
    """Summarise the hierarchies of a data set.

    Parameters
    ----------
    curves : sequence of Curve
        One a frame; their thresholds may differ and must mean the same.

    Returns
    -------
    dict of str to Best
        voi_bits (lower is better), rand, covering (higher), and boundary_f (higher) if all curves
        have boundaries. The common threshold is one of any frame.

    Raises
    ------
    GeohueError
        If there are no curves.

    Examples
    --------
    >>> import numpy as np
    >>> flat, cut, two = np.array([1, 1, 1, 1]), np.array([1, 2, 3, 4]), np.array([1, 1, 2, 2])
    >>> early = hierarchy_curve([(0, cut), (1, two), (2, flat)], two)
    >>> late = hierarchy_curve([(0, cut), (2, two)], two)
    >>> best_levels([early, late])["voi_bits"]
    Best(ods=0.5, threshold=1.0, ois=0.0)
    """
    if not curves:
        raise GeohueError("curves is empty: give at least one frame's curve")
    common = np.unique(np.concatenate([curve.thresholds for curve in curves]))
    best = {
        name: _best_mean([(curve.thresholds, curve.regions[i]) for curve in curves], common, name)
        for i, name in enumerate(REGION_MEASURES)
    }
    counts = [(c.thresholds, c.boundary) for c in curves if c.boundary is not None]
    if len(counts) == len(curves):
        best["boundary_f"] = _best_boundary(counts, common)
    return best


def _listed(levels: Levels, thresholds: Sequence[float] | None) -> list[tuple[float, Labels]]:
    """Thresholds and labels, ascending."""
    if callable(levels):
        if thresholds is None:
            raise GeohueError("levels is a function: say at which thresholds to call it")
        pairs = [(float(t), levels(t)) for t in thresholds]
    else:
        if thresholds is not None:
            raise GeohueError("levels has thresholds of its own: leave out thresholds")
        pairs = [(float(t), labels) for t, labels in levels]
    pairs.sort(key=lambda pair: pair[0])
    values = np.array([t for t, _ in pairs])
    if values.size == 0 or np.isnan(values).any() or (np.diff(values) == 0).any():
        raise GeohueError(f"thresholds {values.tolist()}: give at least one, all different numbers")
    return pairs


def _at(thresholds: Floats, common: Floats) -> NDArray[np.intp]:
    """Index of the level that holds at each of the common thresholds."""
    return np.maximum(np.searchsorted(thresholds, common, side="right") - 1, 0)


def _best_mean(frames: Sequence[tuple[Floats, Floats]], common: Floats, name: str) -> Best:
    pick = np.argmin if name in LOWER_IS_BETTER else np.argmax
    mean = np.mean([values[_at(own, common)] for own, values in frames], axis=0)
    place = int(pick(mean))
    each = np.mean([values[pick(values)] for _, values in frames])
    return Best(float(mean[place]), float(common[place]), float(each))


def _best_boundary(frames: Sequence[tuple[Floats, Counts]], common: Floats) -> Best:
    together = np.sum([counts[:, _at(own, common)] for own, counts in frames], axis=0)
    scores = _f_of(together)
    place = int(scores.argmax())
    own_best = np.sum([counts[:, _f_of(counts).argmax()] for _, counts in frames], axis=0)
    return Best(float(scores[place]), float(common[place]), float(_f_of(own_best[:, None])[0]))


def _f_of(counts: Counts) -> Floats:
    """F of the counts of `Curve.boundary`, (T,)."""
    hits, predicted, found, true = counts.astype(np.float64)
    precision = np.where(predicted > 0, hits / np.maximum(predicted, 1), 1.0)
    recall = np.where(true > 0, found / np.maximum(true, 1), 1.0)
    total = precision + recall
    return np.asarray(2 * precision * recall / np.where(total > 0, total, 1))
