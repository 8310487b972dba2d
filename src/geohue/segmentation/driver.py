"""The driver: Sections II to IV of the paper and its Appendix, in their order."""

from __future__ import annotations

from geohue.compute.labels import relabel
from geohue.compute.parallel import workers
from geohue.consensus import spread
from geohue.errors import GeohueError
from geohue.fill.gaps import fill_gaps
from geohue.fill.unseen import label_unseen
from geohue.ncut.cutter import Cutter
from geohue.prepared import prepare_scene
from geohue.regions.images import connected_components
from geohue.scene import Scene
from geohue.segmentation.choice import (
    Chooser,
    Count,
    Weight,
    check_arguments,
    check_count,
    shortfalls,
)
from geohue.segmentation.clusterers import check_method, make_clusterer
from geohue.segmentation.result import Progress, Segmentation, StageClock
from geohue.settings import PAPER_METHOD, Preset, preset_named
from geohue.weight.quality import QualityMetric


def segment(
    scene: Scene,
    k: Count = "auto",
    weight: Weight = "auto",
    preset: str | Preset = "paper",
    cues: str = "fusion",
    method: str = PAPER_METHOD,
    seed: int = 0,
    *,
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
        Number of segments, 1 to 255; "auto" chooses it (`choose_k`, or what the consensus comes
        to), and may choose 1.
    weight : float, "auto", "quality", "agreement" or "consensus"
        The paper's lambda, the weight of geometry against colour, 0 to infinity. "quality" takes
        the one with the highest Q, as the paper does, "agreement" that of `weight_by_agreement`;
        "consensus" chooses neither a weight nor `k`, but keeps the borders that cuts of several
        weights and numbers of segments share (`find_consensus`). "auto" leaves the choice of
        these to the preset. Of no effect unless `cues` is "fusion".
    preset : {"paper", "fast", "best"} or Preset
        The settings.
    cues : {"fusion", "color", "geometry"}
        What to go by; cues of `geohue.features.register_cue` are added after a plus sign.
    method : str
        "nncsc", the paper's normalized cut, or a compared system of `geohue.baselines`: kmeans,
        meanshift, felzenszwalb, edison, bleiweiss-werman, calderero-marques. Some of these find
        their own number of segments, or have weights of their own.
    seed : int
        The source of chance, not negative: the same scene, seed and version give the same
        labels.
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
    >>> import numpy as np
    >>> rgb = np.zeros((40, 60, 3), np.uint8)
    >>> rgb[:, 30:] = (200, 60, 40)
    >>> depth = np.where(np.arange(60) < 30, 1.0, 2.0)[None].repeat(40, 0)
    >>> seg = segment(Scene.from_rgbd(rgb, depth), k=2)
    >>> seg.k, seg.labels[0, ::15].tolist()
    (2, [0, 0, 1, 1])
    """
    settings, clock = preset_named(preset), StageClock(progress)
    check_arguments(k, weight, seed, method)
    if components and not scene.is_grid:
        raise GeohueError("components need a grid of pixels: this scene is a cloud without one")
    check_method(method, cues, scene.is_grid)
    with workers(threads) as team:
        with clock.stage("features"):  # Sec. II: eq. 1-5
            prepared = prepare_scene(scene, settings, cues, seed, team)
            check_count(len(prepared.features), k)
            cutter = Cutter(prepared, settings.cut.k_max if k == "auto" else k)
            splitter = make_clusterer(method, cutter, prepared)
            chooser = Chooser(prepared, splitter, cutter)
        with clock.stage("k"):  # Sec. III: how many segments
            n = chooser.k(k, weight)
        with clock.stage("weight"):  # Sec. IV: eq. 6-17
            agreed = chooser.consensus(k, weight, n)
            lam, curve = (agreed.weight, []) if agreed else chooser.weight(weight, n)
        with clock.stage("cut"):  # Sec. III: normalized cut, Nystrom method
            labels = spread(agreed.labels, prepared) if agreed else splitter.labels(lam, n)
        with clock.stage("refine"):  # Sec. III: small regions, on grids
            labels = chooser.tidied(labels, scene)
        with clock.stage("quality"):  # eq. 17
            score = QualityMetric(scene)(labels)
        with clock.stage("fill"):  # Appendix: pixels without depth, on grids
            if fill:
                labels = fill_gaps(labels, prepared)
            labels = label_unseen(labels, scene)  # Sec. VI-A: points that no camera sees
        if components:
            labels = connected_components(labels)
        labels, _ = relabel(labels)
    found = int(labels.max()) + 1
    notes = [*scene.warnings, *prepared.features.notes]
    if splitter.uses_k:
        notes += shortfalls(found, found if agreed else n, components)
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
    )
