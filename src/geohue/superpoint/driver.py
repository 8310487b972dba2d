"""From a scene to its superpoints."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from geohue.compute.labels import relabel
from geohue.errors import GeohueError
from geohue.fill.unseen import label_unseen
from geohue.merge.levels import Levels
from geohue.merge.tree import MergeTree
from geohue.objects import Measured, Segments
from geohue.scene import Scene
from geohue.segmentation.result import Progress, Segmentation, StageClock
from geohue.settings.checks import is_whole
from geohue.superpoint import loops
from geohue.superpoint.nodes import Nodes, nodes_of, with_crumbs
from geohue.superpoint.ward import merge_regions, tabulate
from geohue.superpoint.weights import CRUMB, FINE, MOST, SHARE, merging_weights, step_weights

Labels = NDArray[np.int32]


def superpoints(
    scene: Scene,
    count: int | None = None,
    size: float | None = None,
    width: float | None = None,
    *,
    cues: str = "auto",
    compactness: float = 1.0,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Segmentation:
    r"""Split a scene into many small connected parts that follow colour and geometry.

    Points side by side become fine regions, those with the least step between them first; then the
    two neighbouring regions whose union costs least are merged, again and again:

    .. math:: \left(\frac{nm}{n+m}\right)^p \left(w_c |\Delta Lab|^2 + w_t |\Delta N|^2 + w_0
        + c\, w_l \frac{|\Delta x|^2}{s^2 (n+m)}\right) (w_e + \bar e)

    for regions of n and m points; Lab, N and x are means over a region of the colours, of the
    products of normals with themselves (which have no sign) and of the positions, s is the spacing
    of the points and e the mean step along the border. The merges form a tree: every coarser
    over-segmentation is nested in the finer ones.

    Parameters
    ----------
    scene : Scene
        A frame or a cloud.
    count : int, optional
        How many superpoints. Pieces of a cloud that lie apart stay apart, so there may be more;
        those with less than a quarter of the mean number of points count to what is nearest.
    size : float, optional
        Instead, how many points one has on average.
    width : float, optional
        Instead, how wide one is on average, in the unit of the scene (metres): the root of the
        mean area.
    cues : {"auto", "fusion", "color", "geometry"}
        What to go by. "auto" takes what there is: grey values count as colours, a cloud of one
        colour goes by geometry alone, an image without depth by colour alone.
    compactness : float
        Not negative: 0 follows colour and geometry only, more makes rounder superpoints.
    threads : int, optional
        How many; by default one a core. The labels do not depend on it.
    progress : callable, optional
        Called with the name of each stage as it begins.

    Returns
    -------
    Segmentation
        `levels` begins with the superpoints and ends with one segment for each piece:
        ``levels.with_segments(k)`` is a coarser over-segmentation (`nested`). `neighbours` is the
        graph of superpoints. Points without a position have no label, pixels of a frame have one.

    Raises
    ------
    GeohueError
        Unless one of `count`, `size` and `width` is given, positive, or for a scene without points.

    Examples
    --------
    >>> from geohue.simulate import scene
    >>> frame, truth = scene("boxes")
    >>> fine = superpoints(frame, count=300)
    >>> fine.k, fine.neighbours.n_segments
    (300, 300)
    """
    clock = StageClock(progress)
    taken = _cues(scene, cues)
    check_compactness(compactness)
    check_size(count, size, width)
    with clock.stage("points"):
        nodes = nodes_of(scene, taken, threads)
        wanted = _count(nodes, count, size, width)
        if not scene.is_grid:
            nodes = with_crumbs(nodes, max(CRUMB, SHARE * float(nodes.weight.sum()) / wanted))
    with clock.stage("fine regions"):
        fine, n, step = fine_regions(nodes, wanted)
    with clock.stage("merge"):
        shape = nodes.points, nodes.lab, nodes.normals, nodes.weight, nodes.one, nodes.other
        table = tabulate(fine, n, *shape, step)
        merges, costs = merge_regions(table, nodes.spacing, merging_weights(compactness))
        tree, region = from_level(MergeTree(n, merges, costs), wanted)
    with clock.stage("labels"):
        names, old = relabel(region[fine][nodes.node])
        names[nodes.node < 0] = -1
        labels = label_unseen(names.reshape(scene.shape), scene)
        levels = Levels(labels, renamed(tree, old))
    k = len(old)
    seg = Segmentation(
        labels,
        k,
        {"color": 0.0, "geometry": math.inf}.get(taken, math.nan),
        None,
        [],
        "superpoints",
        "superpoints",
        taken,
        0,
        clock.timings(),
        (*scene.warnings, *_notes(k, wanted)),
        levels,
        scene=scene,
    )
    pairs = nodes.first[nodes.one], nodes.first[nodes.other]
    seg._made["segments"] = Segments(Measured(scene, labels, k, pairs))
    return seg


def nested(seg: Segmentation, counts: Sequence[int]) -> NDArray[np.int64]:
    """Return several of the nested over-segmentations of a scene.

    Parameters
    ----------
    seg : Segmentation
        Superpoints, or any segmentation with levels.
    counts : sequence of int
        How many superpoints each has; not more than `seg` has itself.

    Returns
    -------
    (L, H, W) or (L, N) int64
        Labels 0..k-1, -1 = none.

    Raises
    ------
    GeohueError
        If there are no levels, or a count is below 1 or above the finest.
    """
    if seg.levels is None:
        raise GeohueError("this segmentation has no levels: superpoints(...) has")
    for count in counts:
        if not (is_whole(count) and 1 <= count <= seg.levels.tree.n_regions):
            finest = seg.levels.tree.n_regions
            raise GeohueError(f"count is {count!r}: the levels go from 1 to {finest} superpoints")
    return np.stack([seg.levels.with_segments(int(c)) for c in counts]).astype(np.int64)


def fine_regions(
    nodes: Nodes, wanted: int, *, exact: bool = False
) -> tuple[Labels, int, NDArray[np.float64]]:
    """Join neighbours into sets of a few points, those with the least step first.

    Parameters
    ----------
    nodes : Nodes
        The points.
    wanted : int
        How many superpoints they are to become.
    exact : bool
        Whether the order of the pairs goes by their steps alone, and not by that of the nodes where
        two steps are nearly the same.

    Returns
    -------
    fine : (M,) int32
        The set of each node.
    n : int
        How many there are.
    step : (E,) float64
        The step between each two neighbours.
    """
    step = np.empty(len(nodes.one))
    here = nodes.points, nodes.lab, nodes.normals, nodes.one, nodes.other
    loops.pair_steps(*here, nodes.spacing, step_weights(), step)
    # Sixteen bits sort many times faster than the numbers themselves.
    keys = step if exact else np.minimum(step * 2000, 65535).astype(np.uint16)
    order = np.argsort(keys, kind="stable")
    parent, size = np.arange(nodes.size, dtype=np.int32), nodes.weight.copy()
    cap = min(MOST, float(nodes.weight.sum()) / wanted / FINE)
    loops.join_capped(nodes.one, nodes.other, order, parent, size, cap)
    fine = np.empty(nodes.size, np.int32)
    return fine, loops.number_sets(parent, fine), step


def check_compactness(compactness: float) -> None:
    """Raise an error unless it is a number of at least 0."""
    if not (math.isfinite(compactness) and compactness >= 0):
        raise GeohueError(f"compactness is {compactness}: expected a number of at least 0")


def check_cues(cues: str) -> None:
    """Raise an error for a word that names no cues."""
    if cues not in ("auto", "fusion", "color", "geometry"):
        raise GeohueError(f"cues is {cues!r}: choose auto, fusion, color or geometry")


def _cues(scene: Scene, cues: str) -> str:
    check_cues(cues)
    if cues != "auto":
        return cues
    if scene.is_grid and not scene.valid.any():
        return "color"
    colors = scene.colors.reshape(-1, 3)
    return "geometry" if len(colors) and (colors == colors[0]).all() else "fusion"


def check_size(count: int | None, size: float | None, width: float | None) -> None:
    """Raise an error unless one of the three is given, and positive."""
    given = {"count": count, "size": size, "width": width}
    there = {name: value for name, value in given.items() if value is not None}
    if len(there) != 1:
        names = " and ".join(there) or "nothing"
        raise GeohueError(f"{names} given: say either count, size (points) or width (metres)")
    ((name, value),) = there.items()
    if name == "count" and not (is_whole(value) and value >= 1):
        raise GeohueError(f"count is {value!r}: expected a whole number of at least 1")
    least = 1.0 if name == "size" else 0.0
    if not (math.isfinite(value) and value >= least and value > 0):
        raise GeohueError(f"{name} is {value!r}: expected a number above {least:g}")


def _count(nodes: Nodes, count: int | None, size: float | None, width: float | None) -> int:
    points = float(nodes.weight.sum())
    if size is not None:
        count = max(1, round(points / size))
    elif width is not None:
        area = loops.mean_area(nodes.points, nodes.normals, nodes.one, nodes.other)
        with np.errstate(all="ignore"):  # a width whose square is no number: one, or all
            found = area * nodes.size / np.float64(width) ** 2
        count = max(1, round(np.fmin(found, nodes.size)))
    assert count is not None
    return min(count, nodes.size)


def from_level(tree: MergeTree, count: int) -> tuple[MergeTree, Labels]:
    """Cut off what is finer than a level; return the rest, and the regions that it begins with."""
    n = min(max(tree.n_regions - count, 0), len(tree.merges))
    region = tree.after(n)
    names = np.full(tree.n_regions, -1, np.int64)
    names[roots(tree, n)] = region[roots(tree, n)]
    return MergeTree(int(region.max()) + 1, names[tree.merges[n:]], tree.scores[n:]), region


def roots(tree: MergeTree, n: int) -> NDArray[np.int64]:
    """Return the regions whose names stand for a segment after n merges."""
    there = np.ones(tree.n_regions, bool)
    there[tree.merges[:n, 1]] = False
    return np.flatnonzero(there)


def renamed(tree: MergeTree, old: NDArray[np.int32]) -> MergeTree:
    """Return a tree whose region i was the region old[i]."""
    new = np.empty(len(old), np.int64)
    new[old] = np.arange(len(old))
    return MergeTree(tree.n_regions, new[tree.merges], tree.scores)


def _notes(found: int, wanted: int) -> list[str]:
    if found <= wanted:
        return []
    return [f"{found} superpoints instead of {wanted}: so many pieces lie apart"]
