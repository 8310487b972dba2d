"""Normalized cuts of one scene for any weight and any number of segments."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from geohue.compute.arrays import Floats
from geohue.compute.lloyd import nearest_center
from geohue.compute.parallel import Workers
from geohue.ncut.labels import find_centers
from geohue.ncut.landmarks import choose_landmarks
from geohue.ncut.model import CutModel
from geohue.ncut.nystrom import nystrom_cut, unit_rows
from geohue.ncut.selectors import choose_k
from geohue.prepared import PreparedScene


class Cutter:
    """Cuts a scene again and again, with what can be shared between the cuts shared.

    The landmarks, the draft (the few points on which K and the weight are chosen) and the chance
    of k-means are the same for every weight: two weights that differ little give labels that
    differ little, and Q(lambda) is a curve rather than noise.

    Parameters
    ----------
    prepared : PreparedScene
        The scene, its draft and the settings.
    n_segments : int
        Most segments that will be asked for; there are at least twice as many landmarks.
    """

    uses_weight = True
    uses_k = True
    prunes = False

    def __init__(self, prepared: PreparedScene, n_segments: int) -> None:
        self._features, self._draft = prepared.features, prepared.draft_features
        self._settings = settings = prepared.settings.cut
        self._workers = prepared.workers
        self._seed = prepared.seed
        # In the balanced mix, so that the same points serve for every weight.
        self._landmarks = choose_landmarks(
            self._draft.mixed(1.0),
            max(settings.landmarks, 2 * n_segments),
            settings.landmark_choice,
            np.random.default_rng(self._seed),
        )

    def choose_k(self, weight: float) -> int:
        """Choose the number of segments with the preset's selector, on the draft.

        The answer 1 is asked for twice, the second time with k-means landmarks: landmarks drawn
        at random can miss a small object, and the scene then looks like one piece.
        """
        vectors = self._draft.mixed(weight)
        k = self._choose_k(vectors, vectors[self._landmarks])
        if k > 1 or len(self._landmarks) == len(vectors):
            return k
        rng = np.random.default_rng((self._seed, 2))
        return self._choose_k(
            vectors, vectors[choose_landmarks(vectors, len(self._landmarks), "kmeans", rng)]
        )

    def _choose_k(self, vectors: Floats, landmarks: Floats) -> int:
        most, scale = self._settings.k_max, self._settings.scale
        cut = nystrom_cut(vectors, landmarks, self._workers, most + 1, scale)
        return choose_k(cut, self._sample(vectors), self._settings.selector, most)

    def draft_labels(self, weight: float, k: int) -> NDArray[np.int32]:
        """Cut the draft; returns labels in the draft's shape, -1 where it has no point."""
        draft = self._draft.mixed(weight)
        return self._draft.to_scene(self._labels(draft, draft, k, Workers(None)))

    def draft_cuts(self, weight: float, counts: Sequence[int]) -> list[NDArray[np.int32]]:
        """Cut the draft into several numbers of segments, with the eigenvectors made once.

        K-means is not restarted: one poor cut among many does no harm. Numbers above the
        directions that the points span are left out: they would repeat the last cut.
        """
        draft, settings = self._draft.mixed(weight), self._settings
        landmarks = draft[self._landmarks]
        cut = nystrom_cut(draft, landmarks, Workers(None), max(counts), settings.scale)
        entries = cut.kernel.project(draft, cut.basis)
        cuts = []
        for k in counts:
            if k > cut.basis.shape[1]:
                break
            rows = unit_rows(entries[:, :k])
            rng = np.random.default_rng((self._seed, 1))
            centers = find_centers(self._sample(rows), k, settings.labelling, rng, restarts=0)
            cuts.append(self._draft.to_scene(nearest_center(rows, centers)))
        return cuts

    def labels(self, weight: float, k: int) -> NDArray[np.int32]:
        """Cut the scene; returns labels in its shape, -1 where it has no point."""
        draft, vectors = self._draft.mixed(weight), self._features.mixed(weight)
        return self._features.to_scene(self._labels(draft, vectors, k, self._workers))

    def model(self, weight: float, k: int) -> CutModel:
        """Fit the cut of the scene; it labels these and other points."""
        draft, vectors = self._draft.mixed(weight), self._features.mixed(weight)
        return self._model(draft, vectors, k, self._workers)

    def _labels(
        self, draft: Floats, vectors: Floats, k: int, workers: Workers
    ) -> NDArray[np.int32]:
        if k == 1:
            return np.zeros(len(vectors), np.int32)
        return self._model(draft, vectors, k, workers).labels(vectors, workers)

    def _model(self, draft: Floats, vectors: Floats, k: int, workers: Workers) -> CutModel:
        settings = self._settings
        fitted = draft if settings.fit == "draft" else vectors
        cut = nystrom_cut(fitted, draft[self._landmarks], workers, k, settings.scale)
        k = min(k, cut.basis.shape[1])  # coinciding points span fewer directions
        rng = np.random.default_rng((self._seed, 1))
        rows = cut.rows(self._sample(draft), k)
        return CutModel(cut, find_centers(rows, k, settings.labelling, rng, settings.restarts))

    def _sample(self, vectors: Floats) -> Floats:
        """Every n-th row, so that there are no more than the settings say."""
        return vectors[:: -(-len(vectors) // self._settings.center_points)]
