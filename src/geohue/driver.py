"""The driver: Sections II to IV of the paper and its Appendix, in their order."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from geohue.clusterers import Clusterer, check_method, make_clusterer
from geohue.errors import GeohueError
from geohue.features import Cues, extract_features, lab_of
from geohue.fill import fill_labels
from geohue.ncut.cutter import Cutter
from geohue.parallel import Workers, workers
from geohue.presets import WEIGHT_RULES, Preset, WeightRule, preset_named
from geohue.regions import connected_components, merge_small_regions, relabel
from geohue.scene import Scene
from geohue.segmentation import Progress, Segmentation, StageClock
from geohue.sensors.unseen import label_unseen
from geohue.weight.agreement import HALF_OCTAVES, weight_by_agreement
from geohue.weight.quality import QualityMetric
from geohue.weight.search import Curve, search_weight

K_LIMIT = 255
"""Most segments that may be asked for."""

Weight = float | Literal["auto"] | WeightRule


def segment(
    scene: Scene,
    k: int | Literal["auto"] = "auto",
    weight: Weight = "auto",
    preset: str | Preset = "paper",
    cues: Cues = "fusion",
    method: str = "nncsc",
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
        Number of segments, 1 to 255; "auto" chooses it (`choose_k`), and may choose 1.
    weight : float, "auto", "quality" or "agreement"
        The paper's lambda, the weight of geometry against colour, 0 to infinity. "quality" takes
        the one with the highest Q, as the paper does, "agreement" that of `weight_by_agreement`;
        "auto" leaves the choice of these two to the preset. Of no effect unless `cues` is
        "fusion".
    preset : {"paper", "fast", "best"} or Preset
        The settings.
    cues : {"fusion", "color", "geometry"}
        What to go by.
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
    >>> rgb = np.zeros((40, 60, 3), np.uint8)
    >>> rgb[:, 30:] = (200, 60, 40)
    >>> depth = np.where(np.arange(60) < 30, 1.0, 2.0)[None].repeat(40, 0)
    >>> seg = segment(Scene.from_rgbd(rgb, depth), k=2)
    >>> seg.k, seg.labels[0, ::15].tolist()
    (2, [0, 0, 1, 1])
    """
    settings, clock = preset_named(preset), StageClock(progress)
    check_arguments(k, weight, seed)
    if components and not scene.is_grid:
        raise GeohueError("components need a grid of pixels: this scene is a cloud without one")
    check_method(method, cues, scene.is_grid)
    notes = list(scene.warnings)
    with workers(threads) as team:
        with clock.stage("features"):  # Sec. II: eq. 1-5
            features = extract_features(scene, cues)
            notes += features.notes
            draft = scene.thinning(settings.draft_points, np.random.default_rng(seed))
            most = settings.k_max if k == "auto" else k
            check_count(len(features), k)
            cutter = Cutter(features, draft, settings, team, seed, most)
            splitter = make_clusterer(method, cutter, scene, features, draft, team, seed)
        n, lam, curve = choose_k_and_weight(
            splitter, cutter, scene, draft, k, weight, cues, settings, team, clock
        )
        with clock.stage("cut"):  # Sec. III: normalized cut, Nystrom method
            labels = splitter.labels(lam, n)
        with clock.stage("refine"):  # Sec. III: small regions, on grids
            labels = _refined(labels, scene, settings, splitter)
        with clock.stage("quality"):  # eq. 17
            score = QualityMetric(scene)(labels)
        with clock.stage("fill"):  # Appendix: pixels without depth, on grids
            if fill and scene.is_grid and not (labels >= 0).all():
                labels = fill_labels(labels, lab_of(scene.colors))
            labels = label_unseen(labels, scene)  # Sec. VI-A: points that no camera sees
        if components:
            labels = connected_components(labels)
        labels, _ = relabel(labels)
    found = int(labels.max()) + 1
    notes += shortfalls(found, n, components) if splitter.uses_k else []
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


def check_arguments(k: int | Literal["auto"], weight: Weight, seed: int) -> None:
    """Raise `GeohueError` unless these are as `segment` takes them."""
    if k != "auto" and not (_is_whole(k) and 1 <= k <= K_LIMIT):
        raise GeohueError(f'k is {k!r}: expected "auto" or a whole number from 1 to {K_LIMIT}')
    named = ("auto", *WEIGHT_RULES)
    if weight not in named and not (isinstance(weight, int | float | np.number) and weight >= 0):
        raise GeohueError(f"weight is {weight!r}: expected {', '.join(named)}, or at least 0")
    if not (_is_whole(seed) and seed >= 0):
        raise GeohueError(f"seed is {seed!r}: expected a whole number of at least 0")


def choose_k_and_weight(
    splitter: Clusterer,
    cutter: Cutter,
    scene: Scene,
    draft: NDArray[np.int64],
    k: int | Literal["auto"],
    weight: Weight,
    cues: Cues,
    settings: Preset,
    team: Workers,
    clock: StageClock,
) -> tuple[int, float, Curve]:
    """Return the number of segments, the weight and the curve of Q, chosen where not given."""
    fixed = _fixed_weight(weight, cues, splitter)
    with clock.stage("k"):  # Sec. III: how many segments
        n = cutter.choose_k(_or_balanced(fixed)) if k == "auto" else k
    with clock.stage("weight"):  # Sec. IV: eq. 6-17
        rule = settings.weight_rule if weight == "auto" else weight
        lam, curve = _search(fixed, rule, splitter, scene, draft, n, settings, team)
    return n, lam, curve


def _is_whole(value: object) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool)


def check_count(n_points: int, k: int | Literal["auto"]) -> None:
    """Raise `GeohueError` if there are fewer points than segments."""
    if k != "auto" and n_points < k:
        raise GeohueError(f"{n_points} usable point(s) cannot form {k} segments: lower k")


def _fixed_weight(weight: Weight, cues: Cues, splitter: Clusterer) -> float | None:
    """Return the weight if it need not be searched."""
    if cues == "fusion":
        if not splitter.uses_weight:
            return math.nan
        return None if isinstance(weight, str) else float(weight)
    return 0.0 if cues == "color" else math.inf


def _or_balanced(weight: float | None) -> float:
    """Return the weight if there is one, else 1."""
    return 1.0 if weight is None or math.isnan(weight) else weight


def _search(
    fixed: float | None,
    rule: float | str,
    splitter: Clusterer,
    scene: Scene,
    draft: NDArray[np.int64],
    k: int,
    settings: Preset,
    team: Workers,
) -> tuple[float, Curve]:
    """Choose the weight on the draft, unless it is fixed; returns it and the curve of Q."""
    if fixed is not None:
        return fixed, []
    if k == 1 and splitter.uses_k:
        return 1.0, []
    small = scene.take(draft)
    metric = QualityMetric(small)

    def split(weight: float) -> NDArray[np.int32]:
        return _refined(splitter.draft_labels(weight, k), small, settings, splitter)

    def score(labels: NDArray[np.int32]) -> float | None:
        quality = metric(labels)
        return quality.total if quality else None

    if rule == "quality":
        return search_weight(
            lambda weight: score(split(weight)), team, settings.weights, settings.refinements
        )
    best, maps = weight_by_agreement(split, small, team)
    values = zip(HALF_OCTAVES, map(score, maps), strict=True)
    return best, [(weight, value) for weight, value in values if value is not None]


def _refined(
    labels: NDArray[np.int32], scene: Scene, settings: Preset, splitter: Clusterer
) -> NDArray[np.int32]:
    if splitter.prunes or not scene.is_grid:
        return labels
    return merge_small_regions(labels, max(1, round(settings.min_region * scene.size)))


def shortfalls(found: int, wanted: int, components: bool) -> list[str]:
    """Return what the user should know where there are fewer segments than wanted."""
    if wanted == 1:
        return ["one segment: nothing to split, and no weight to choose; k=2 or more splits it"]
    if found < wanted and not components:
        return [f"{found} segment(s) instead of {wanted}: the others were empty or too small"]
    return []
