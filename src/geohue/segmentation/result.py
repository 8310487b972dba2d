"""What `segment` returns."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geohue._version import __version__
from geohue.compute.labels import relabel
from geohue.errors import GeohueError
from geohue.merge.levels import Detail, Levels
from geohue.merge.shares import BorderShares
from geohue.scene import Scene
from geohue.segmentation.words import told, weight_in_words
from geohue.weight.search import Curve

if TYPE_CHECKING:
    from geohue.objects import Editing, Neighbours, Segment, Segments

SUMMARY_DETAILS = (-2.0, -1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0)
"""Degrees of detail whose numbers of segments the summary states."""

Progress = Callable[[str], None]
"""Called with the name of each stage as it begins."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Segmentation:
    """The segments of a scene, and how they were found.

    Attributes
    ----------
    labels : (H, W) or (N,) int32
        Segment of each pixel or point, 0 (the largest) to k - 1; -1 where there is none.
    k : int
        Number of segments.
    weight : float
        The paper's lambda that was used; after a consensus or a merging, that of the voter whose
        maps are most like the result. 0 for colour alone, infinity for geometry alone, NaN where
        there is none.
    quality : float or None
        Q of eq. 17 for `labels`; None with fewer than two segments or without geometry.
    weight_curve : list of (float, float)
        Each weight tried and its Q on the draft, in increasing order; empty if none was searched.
    method, preset, cues, seed
        As given; the preset is "custom" for settings of one's own.
    timings : dict of str to float
        Seconds for each stage and in all (``total``).
    warnings : tuple of str
        What the user should know of the input or the result.
    levels : Levels or None
        Nested segmentations, finer and coarser than `labels`, where regions were merged; None for
        the paper's cut and the compared systems.
    detail : float, str or None
        How fine the level is that `labels` are; None without levels, and where `k` was given.
    scene : Scene or None
        What was segmented, for `save`, `overlay` and `segments`; None for a result that was loaded.
    border_votes : sequence of (int, int, float)
        With weight "consensus", two segments that touch and the share of the cuts that draw the
        border between them, 0 to 1. Empty where no cuts voted on the segments.
    merged : bool
        Whether regions were merged, also where the levels were not kept (`save` with `lean`).
    shares : BorderShares or None
        The share of the votes along each border of `levels`' regions, where cuts voted; None for
        a result that was loaded.
    """

    labels: NDArray[np.int32]
    k: int
    weight: float
    quality: float | None
    weight_curve: Curve
    method: str
    preset: str
    cues: str
    seed: int
    timings: dict[str, float]
    warnings: tuple[str, ...] = ()
    levels: Levels | None = None
    detail: Detail | None = None
    scene: Scene | None = None
    border_votes: Sequence[tuple[int, int, float]] = ()
    merged: bool = False
    shares: BorderShares | None = None
    _made: dict[str, Any] = field(default_factory=dict, init=False)

    def __repr__(self) -> str:
        size = " x ".join(str(side) for side in self.labels.shape)
        what = "pixels" if self.labels.ndim == 2 else "points"
        share = self.n_labelled / max(self.n_points, 1)
        return (
            f"<Segmentation: {self.in_words()}; {share:.0%} of {size} {what} labelled, "
            f"{self.timings.get('total', 0.0):.2f} s>"
        )

    def in_words(self) -> str:
        """Return how many segments there are, and what they go by.

        Examples
        --------
        >>> labels = np.array([0, 1], np.int32)
        >>> Segmentation(
        ...     labels, 2, 0.0, None, [], "nncsc", "paper", "color", 0, {}
        ... ).in_words()
        '2 segments, by colour alone'
        """
        return told(self.k, self.weight, self.method, self.cues, self.merged)

    def save(
        self,
        folder: str | Path,
        formats: Sequence[str] = (),
        *,
        lean: bool = False,
        overwrite: bool = False,
    ) -> list[Path]:
        """Write labels, pictures, the labelled cloud and the summary, as ``geohue segment -o``.

        Parameters
        ----------
        folder : path-like
            Made if it does not exist; an earlier result in it is replaced whole.
        formats : sequence of str
            More files: ``"pcd"``, ``"las"``, ``"laz"``, ``"coco"``, ``"segments"``, or ``"ply"``
            with `lean`.
        lean : bool
            Write labels and ``result.json`` only, no pictures, levels or cloud.
        overwrite : bool
            Whether to write into a folder that has other files than an earlier result.

        Returns
        -------
        list of Path
            The files, ``result.json`` last. See docs/results.md.

        Raises
        ------
        GeohueError
            If the scene is not known, as after `load`; if the folder has other files or cannot be
            written to; if a format does not fit the scene. Nothing is written then.

        Examples
        --------
        >>> import geohue
        >>> image = np.zeros((20, 30, 3), np.uint8)
        >>> image[:, 15:] = 200
        >>> seg = geohue.segment(geohue.Scene.from_image(image), k=2, cues="color")
        >>> folder = getfixture("tmp_path") / "out"
        >>> [file.name for file in seg.save(folder, lean=True)]
        ['labels.png', 'result.json']
        >>> bool((Segmentation.load(folder).labels == seg.labels).all())
        True
        """
        from geohue.results.outputs import write_results

        return write_results(
            folder, self._known_scene("save"), self, formats, lean=lean, overwrite=overwrite
        )

    @classmethod
    def load(cls, folder: str | Path) -> Segmentation:
        """Read a segmentation that `save` or ``geohue segment -o`` wrote.

        Parameters
        ----------
        folder : path-like
            With ``result.json`` and the labels; ``levels.npz`` is read where it is there.

        Returns
        -------
        Segmentation
            Without the scene, which is not among the files; seconds are rounded to 0.1 ms.

        Raises
        ------
        GeohueError
            If a file is missing, damaged or contradicts another one.
        """
        from geohue.read.results import read_segmentation

        return read_segmentation(folder)

    def overlay(self, image: NDArray[np.uint8] | None = None) -> NDArray[np.uint8]:
        """Return a picture of the segments.

        Parameters
        ----------
        image : (H, W, 3) uint8, optional
            What to tint; by default the scene.

        Returns
        -------
        (h, w, 3) uint8
            Of a grid the tinted image with the borders in white, or the palette alone where no
            image is known; of a cloud the view of its broadest side.

        Raises
        ------
        GeohueError
            If the image is of another size, or a cloud has no scene, as after `load`.
        """
        from geohue.results.show import show

        return show(self, image)

    def _known_scene(self, what: str) -> Scene:
        if self.scene is None:
            raise GeohueError(
                f"{what} needs the scene, and a segmentation that was loaded has none"
            )
        return self.scene

    def _repr_png_(self) -> bytes | None:
        from geohue.results.show import thumbnail

        return thumbnail(self)

    def _repr_html_(self) -> str:
        from geohue.results.show import as_html

        return as_html(self)

    @property
    def n_points(self) -> int:
        """Number of pixels or points of the scene."""
        return int(self.labels.size)

    @property
    def n_labelled(self) -> int:
        """Number of pixels or points with a label."""
        return int((self.labels >= 0).sum())

    @property
    def segments(self) -> Segments:
        """The segments as objects: ``seg.segments[i]`` has its mask, place, shape and neighbours.

        Raises
        ------
        GeohueError
            If the scene is not there.
        """
        if "segments" not in self._made:
            from geohue.objects import Measured, Segments

            self._made["segments"] = Segments(
                Measured(self._known_scene("segments"), self.labels, self.k)
            )
        found: Segments = self._made["segments"]
        return found

    @property
    def neighbours(self) -> Neighbours:
        """The graph of segments that touch, as plain arrays."""
        return self.segments.measured.neighbours

    def at(self, u: float, v: float) -> Segment | None:
        """Return the segment at column `u` and row `v` of the image, None where there is none."""
        return self.segments.at(u, v)

    def near(self, xyz: ArrayLike) -> Segment:
        """Return the segment of the labelled point nearest to a position in the scene."""
        return self.segments.near(xyz)

    def table(self, *, pandas: bool = False) -> Any:
        """Return the measures of all segments, a row each.

        Parameters
        ----------
        pandas : bool
            Whether to return a `pandas.DataFrame`.

        Returns
        -------
        dict of str to (K,) array, or pandas.DataFrame
            The columns of `geohue.objects.segments.table`.

        Raises
        ------
        GeohueError
            If the scene is not there, or pandas is asked for and not installed.
        """
        from geohue.objects.segments import frame, table

        columns = table(self.segments)
        return frame(columns) if pandas else columns

    def assign(
        self, points: ArrayLike, colors: ArrayLike | None = None, threads: int | None = None
    ) -> NDArray[np.int32]:
        """Return a label for every point: new, thinned away, without colour or out of view.

        Parameters
        ----------
        points : (..., 3) float
            Positions in the frame of the scene; not finite ones are missing.
        colors : (..., 3) uint8, or float in 0..1, optional
            sRGB; NaN where a point has none.
        threads : int, optional
            By default one a core.

        Returns
        -------
        (...) int32
            As `geohue.segmentation.assign.assign_labels` finds them; no -1 among them.

        Raises
        ------
        GeohueError
            If the arrays do not fit together, or the scene is not there.
        """
        from geohue.segmentation.assign import assign_labels

        return assign_labels(self._known_scene("assign"), self.labels, points, colors, threads)

    def edit(self) -> Editing:
        """Return the segments as a value that merges, splits and grows them, with undo."""
        from geohue.objects import Editing

        return Editing(self.labels, self.levels)

    def edited(self, edit: Editing) -> Segmentation:
        """Return the segmentation with the segments of `edit`, numbered anew, the largest first."""
        labels, old = relabel(edit.labels)
        if labels.shape != self.labels.shape:
            raise GeohueError(f"edited labels have shape {labels.shape}, not {self.labels.shape}")
        return replace(self, labels=labels, k=len(old), quality=None, detail=None)

    def summary(self) -> dict[str, Any]:
        """Return everything but the labels, ready for JSON (a weight not finite becomes None)."""
        return {
            "version": __version__,
            "method": self.method,
            "preset": self.preset,
            "cues": self.cues,
            "seed": self.seed,
            "k": self.k,
            "weight": self.weight if math.isfinite(self.weight) else None,
            "weight_in_words": weight_in_words(self.weight),
            "quality": self.quality,
            "weight_curve": [[float(w), float(q)] for w, q in self.weight_curve],
            "border_votes": [[a, b, round(share, 4)] for a, b, share in self.border_votes],
            "merged": self.merged,
            "detail": self.detail if self.detail is None else _plain(self.detail),
            "levels": None if self.levels is None else _levels(self.levels),
            "n_points": self.n_points,
            "n_labelled": self.n_labelled,
            "timings_s": {stage: round(s, 4) for stage, s in self.timings.items()},
            "warnings": list(self.warnings),
        }


def _plain(detail: Detail) -> float | str:
    return detail if isinstance(detail, str) else float(detail)


def _levels(levels: Levels) -> dict[str, Any]:
    """Return the number of levels, and of the segments at some degrees of detail."""
    counts = levels.counts(SUMMARY_DETAILS)
    segments = [list(pair) for pair in zip(SUMMARY_DETAILS, counts, strict=True)]
    return {"n": len(levels), "segments": segments}


@dataclass(slots=True)
class StageClock:
    """Times the stages of a run and tells of each as it begins."""

    progress: Progress | None = None
    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Time what happens inside as the stage `name`."""
        if self.progress is not None:
            self.progress(name)
        start = perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + perf_counter() - start

    def timings(self) -> dict[str, float]:
        """Return the seconds of each stage and their sum."""
        return self.seconds | {"total": sum(self.seconds.values())}
