"""The driver: Sections II to IV of the paper and its Appendix, in their order, or the merging."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from geohue.compute.labels import relabel
from geohue.compute.parallel import workers
from geohue.consensus import spread
from geohue.errors import GeohueError
from geohue.features import Cues, Features, extract_features, lab_of
from geohue.fill import fill_labels
from geohue.fill.flood import flood_labels
from geohue.fill.unseen import label_unseen
from geohue.merge.levels import Detail, threshold_of
from geohue.ncut.cutter import Cutter
from geohue.regions.images import connected_components
from geohue.scene import Scene
from geohue.segmentation.choice import (
    Choice,
    Count,
    Weight,
    check_arguments,
    check_count,
    shortfalls,
)
from geohue.segmentation.clusterers import check_method, make_clusterer
from geohue.segmentation.merged import merge_scene, with_position
from geohue.segmentation.presets import Preset, preset_named
from geohue.segmentation.result import Progress, Segmentation, StageClock
from geohue.weight.quality import QualityMetric
from geohue.weight.search import Curve


def segment(
    scene: Scene,
    k: Count = "auto",
    weight: Weight = "auto",
    preset: str | Preset = "best",
    cues: Cues = "fusion",
    method: str = "nncsc",
    seed: int = 0,
    *,
    detail: Detail = "auto",
    components: bool = False,
    fill: bool = True,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Segmentation:
    """Split a scene into its parts from colour and geometry together.

    Parameters
    ----------
    scene : Scene
        An RGB-D frame or a coloured cloud.
    k : int or "auto"
        Number of segments, 1 to 255; "auto" chooses it, and may choose 1. Where regions are merged
        it takes the level of the tree with so many segments.
    weight : float, "auto", "quality", "agreement", "consensus" or "merge"
        The paper's lambda, the weight of geometry against colour, 0 to infinity. "quality" takes
        the one with the highest Q, as the paper does, "agreement" that of `weight_by_agreement`.
        "consensus" and "merge" choose no weight, but let cuts of several weights and numbers of
        segments vote: "consensus" keeps the borders that enough of them draw (`find_consensus`),
        "merge" merges regions on all the evidence (`geohue.merge`). "auto" leaves the choice of
        these to the preset. Of no effect unless `cues` is "fusion" or it is "merge".
    preset : {"best", "fast", "paper"} or Preset
        The settings: "best" and "fast" merge regions, "paper" is the paper's method.
    cues : {"fusion", "color", "geometry"}
        What to go by.
    method : str
        "nncsc", the paper's normalized cut, or a compared system of `geohue.baselines`: kmeans,
        meanshift, felzenszwalb, edison, bleiweiss-werman, calderero-marques. Some of these find
        their own number of segments, or have weights of their own.
    seed : int
        The source of chance, not negative: the same scene, seed and version give the same
        labels.
    detail : float, "auto", "coarse" or "fine"
        How fine the segments are where regions are merged: 0 is "auto", higher is finer
        (`geohue.merge.levels.threshold_of`).
    components : bool
        Whether each connected piece of a segment becomes a segment of its own (grids only).
    fill : bool
        Whether pixels without depth get a label too (grids only).
    threads : int, optional
        How many; by default one a core. The labels do not depend on it.
    progress : callable, optional
        Called with the name of each stage as it begins.

    Returns
    -------
    Segmentation

    Raises
    ------
    GeohueError
        For a scene without any usable point, fewer points than segments, or a bad argument.

    Examples
    --------
    >>> rgb = np.zeros((40, 60, 3), np.uint8)
    >>> rgb[:, 30:] = (200, 60, 40)
    >>> depth = np.where(np.arange(60) < 30, 1.0, 2.0)[None].repeat(40, 0)
    >>> seg = segment(Scene.from_rgbd(rgb, depth), k=2)
    >>> seg.k, seg.labels[0, ::15].tolist()
    (2, [0, 0, 1, 1])
    """
    settings, clock = preset_named(preset), StageClock(progress)
    check_arguments(k, weight, seed, method)
    merges = merges_regions(settings, weight, method)
    check_detail(detail, k, merges)
    if components and not scene.is_grid:
        raise GeohueError("components need a grid of pixels: this scene is a cloud without one")
    check_method(method, cues, scene.is_grid)
    notes, levels = list(scene.warnings), None
    wanted = None if k == "auto" else k
    with workers(threads) as team:
        with clock.stage("features"):  # Sec. II: eq. 1-5
            features = extract_features(scene, cues)
            notes += features.notes
            draft = scene.thinning(settings.draft_points, np.random.default_rng(seed))
            most = settings.k_max if k == "auto" else k
            check_count(len(features), k)
            if merges:
                most, draft = settings.most_voted(cues), with_position(draft, scene, cues)
            cutter = Cutter(features, draft, settings, team, seed, most)
        if merges:  # beyond the paper: many cuts vote, and regions merge on all the evidence
            merged = merge_scene(scene, cutter, draft, settings, team, clock, wanted, detail)
            labels, levels, lam = merged.labels, merged.levels, merged.weight
            curve: Curve = []
        else:
            splitter = make_clusterer(method, cutter, scene, features, draft, team, seed)
            choice = Choice(splitter, cutter, scene, draft, settings, team)
            labels, lam, curve, wanted = _cut(choice, features, k, weight, cues, clock)
        with clock.stage("quality"):  # eq. 17
            score = QualityMetric(scene)(labels)
        with clock.stage("fill"):  # Appendix: pixels without depth, on grids
            if levels is None:
                labels = _filled(labels, scene, settings, fill)
            else:
                levels = replace(levels, regions=_filled(levels.regions, scene, settings, fill))
                labels = merged.segment_of.take(levels.regions, mode="wrap")
                labels = np.where(levels.regions >= 0, labels, np.int32(-1))
        if components:
            labels = connected_components(labels)
        labels, _ = relabel(labels)
    found = int(labels.max()) + 1
    if wanted is not None:
        notes += shortfalls(found, wanted, components)
    return Segmentation(
        labels,
        found,
        lam,
        score.total if score else None,
        curve,
        method,
        preset if isinstance(preset, str) else "custom",
        cues,
        seed,
        clock.timings(),
        tuple(notes),
        levels,
        detail if levels is not None and k == "auto" else None,
    )


def merges_regions(settings: Preset, weight: Weight, method: str) -> bool:
    """Whether regions are merged: as the preset says unless a weight is given, or on request."""
    rule = settings.weight_rule if weight == "auto" else weight
    return rule == "merge" and method == "nncsc"


def check_detail(detail: Detail, k: Count, merges: bool) -> None:
    """Raise `GeohueError` unless a degree of detail has a meaning here."""
    threshold_of(detail)
    if detail == "auto":
        return
    if not merges:
        raise GeohueError(
            f"detail is {detail!r}, but the paper's cut has no levels: "
            'leave the weight to the preset "best" or "fast"'
        )
    if k != "auto":
        raise GeohueError(f"detail is {detail!r} and k is {k}: give one of them")


def _cut(
    choice: Choice, features: Features, k: Count, weight: Weight, cues: Cues, clock: StageClock
) -> tuple[NDArray[np.int32], float, Curve, int | None]:
    """Sections III and IV: K, the weight and the cut; K is None where the method has its own."""
    scene, splitter = choice.scene, choice.splitter
    with clock.stage("k"):  # Sec. III: how many segments
        n = choice.k(k, weight, cues)
    with clock.stage("weight"):  # Sec. IV: eq. 6-17
        agreed = choice.consensus(k, weight, cues, n)
        lam, curve = (agreed.weight, []) if agreed else choice.weight(weight, cues, n)
    with clock.stage("cut"):  # Sec. III: normalized cut, Nystrom method
        if agreed:
            labels = spread(agreed.labels, choice.draft, scene, features, choice.team)
        else:
            labels = splitter.labels(lam, n)
    with clock.stage("refine"):  # Sec. III: small regions, on grids
        labels = choice.tidied(labels, scene)
    return labels, lam, curve, n if splitter.uses_k and not agreed else None


def _filled(
    labels: NDArray[np.int32], scene: Scene, settings: Preset, fill: bool
) -> NDArray[np.int32]:
    if fill and scene.is_grid and not (labels >= 0).all():
        if settings.fill == "watershed":
            labels = flood_labels(labels, scene.colors)
        else:
            labels = fill_labels(labels, lab_of(scene.colors))
    return label_unseen(labels, scene)  # Sec. VI-A: points that no camera sees
