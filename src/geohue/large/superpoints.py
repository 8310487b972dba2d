"""Superpoints of a cloud on disk, tile by tile, without seams."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from geohue._version import __version__
from geohue.errors import GeohueError
from geohue.jobs.lock import only_run
from geohue.large.memory import MB, parse_memory
from geohue.large.sample import SAMPLE, sample_positions
from geohue.large.stages import Progress
from geohue.large.superpoint_files import write_tiled
from geohue.large.superpoint_state import Sorted, TileState
from geohue.large.tile_graph import Whole, joined, merged
from geohue.large.tile_regions import Floats, TileRegions, Wish, area, split_tile, survey
from geohue.large.tiles import TILE, Positions, Tiles, blocks_of
from geohue.read.clouds.chunk import Chunks
from geohue.read.clouds.chunks import open_chunks
from geohue.read.files import broken
from geohue.results.folder import TILED_SUPERPOINTS, check_result_folder, move_results
from geohue.segmentation.result import StageClock
from geohue.superpoint.driver import check_compactness, check_cues, check_size
from geohue.superpoint.weights import FINE, MOST

LEAST = 700 * MB
"""Peak of a run, without the graph of the regions of the whole cloud."""

_GRAPH = 1200  # bytes a region


@dataclass(frozen=True, slots=True)
class FileSuperpoints:
    """The superpoints of a cloud on disk.

    Attributes
    ----------
    labels_file : Path
        NPY, (N,) int64: the superpoint of each point, -1 for those without a position.
    k : int
        How many superpoints, the largest first.
    counts : tuple of int
        How many each level has, the finest first.
    n_points, n_tiles, n_regions : int
        Points of the file, tiles, and regions of all tiles, which were merged as one graph.
    cues : str
        What they go by.
    spacing : float
        Typical distance of neighbours.
    timings : dict of str to float
        Seconds for each stage and in all, in the last run if there were several.
    warnings : tuple of str
        What the user should know.
    """

    labels_file: Path
    k: int
    counts: tuple[int, ...]
    n_points: int
    n_tiles: int
    n_regions: int
    cues: str
    spacing: float
    timings: dict[str, float]
    warnings: tuple[str, ...] = ()

    def summary(self) -> dict[str, Any]:
        """Return all of it, ready for JSON."""
        return {
            "version": __version__,
            "method": "superpoints",
            "cues": self.cues,
            "k": self.k,
            "counts": list(self.counts),
            "n_points": self.n_points,
            "n_tiles": self.n_tiles,
            "n_regions": self.n_regions,
            "spacing": self.spacing,
            "timings_s": {stage: round(s, 4) for stage, s in self.timings.items()},
            "warnings": list(self.warnings),
        }


@dataclass(frozen=True, slots=True)
class _Asked:
    counts: tuple[int, ...]
    size: float | None
    width: float | None
    cues: str
    compactness: float


def superpoints_file(
    path: str | Path,
    out: str | Path,
    count: int | Sequence[int] | None = None,
    size: float | None = None,
    width: float | None = None,
    *,
    cues: str = "auto",
    compactness: float = 1.0,
    memory: str | int | None = None,
    threads: int | None = None,
    resume: bool = False,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> FileSuperpoints:
    """Split a cloud of any size into superpoints, tile by tile and without seams.

    One pass over the file sorts its points into tiles on disk. In each tile regions are merged as
    in `geohue.superpoints`, but none of those whose next union depends on points beyond a face;
    four regions for each superpoint are left. The regions of all tiles are then merged as one
    graph. So superpoints cross the faces, and the tree of nested levels is that of the whole cloud.

    Parameters
    ----------
    path : str or Path
        The cloud: LAS, LAZ, binary PLY, or NPY with rows x, y, z, red, green, blue.
    out : str or Path
        Folder that receives ``superpoints.npy`` (int64), ``levels.npz``, ``graph.npz`` and
        ``superpoints.json``.
    count : int or sequence of int, optional
        How many superpoints; several for nested levels.
    size, width, cues, compactness
        As for `geohue.superpoints`. With `width` the tiles are gone through once more.
    memory : str or int, optional
        Bound on the memory, such as ``"2GB"``. It does not change the labels: a tile has a fixed
        size, and what grows with the cloud is the graph of the regions, about 5 KB a superpoint.
    threads : int, optional
        How many; by default one a core. The labels do not depend on it.
    resume : bool
        Go on with a run in `out` that was killed; finished tiles are not split again.
    overwrite : bool
        Whether to write into a folder that has other files than earlier superpoints.
    progress : callable, optional
        Called with "measure", "sort", "survey" or "split", the points done and all points.

    Returns
    -------
    FileSuperpoints

    Raises
    ------
    GeohueError
        For a file that cannot be read in pieces, bad arguments, too little memory or disk, or a run
        in `out` that is not this one or is under way.

    Examples
    --------
    >>> import numpy as np
    >>> file = getfixture("tmp_path") / "cloud.npy"
    >>> xyz = np.random.default_rng(0).random((2000, 3)) * [1, 1, 0]
    >>> np.save(file, np.hstack([xyz, np.full((2000, 3), 90.0)]))
    >>> found = superpoints_file(file, file.parent / "out", count=[40, 10])
    >>> found.k, found.counts, int(np.load(found.labels_file).max())
    (40, (40, 10), 39)
    """
    many = () if count is None else tuple(np.atleast_1d(np.asarray(count)).tolist())
    for one in many or (None,):
        check_size(one, size, width)
    counts = tuple(sorted(set(many), reverse=True))
    asked = _Asked(counts, size, width, cues, float(compactness))
    check_cues(cues)
    check_compactness(compactness)
    allowed = None if memory is None else parse_memory(memory)
    if allowed is not None and allowed < LEAST:
        raise GeohueError(f"memory {allowed // MB} MB is too little: give at least {LEAST // MB}MB")
    folder, source = Path(out), open_chunks(Path(path).absolute())
    check_result_folder(folder, TILED_SUPERPOINTS, overwrite=overwrite)
    run = _Run(source, asked, allowed, threads, progress or (lambda *_: None))
    with only_run(folder):
        return run.into(folder, resume)


@dataclass(frozen=True, slots=True)
class _Run:
    source: Chunks
    asked: _Asked
    allowed: int | None
    threads: int | None
    progress: Progress

    def into(self, folder: Path, resume: bool) -> FileSuperpoints:
        state, clock = TileState(folder, self._identity(), resume), StageClock()
        with clock.stage("sort"):
            found = self._sorted(state)
        with clock.stage("survey"):
            wish, wanted = self._wish(state, found)
        with clock.stage("split"):
            parts = self._split(state, found, wish)
        with clock.stage("merge"):
            whole = self._merged(state, parts, wish, wanted)
        k = whole.tree.n_regions
        n_regions = len(whole.name) - 1
        notes = [] if k <= wanted else [f"{k} superpoints instead of {wanted}: so many lie apart"]
        new = state.fresh_folder()
        with clock.stage("write"):
            coarser = [c for c in self.asked.counts[1:] if c < k]
            counts = write_tiled(new, state.buckets, self.source.n_points, whole, coarser)
        result = FileSuperpoints(
            folder / "superpoints.npy",
            k,
            counts,
            self.source.n_points,
            len(found.tiles),
            n_regions,
            wish.cues,
            wish.spacing,
            clock.timings(),
            tuple(notes),
        )
        content = json.dumps(result.summary(), indent=2) + "\n"
        (new / TILED_SUPERPOINTS.mark).write_text(content, encoding="utf-8")
        move_results({file.name: file for file in new.iterdir()}, folder, TILED_SUPERPOINTS)
        state.end()
        return result

    def _identity(self) -> dict[str, Any]:
        status = self.source.path.stat()
        return {
            "version": __version__,
            "input": self.source.path.name,
            "bytes": status.st_size,
            "modified_ns": status.st_mtime_ns,
            "n_points": self.source.n_points,
            "count": list(self.asked.counts),
            "size": self.asked.size,
            "width": self.asked.width,
            "cues": self.asked.cues,
            "compactness": self.asked.compactness,
            "tile": TILE,
        }

    def _sorted(self, state: TileState) -> Sorted:
        before = state.sorted()
        if before is not None:
            return before
        n = self.source.n_points
        wanted = sample_positions(n, SAMPLE, 0)
        sample, low, high = [], np.full(3, 255), np.zeros(3)
        for start, (xyz, rgb) in blocks_of(self.source):
            slots = slice(*np.searchsorted(wanted, (start, start + len(xyz))))
            picked = xyz[wanted[slots] - start]
            sample.append(picked[np.isfinite(picked).all(axis=1)])
            known = rgb[np.isfinite(xyz).all(axis=1)]
            low = np.minimum(low, known.min(axis=0, initial=255))
            high = np.maximum(high, known.max(axis=0, initial=0))
            self.progress("measure", start + len(xyz), n)
        tiles = Tiles.of(np.concatenate(sample), TILE * len(wanted) / n)
        for done in state.buckets.fill(self.source, tiles):
            self.progress("sort", done, n)
        bounds, counts = _boxes(state, len(tiles))
        if not counts.any():
            raise broken(self.source.path, "no point has a position: check the cloud")
        found = Sorted(tiles, bounds, counts, bool((low >= high).all()))
        state.keep_sorted(found)
        return found

    def _wish(self, state: TileState, found: Sorted) -> tuple[Wish, int]:
        asked, points = self.asked, int(found.counts.sum())
        there = np.flatnonzero(found.counts).tolist()
        box = found.bounds[there]
        origin = (box[:, 0].min(axis=0) + box[:, 1].max(axis=0)) / 2
        cues = asked.cues
        if cues == "auto":
            cues = "geometry" if found.is_plain else "fusion"
        away = []
        for tile in there:
            away.append(survey(state.buckets, tile, origin, self.threads))
        every = np.concatenate(away)
        spacing = float(np.median(every)) if len(every) else 1.0
        wish = Wish(cues, asked.compactness, spacing or 1.0, 1.0, origin)
        wanted = asked.counts[0] if asked.counts else 0
        if asked.size is not None:
            wanted = round(points / asked.size)
        elif asked.width is not None:
            total = sum(area(state.buckets, tile, wish, self.threads) for tile in there)
            wanted = round(total / asked.width**2)
        wanted = min(max(1, wanted), points)
        return Wish(cues, asked.compactness, wish.spacing, wanted / points, origin), wanted

    def _split(self, state: TileState, found: Sorted, wish: Wish) -> list[TileRegions]:
        """Split the tiles that are not split yet; each is kept on disk until all are."""
        done = 0
        for tile in range(len(found.tiles)):
            if state.split(tile) is None:
                given = state.buckets, tile, found.tiles, found.bounds, wish, self.threads
                state.keep_split(tile, *split_tile(*given))
            done += int(found.counts[tile])
            self.progress("split", done, int(found.counts.sum()))
        parts = []
        for tile in range(len(found.tiles)):
            part = state.split(tile)
            assert part is not None
            parts.append(part)
            self._check_memory(sum(len(p.region) for p in parts))
        return parts

    def _check_memory(self, n_regions: int) -> None:
        needed = LEAST + _GRAPH * n_regions
        if self.allowed is not None and needed > self.allowed:
            raise GeohueError(
                f"memory {self.allowed // MB} MB is too little for so many superpoints: at least "
                f"{needed // MB} MB; allow more with --resume, or ask for fewer superpoints"
            )

    def _merged(self, state: TileState, parts: list[TileRegions], wish: Wish, wanted: int) -> Whole:
        def region_of(tile: int, rows: Positions) -> np.ndarray[Any, np.dtype[np.int32]]:
            return np.fromfile(state.buckets.regions(tile), np.int32)[rows]

        most = min(MOST, 1 / wish.density / FINE)
        regions, color, starts, united = joined(parts, region_of, most)
        parts.clear()
        name, tree, graph = merged(regions, color, wish, wanted)
        return Whole(starts, np.append(name[united], -1), tree, graph)


def _boxes(state: TileState, n: int) -> tuple[Floats, Positions]:
    """Return the box of the points of each tile, (n, 2, 3), and how many there are."""
    bounds, counts = np.full((n, 2, 3), np.nan), np.zeros(n, np.int64)
    for tile in range(n):
        xyz = state.buckets.rows(tile)["xyz"]
        counts[tile] = len(xyz)
        if len(xyz):
            bounds[tile] = xyz.min(axis=0), xyz.max(axis=0)
    return bounds, counts
