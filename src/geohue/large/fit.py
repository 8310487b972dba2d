"""Sec. II to IV on the sample: the number of segments, the weight, and the cut."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.compute.labels import relabel
from geohue.compute.parallel import Workers
from geohue.features import Raw
from geohue.large.moments import Moments
from geohue.large.vectors import Standard, raw_values
from geohue.ncut.cutter import Cutter
from geohue.ncut.model import CutModel
from geohue.prepared import PreparedScene
from geohue.scene import Scene
from geohue.segmentation.arguments import Count, Weight
from geohue.segmentation.choice import Chooser, check_count
from geohue.segmentation.result import StageClock
from geohue.settings import Preset
from geohue.weight.quality import QualityMetric
from geohue.weight.search import Curve


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """What labels any point of a cloud.

    Attributes
    ----------
    standard : Standard
        What its values are normalised by.
    model : CutModel
        The cut.
    weight : float
        The paper's lambda.
    order : (k,) int32
        The number that each segment of the cut receives.
    """

    standard: Standard
    model: CutModel
    weight: float
    order: NDArray[np.int32]

    def labels(self, xyz: NDArray[np.float64], rgb: NDArray[np.uint8]) -> NDArray[np.int32]:
        """Label points, (M, 3) coordinates and colours; -1 for those without coordinates."""
        known, values = raw_values(xyz, rgb, self.standard.cues)
        if not known.any():
            return np.full(len(xyz), -1, np.int32)
        features = self.standard.features(values, known)
        found = self.model.labels(features.mixed(self.weight), Workers(None))
        return features.to_scene(self.order[found])


@dataclass(frozen=True, slots=True, eq=False)
class Decision:
    """What was decided on the sample.

    Attributes
    ----------
    k : int
        Number of segments wanted.
    weight : float
        The paper's lambda.
    quality : float or None
        Q of the sample's segmentation.
    curve : list of (float, float)
        Each weight tried and its Q.
    notes : tuple of str
        What the user should know.
    """

    k: int
    weight: float
    quality: float | None
    curve: Curve
    notes: tuple[str, ...]


def fit(
    scene: Scene,
    xyz: NDArray[np.float64],
    moments: Moments,
    k: Count,
    weight: Weight,
    settings: Preset,
    cues: str,
    seed: int,
    team: Workers,
    clock: StageClock,
) -> tuple[Fitted, Decision]:
    """Decide on the sample, and fit the cut that labels the cloud.

    Parameters
    ----------
    scene : Scene
        The sample.
    xyz : (M, 3) float64
        Its coordinates as in the file.
    moments : Moments
        Of the `raw_values` of the whole cloud.
    k, weight, cues, seed
        As for `geohue.segment`.
    settings : Preset
        The settings.
    team : Workers
        Threads to use.
    clock : StageClock
        Times the stages.

    Returns
    -------
    Fitted, Decision

    Raises
    ------
    GeohueError
        If the sample has fewer points than segments.
    """
    standard = Standard.of(moments, cues)
    known, values = raw_values(xyz, scene.colors, cues)
    features = standard.features(values, known)
    check_count(len(features), k)
    prepared = PreparedScene.of(Raw(scene), features, settings, seed, team)
    cutter = Cutter(prepared, settings.cut.k_max if k == "auto" else k)
    chooser = Chooser(prepared, cutter, cutter)
    with clock.stage("k"):
        n = chooser.k(k, weight)
    with clock.stage("weight"):
        lam, curve = chooser.weight(weight, n)
    with clock.stage("cut"):
        model = cutter.model(lam, n)
    found = model.labels(features.mixed(lam), team)
    order = _by_size(features.to_scene(found), model.k)
    fitted = Fitted(standard, model, lam, order)
    score = QualityMetric(scene)(features.to_scene(order[found]))
    return fitted, Decision(n, lam, score.total if score else None, curve, features.notes)


def _by_size(labels: NDArray[np.int32], k: int) -> NDArray[np.int32]:
    """Number the segments by their size in the sample, those without a point there last."""
    _, present = relabel(labels)
    absent = np.setdiff1d(np.arange(k, dtype=np.int32), present)
    order = np.empty(k, np.int32)
    order[np.concatenate([present, absent])] = np.arange(k)
    return order
