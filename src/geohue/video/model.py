"""What is carried from frame to frame: landmarks, eigenvectors and centres of the cuts that vote.

The eigenproblems of Sec. III are solved once; the points of later frames are labelled by the
Nystrom extension, which costs their affinities to the landmarks.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.compute.lloyd import nearest_center
from geohue.compute.parallel import Workers
from geohue.errors import GeohueError
from geohue.features import FLOOR, Block, Features, lab_of
from geohue.ncut.labels import find_centers
from geohue.ncut.landmarks import choose_landmarks
from geohue.ncut.nystrom import NystromCut, nystrom_cut, unit_rows
from geohue.scene import Scene
from geohue.settings import Preset

Labels = NDArray[np.int32]
Floats = NDArray[np.floating]
Pose = NDArray[np.float64]

FAR = 2.0
"""A point farther than so many widths of the affinity from all landmarks is new to a model."""


MOST = 1e15
"""Normalised values of a later frame are cut off here, so that float32 holds their squares."""


@dataclass(frozen=True, slots=True, eq=False)
class Scaling:
    """The centre and the mean deviation by which values are normalised (eq. 3, 4).

    Attributes
    ----------
    center : (3,) float64
    size : float
        Infinite where the values do not vary, so that they become zeros.
    """

    center: NDArray[np.float64]
    size: float

    @classmethod
    def of(cls, values: Floats) -> Scaling:
        """Return that of some values, (M, 3)."""
        if len(values) == 0:
            return cls(np.zeros(3), math.inf)
        size = float(values.std(axis=0, dtype=np.float64).mean())
        constant = size <= FLOOR * float(np.abs(values).max())
        return cls(values.mean(axis=0, dtype=np.float64), math.inf if constant else size)

    def __call__(self, values: Floats) -> NDArray[np.float32]:
        """Normalise values, (M, 3)."""
        scaled = (values - self.center) / self.size
        return np.clip(scaled, -MOST, MOST).astype(np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class Cuts:
    """The cuts of one weight.

    Attributes
    ----------
    weight : float
        The paper's lambda.
    cut : NystromCut
        The eigenvectors.
    centers : tuple of (k, k) float64
        Those of each number of segments.
    """

    weight: float
    cut: NystromCut
    centers: tuple[NDArray[np.float64], ...]

    def labels(self, vectors: NDArray[np.float32]) -> list[Labels]:
        """Label points by the Nystrom extension, once for each number of segments.

        The affinities to the landmarks are made once for all.
        """
        entries = self.cut.kernel.project(vectors, self.cut.basis)
        return [nearest_center(unit_rows(entries[:, : len(c)]), c) for c in self.centers]


@dataclass(frozen=True, slots=True, eq=False)
class CarriedModel:
    """Cuts that label the draft of any frame like the one they were made from.

    Attributes
    ----------
    color, place : Scaling
        How Lab and positions are normalised.
    pose : (4, 4) float64 or None
        Camera to world, of the frame that it was made from: positions of other frames are brought
        into its camera where both poses are known.
    cuts : tuple of Cuts
    landmarks : (n, 6) float32
        Normalised, for the test of what is new.
    fused : bool
        Whether geometry took part.
    scale : float
        Width of the affinity.
    """

    color: Scaling
    place: Scaling
    pose: Pose | None
    cuts: tuple[Cuts, ...]
    landmarks: NDArray[np.float32]
    fused: bool
    scale: float

    @classmethod
    def fit(
        cls,
        draft: Scene,
        settings: Preset,
        pose: Pose | None = None,
        seed: int = 0,
        workers: Workers | None = None,
    ) -> CarriedModel:
        """Make the cuts of a draft.

        Parameters
        ----------
        draft : Scene
            A few pixels of a frame (`Scene.thinning`).
        settings : Preset
            Its settings of the cut and of the merging count.
        pose : (4, 4) float64, optional
            Camera to world.
        seed : int
            The source of chance.
        workers : Workers, optional
            Threads to use; by default the calling one.

        Returns
        -------
        CarriedModel

        Raises
        ------
        GeohueError
            If the settings let others than weights vote.
        """
        team, solid = workers or Workers(None), draft.valid.reshape(-1)
        lab, points = lab_of(draft.colors).reshape(-1, 3), draft.points.reshape(-1, 3)
        fused = bool(solid.any())
        rows = solid if fused else np.ones(len(lab), bool)
        color, place = Scaling.of(lab[rows]), Scaling.of(points[solid])
        empty = cls(color, place, pose, (), np.zeros((0, 6), np.float32), fused, settings.cut.scale)
        features = empty.features(draft, pose)
        weights = tuple(w for w in settings.merge.panel if not isinstance(w, str))
        if len(weights) < len(settings.merge.panel):
            raise GeohueError("only weights can vote on a video: leave names out of the panel")
        counts = settings.merge.counts
        chosen = choose_landmarks(
            features.mixed(1.0),
            max(settings.cut.landmarks, 2 * max(counts)),
            settings.cut.landmark_choice,
            np.random.default_rng(seed),
        )

        def fitted(weight: float) -> Cuts:
            return _cuts(features.mixed(weight), chosen, weight, counts, settings, seed)

        cuts = tuple(team.map(fitted, weights if fused else (0.0,)))
        return cls(color, place, pose, cuts, features.mixed(1.0)[chosen], fused, settings.cut.scale)

    def features(self, draft: Scene, pose: Pose | None = None) -> Features:
        """Return the features of a draft in the units of this model.

        A draft without any depth has those of colour alone.
        """
        solid = draft.valid.reshape(-1)
        fused = self.fused and bool(solid.any())
        index = np.flatnonzero(solid) if fused else np.arange(draft.size)
        lab = lab_of(draft.colors).reshape(-1, 3)
        zeros = np.zeros((len(index), 3), np.float32)
        places = Block("geometry", "geometry", zeros, used=False)
        if fused:
            points = draft.points.reshape(-1, 3)[index].astype(np.float64)
            if self.pose is not None and pose is not None:
                way = np.linalg.inv(self.pose) @ pose
                points = points @ way[:3, :3].T + way[:3, 3]
            places = Block("geometry", "geometry", self.place(points))
        blocks = (Block("color", "color", self.color(lab[index])), places)
        return Features(blocks, index, draft.shape, "fusion" if fused else "color")

    def maps(self, features: Features, workers: Workers) -> list[Labels]:
        """Let the cuts vote: their labels in the shape of the draft, -1 where it has no point.

        Where geometry is missing colour votes alone.
        """
        voters = [cuts for cuts in self.cuts if features.is_fused or cuts.weight == 0]
        found = workers.map(lambda cuts: cuts.labels(features.mixed(cuts.weight)), voters)
        return [features.to_scene(labels) for maps in found for labels in maps]

    def strangers(self, features: Features) -> float:
        """Return the share of points that are far from all landmarks, in 0..1.

        Every third point is looked at.
        """
        # The spread is that of an older frame: squares of what it makes huge need float64.
        x = features.mixed(1.0)[::3].astype(np.float64)
        if len(x) == 0 or len(self.landmarks) == 0:
            return 0.0
        squared = (x**2).sum(axis=1)[:, None] + (self.landmarks**2).sum(axis=1)
        nearest = (squared - 2 * x @ self.landmarks.T).min(axis=1)
        return float((nearest > (FAR * self.scale) ** 2).mean())


def _cuts(
    vectors: NDArray[np.float32],
    landmarks: NDArray[np.int64],
    weight: float,
    counts: tuple[int, ...],
    settings: Preset,
    seed: int,
) -> Cuts:
    """The cuts of one weight, as `Cutter.draft_cuts` makes them."""
    own = settings.cut
    cut = nystrom_cut(vectors, vectors[landmarks], Workers(None), max(counts), own.scale)
    sample = vectors[:: -(-len(vectors) // own.center_points)]
    entries = cut.kernel.project(sample, cut.basis)
    centers = tuple(
        find_centers(
            unit_rows(entries[:, :k]),
            k,
            own.labelling,
            np.random.default_rng((seed, 1)),
            restarts=0,
        )
        for k in counts
        if k <= cut.basis.shape[1]
    )
    return Cuts(weight, cut, centers)
