"""The driver: Sections II to IV of the paper and its Appendix, in their order, or the merging."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geohue.compute.labels import relabel
from geohue.compute.parallel import workers
from geohue.consensus import spread
from geohue.features import cues_of
from geohue.fill.gaps import fill_gaps
from geohue.fill.unseen import label_unseen
from geohue.merge.levels import Detail
from geohue.merge.reunite import reunite as reunite_parts
from geohue.ncut.cutter import Cutter
from geohue.prepared import PreparedScene, prepare_scene
from geohue.regions.images import connected_components
from geohue.scene import Scene
from geohue.segmentation.arguments import Count, SegmentArguments, Weight
from geohue.segmentation.choice import Chooser, check_count, shortfalls
from geohue.segmentation.clusterers import make_clusterer
from geohue.segmentation.given import Segmentable, scene_given
from geohue.segmentation.merged import merge_scene
from geohue.segmentation.outcome import Outcome
from geohue.segmentation.result import Progress, Segmentation, StageClock
from geohue.settings import PAPER_METHOD, Preset
from geohue.weight.quality import QualityMetric


def segment(
    scene: Scene | Segmentable,
    k: Count = "auto",
    weight: Weight = "auto",
    preset: str | Preset = "best",
    cues: str = "fusion",
    method: str = PAPER_METHOD,
    seed: int = 0,
    *,
    detail: Detail = "auto",
    components: bool = False,
    reunite: bool = False,
    fill: bool = True,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Segmentation:
    """Split a scene into its parts from colour and geometry together.

    Parameters
    ----------
    scene : Scene
        An RGB-D frame, a stereo pair, a cloud; also a frame of a data set, the path of a cloud or,
        with ``cues="color"``, an image.
    k : int or "auto"
        Number of segments, at least 1; "auto" chooses it, and may choose 1. Where regions are
        merged it takes the level of the tree with so many segments.
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
        What to go by; cues of `geohue.features.register_cue` are added after a plus sign. A scene
        without colours goes by "geometry" where "fusion" is asked for.
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
    reunite : bool
        Whether parts of one surface that something in front of it has cut apart become one segment
        (`geohue.merge.reunite`; frames with depth only).
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
    >>> import numpy as np
    >>> rgb = np.zeros((40, 60, 3), np.uint8)
    >>> rgb[:, 30:] = (200, 60, 40)
    >>> depth = np.where(np.arange(60) < 30, 1.0, 2.0)[None].repeat(40, 0)
    >>> seg = segment(Scene.from_rgbd(rgb, depth), k=2)
    >>> seg.k, seg.labels[0, ::15].tolist()
    (2, [0, 0, 1, 1])
    """
    scene = scene_given(scene, k, cues)
    cues = cues_of(scene, cues)
    asked = SegmentArguments(
        k=k,
        weight=weight,
        preset=preset,
        cues=cues,
        method=method,
        seed=seed,
        detail=detail,
        components=components,
        reunite=reunite,
        fill=fill,
    )
    asked.check_scene(scene)
    clock = StageClock(progress)
    with workers(threads) as team:
        with clock.stage("features"):  # Sec. II: eq. 1-5
            prepared = prepare_scene(scene, asked.settings, cues, seed, team)
            check_count(len(prepared.features), k)
        if asked.merges:  # beyond the paper: many cuts vote, and regions merge on all the evidence
            found = merge_scene(prepared, None if k == "auto" else k, detail, clock)
        else:
            found = _cut(prepared, method, k, weight, clock)
        with clock.stage("quality"):  # eq. 17
            score = QualityMetric(scene)(found.labels)
        with clock.stage("fill"):
            regions = found.regions
            if fill:  # Appendix: pixels without depth, on grids
                regions = fill_gaps(regions, prepared)
            regions = label_unseen(regions, scene)  # Sec. VI-A
            if scene.left_out is not None:
                regions = np.where(scene.left_out, np.int32(-1), regions)
            found = replace(found, regions=regions)
        labels, _ = relabel(connected_components(found.labels) if components else found.labels)
    n_found = int(labels.max()) + 1
    notes = [*scene.warnings, *prepared.features.notes]
    if reunite:
        with clock.stage("reunite"):
            labels = reunite_parts(labels, scene)
    if found.wanted is None and n_found == 1:
        notes += shortfalls(1, 1, components)
    elif found.wanted is not None:
        notes += shortfalls(n_found, found.wanted, components)
    n_named = int(labels.max()) + 1
    if n_named < n_found:
        notes.append(f"{n_found} segments are {n_named} surfaces: parts were reunited")
    return Segmentation(
        labels,
        n_named,
        found.weight,
        score.total if score else None,
        found.curve,
        method,
        preset if isinstance(preset, str) else "custom",
        cues,
        seed,
        clock.timings(),
        tuple(notes),
        found.levels,
        detail if asked.merges and k == "auto" else None,
        scene,
        found.border_votes(labels, prepared.positions),
        asked.merges,
        shares=found.shares,
    )


def _cut(
    prepared: PreparedScene, method: str, k: Count, weight: Weight, clock: StageClock
) -> Outcome:
    """Sections III and IV: K, the weight and the cut, or a compared system."""
    with clock.stage("k"):  # Sec. III: how many segments
        cutter = Cutter(prepared, prepared.settings.cut.k_max if k == "auto" else k)
        splitter = make_clusterer(method, cutter, prepared)
        chooser = Chooser(prepared, splitter, cutter)
        n = chooser.k(k, weight)
    with clock.stage("weight"):  # Sec. IV: eq. 6-17
        agreed = chooser.consensus(k, weight, n)
        lam, curve = (agreed.weight, []) if agreed else chooser.weight(weight, n)
    with clock.stage("cut"):  # Sec. III: normalized cut, Nystrom method
        labels = spread(agreed.labels, prepared) if agreed else splitter.labels(lam, n)
    with clock.stage("refine"):  # Sec. III: small regions, on grids
        labels = chooser.tidied(labels, prepared.scene)
    wanted = n if splitter.uses_k and not agreed else None
    return Outcome(labels, lam, curve, wanted, consensus=agreed)
