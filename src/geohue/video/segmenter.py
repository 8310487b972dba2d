"""Frames of a sequence, one after the other, with labels that stay with their things."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass
from types import TracebackType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geohue.compute.labels import relabel
from geohue.compute.parallel import workers
from geohue.consensus.votes import count_votes
from geohue.errors import GeohueError
from geohue.features import Features, lab_of
from geohue.merge.draft import merge_draft
from geohue.merge.levels import Detail, threshold_of
from geohue.regions.graph import PairGraph
from geohue.scene import Scene
from geohue.segmentation.arguments import SegmentArguments
from geohue.segmentation.result import Segmentation, StageClock
from geohue.settings import PAPER_METHOD, Preset
from geohue.settings.checks import is_whole
from geohue.video.borders import carry_borders
from geohue.video.change import CUT, Fit, Look, explained_votes
from geohue.video.held import held_level
from geohue.video.keeper import DELAY, ModelKeeper, chosen_cut
from geohue.video.model import CarriedModel
from geohue.video.motion import agreeing, reprojected, resized
from geohue.video.past import contingency, past_votes
from geohue.video.tracks import MEMORY, Sighting, Track, Tracker, sightings
from geohue.weight.quality import QualityMetric

Labels = NDArray[np.int32]
Pose = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class _View:
    """A frame with its draft."""

    scene: Scene
    positions: NDArray[np.int64]
    draft: Scene
    pose: Pose | None
    look: Look


@dataclass(frozen=True, slots=True, eq=False)
class _Last:
    """The last frame, and the identities on its draft."""

    labels: Labels
    view: _View


class VideoSegmenter:
    """Splits the frames of a sequence such that the same thing keeps the same label.

    The first frame is split as `geohue.segment` does. Landmarks, eigenvectors and centres of its
    cuts are carried on: they label the draft of each further frame, whose regions are then merged
    on all the evidence. What is not clear-cut stays as it was in the last frame. Segments get the
    identities of those before by overlap, colour and place (`geohue.video.tracks`), also those
    that were hidden for a while. Where the model no longer fits (`geohue.video.change`) it is made
    anew in the background and takes over a few frames later.

    Parameters
    ----------
    preset : {"best", "fast", "paper"} or Preset
        As for `geohue.segment`. "paper" chooses K and lambda on the first frame and carries both.
    detail : float, "auto", "coarse" or "fine"
        As for `geohue.segment`.
    seed : int
        The source of chance. The same frames, seed and version give the same labels.
    threads : int, optional
        How many; by default one a core. The labels do not depend on it.
    memory : int
        Frames for which a thing that is not seen keeps its identity.
    delay : int
        Frames from the test that asks for a new model to its use.
    live : bool
        Take a new model as soon as it is there, and never wait for it: for cameras. The labels
        then depend on the speed of the machine.

    Raises
    ------
    GeohueError
        For settings that cannot be.

    Examples
    --------
    >>> from geohue.simulate.moving import moving_scene
    >>> from geohue import Intrinsics
    >>> with VideoSegmenter("fast") as video:
    ...     for frame in moving_scene(2, Intrinsics(66.0, 66.0, 39.5, 29.5, 80, 60)):
    ...         seg = video.update(frame.scene, frame.pose)
    >>> seg.labels.shape, seg.k == len(video.seen)
    ((60, 80), True)
    """

    def __init__(
        self,
        preset: str | Preset = "best",
        *,
        detail: Detail = "auto",
        seed: int = 0,
        threads: int | None = None,
        memory: int = MEMORY,
        delay: int = DELAY,
        live: bool = False,
    ) -> None:
        self._name = preset if isinstance(preset, str) else "custom"
        arguments = SegmentArguments(preset=preset, seed=seed, detail=detail)
        self._settings, self._merges = arguments.settings, arguments.merges
        self._detail, self._threshold = detail, threshold_of(detail)
        for name, value in (("memory", memory), ("delay", delay)):
            if not is_whole(value) or value < 0:
                raise GeohueError(f"{name} is {value!r}: expected a whole number of at least 0")
        self._seed = seed
        self.tracker = Tracker(memory)
        self.seen: list[Sighting] = []
        self.frame = 0
        self._last: _Last | None = None
        self._weight = math.nan
        self._open = ExitStack()
        self._team = self._open.enter_context(workers(threads))
        behind = self._open.enter_context(ThreadPoolExecutor(1))
        self._keeper = ModelKeeper(behind, seed, delay, live)

    def __enter__(self) -> VideoSegmenter:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the threads. While it is open, BLAS uses one thread, as labels must not depend on it.

        Safe to call twice.
        """
        self._open.close()

    @property
    def models(self) -> list[tuple[int, str]]:
        """The frames in which a model was asked for, and why.

        "first", "cut" (another shot: the frame waits for it, and all identities end), "new" (a
        thing unlike all landmarks), "votes" (the segments no longer explain the cuts' votes) or
        "depth" (there is depth again);
        "resume" in the last frame of a run that is gone on with.
        """
        return self._keeper.models

    def update(
        self, scene: Scene, pose: ArrayLike | None = None, frame: int | None = None
    ) -> Segmentation:
        """Split the next frame.

        Parameters
        ----------
        scene : Scene
            A frame on a grid. Its size may change from frame to frame, and its depth may be missing
            for a while.
        pose : (4, 4) float, optional
            Camera to world. Where two frames have one, the labels of the first are carried along
            the motion of the camera, and places are those in the world.
        frame : int, optional
            Its number, where frames before it are missing; by default the next one.

        Returns
        -------
        Segmentation
            Its `labels` are identities: whole numbers from 0 that stay with their things, not all
            of which are seen in each frame; each pixel has one. `k` is the number of segments of
            this frame. `quality` is that of the draft, `levels` is None.

        Raises
        ------
        GeohueError
            For a cloud without a grid, a pose of another shape or not finite, or a number of a
            frame that is not after the last one's.
        """
        if frame is not None and frame < self.frame:
            raise GeohueError(f"frame is {frame}: the next one is {self.frame} or later")
        self.frame = self.frame if frame is None else frame
        if not scene.is_grid or scene.size == 0:
            raise GeohueError("a video needs frames on a grid of pixels: this scene is a cloud")
        clock = StageClock()
        with clock.stage("features"):
            now = self._view(scene, _checked(pose))
            model = self._model(now)
            features = model.features(now.draft, now.pose)
            graph = self._graph(now.draft, features)
        with clock.stage("cuts"):
            maps = list(self._team.map(graph.tidied, model.maps(features, self._team)))
        with clock.stage("merge"):
            before = self._before(now)
            segments = self._segments(graph, features, maps, before)
        with clock.stage("tracks"):
            ids = self._identify(segments, before, now)
            fit = _fit_of(model, features, graph, maps, segments, now.draft)
            self._keeper.watch(self.frame, fit, now.draft, now.pose, self._settings)
        with clock.stage("borders"):
            labels = carry_borders(ids, now.positions, scene, self._team)
        with clock.stage("quality"):
            score = QualityMetric(now.draft)(ids) if features.uses("geometry") else None
        self._last = _Last(ids, now)
        self.frame += 1
        return Segmentation(
            labels,
            len(self.seen),
            self._weight,
            score.total if score else None,
            [],
            PAPER_METHOD,
            self._name,
            features.cues,
            self._seed,
            clock.timings(),
            scene.warnings,
            None,
            self._detail if self._merges else None,
            scene,
            merged=self._merges,
        )

    def resume(
        self,
        scene: Scene,
        labels: Labels,
        tracks: dict[int, Track],
        frame: int,
        pose: ArrayLike | None = None,
    ) -> None:
        """Go on after a frame that another segmenter has split, with its identities.

        Parameters
        ----------
        scene : Scene
            The last frame that was split; a model is made from it.
        labels : (H, W) int32
            Its identities.
        tracks : dict of int to Track
            Each track as it was last seen.
        frame : int
            The number of the frame.
        pose : (4, 4) float, optional
            Camera to world.

        Raises
        ------
        GeohueError
            If the labels are not as the frame, or the preset chooses a cut of its own.
        """
        if labels.shape != scene.shape:
            raise GeohueError(f"labels have shape {labels.shape}, the frame {scene.shape}")
        if not self._merges:
            raise GeohueError("only presets that merge regions can be resumed: best or fast")
        now = self._view(scene, _checked(pose))
        self.frame = frame
        following = max(tracks, default=-1) + 1
        self.tracker.restore(tracks, following)
        self._keeper.begin(frame, "resume", now.draft, now.pose, self._settings, self._team)
        self._last = _Last(labels.reshape(-1)[now.positions], now)
        self.frame = frame + 1

    def _view(self, scene: Scene, pose: Pose | None) -> _View:
        positions = scene.thinning(self._settings.draft_points, np.random.default_rng(0))
        draft = scene.take(positions)
        return _View(scene, positions, draft, pose, Look.of(draft))

    def _model(self, now: _View) -> CarriedModel:
        """The model for this frame; at the beginning and after a cut it is made on the spot."""
        why = "first" if self._keeper.model is None else None
        if self._last is not None and self._last.view.look.change(now.look) > CUT:
            why, self._last = "cut", None
            self.tracker.forget()
        if why is None:
            return self._keeper.current(self.frame)
        if not self._merges and why == "first":
            self._settings, self._weight = chosen_cut(now.scene, self._settings, self._seed)
        return self._keeper.begin(self.frame, why, now.draft, now.pose, self._settings, self._team)

    def _graph(self, draft: Scene, features: Features) -> PairGraph:
        own, everywhere = self._settings, not features.uses("geometry")
        return PairGraph.of(draft, own.min_region, own.consensus.smallest, everywhere)

    def _before(self, now: _View) -> Labels:
        """The identities of the last frame where they lie in this draft, -1 where unknown."""
        shape = now.positions.shape
        if self._last is None:
            return np.full(shape, -1, np.int32)
        last, camera = self._last.view, now.scene.intrinsics
        if last.pose is None or now.pose is None or camera is None or not last.draft.valid.any():
            labels = resized(self._last.labels, shape)
            expected = resized(last.draft.points[..., 2].astype(np.float64), shape)
        else:
            way = np.linalg.inv(now.pose) @ last.pose
            labels, expected = reprojected(
                self._last.labels, last.draft.points, way, camera, now.positions, now.scene.shape
            )
        return agreeing(labels, expected, now.draft.points[..., 2])

    def _segments(
        self, graph: PairGraph, features: Features, maps: list[Labels], before: Labels
    ) -> Labels:
        """The segments of the draft, 0..K-1."""
        if not self._merges and maps:  # the paper's cut
            return np.asarray(relabel(maps[0])[0])
        regions, tree = merge_draft(graph, features, [*maps, *past_votes(before, len(maps))])
        names = {track: i for i, track in enumerate(self.tracker.tracks)}
        shares = contingency(regions, before, tree.n_regions, names)
        return held_level(tree, shares, self._threshold)[regions]

    def _identify(self, segments: Labels, before: Labels, now: _View) -> Labels:
        """Give segments the identities of their tracks."""
        points = now.draft.points.astype(np.float64)
        if now.pose is not None:
            points = points @ now.pose[:3, :3].T + now.pose[:3, 3]
        scale = now.scene.size / now.draft.size
        found = sightings(segments, lab_of(now.draft.colors), points, self.frame, scale)
        names = {track: i for i, track in enumerate(self.tracker.tracks)}
        shared = contingency(segments, before, len(found), names).T
        sizes = shared.sum(axis=1)[:, None] + shared.sum(axis=0)
        overlap = shared / np.maximum(sizes - shared, 1)
        self.seen = self.tracker.identify(found, overlap)
        return np.array([one.track for one in self.seen], np.int32)[segments]


def _fit_of(
    model: CarriedModel,
    features: Features,
    graph: PairGraph,
    maps: list[Labels],
    segments: Labels,
    draft: Scene,
) -> Fit:
    flat = segments.reshape(-1)
    share = count_votes(maps, graph.one, graph.other)
    explained = explained_votes(share, flat[graph.one] != flat[graph.other])
    return Fit(
        model.strangers(features), explained, not model.fused and bool(draft.valid.mean() > 0.1)
    )


def _checked(pose: ArrayLike | None) -> Pose | None:
    if pose is None:
        return None
    matrix = np.asarray(pose)
    if matrix.shape != (4, 4) or not np.issubdtype(matrix.dtype, np.number):
        raise GeohueError(f"pose has shape {matrix.shape}: expected (4, 4) numbers")
    with np.errstate(all="ignore"):
        volume = abs(np.linalg.det(matrix[:3, :3].astype(np.float64)))
    if not (np.isfinite(matrix).all() and 1e-6 <= volume <= 1e6):
        raise GeohueError("pose is not finite or does not keep the size of things: leave it out")
    return matrix.astype(np.float64)
