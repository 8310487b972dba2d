"""A cloud on disk into its parts, in two passes of bounded memory."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, Literal

import numpy as np

from geohue._version import __version__
from geohue.compute.parallel import cores
from geohue.errors import GeohueError
from geohue.features import CUES
from geohue.jobs.lock import only_run
from geohue.large.fit import Decision, Fitted, FittedCut
from geohue.large.levels import counted, plan_regions, write_levels
from geohue.large.memory import parse_memory, processes_within
from geohue.large.merged import MergedRegions
from geohue.large.pictures import draw
from geohue.large.question import Question
from geohue.large.result import FileSegmentation
from geohue.large.sample import SAMPLE
from geohue.large.stages import JobRunner, Progress, decide, label_all, measure_all
from geohue.large.state import State, has_state
from geohue.large.targets import part_of, plan_targets, publish, write_las_files
from geohue.merge.levels import Detail
from geohue.merge.tree import MergeTree
from geohue.read.clouds.chunk import Chunks
from geohue.read.clouds.chunks import open_chunks
from geohue.read.files import broken, read_bytes
from geohue.results.folder import IN_PIECES, check_result_folder
from geohue.results.numbering import numbering
from geohue.scene.cloud import without_place
from geohue.segmentation.arguments import Weight
from geohue.segmentation.choice import shortfalls
from geohue.segmentation.result import StageClock
from geohue.settings import Preset, preset_named


def segment_file(
    path: str | Path,
    out: str | Path,
    k: int | Literal["auto"] = "auto",
    weight: Weight = "auto",
    preset: str | Preset = "best",
    cues: str = "fusion",
    seed: int = 0,
    *,
    detail: Detail = "auto",
    memory: str | int | None = None,
    processes: int | None = None,
    scheduler: str | None = None,
    resume: bool = False,
    formats: Sequence[str] = (),
    lean: bool = False,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> FileSegmentation:
    """Split a coloured cloud of any size into its parts.

    The first pass over the file gathers the moments of colour and geometry (eq. 3, 4; exact) and
    a random sample of 100,000 points; the votes and the tree of merged regions, or for the paper's
    method k, weight and the cut, are found on the sample; the second pass labels every point. With
    no more points than the sample, the labels are those of `geohue.segment`. They depend neither
    on `memory` nor on where the passes run.

    Parameters
    ----------
    path : str or Path
        The cloud: LAS, LAZ, binary PLY, or NPY with rows x, y, z, red, green, blue.
    out : str or Path
        Folder that receives ``labels.npy`` (int32, -1 for points without coordinates),
        ``result.json`` and, where regions were merged, ``levels.npz``.
    k, weight, preset, cues, seed, detail
        As for `geohue.segment`.
    memory : str or int, optional
        Bound on the memory of all processes together, such as ``"2GB"``.
    processes : int, optional
        How many work on the passes, each with one thread; by default one a core, as far as
        `memory` allows.
    scheduler : str, optional
        Address of a dask scheduler whose workers do the passes; they must see the same files.
    resume : bool
        Go on with a run in `out` that was killed; finished stretches are not done again. With
        another k, weight, preset, detail or format, those of the first pass are not.
    formats : sequence of str
        More files: ``"ply"``, ``"las"`` or ``"laz"`` for ``segmented.ply`` and so on. LAS and LAZ
        of a LAS or LAZ file keep all that is in it.
    lean : bool
        Leave out the pictures.
    overwrite : bool
        Whether to write into a folder that has other files than an earlier result.
    progress : callable, optional
        Called as stretches are finished.

    Returns
    -------
    FileSegmentation

    Raises
    ------
    GeohueError
        For a file that cannot be read in pieces, bad arguments, too little memory, a run in `out`
        that is not this one or is under way, or stretches that failed (the others are kept).

    Examples
    --------
    >>> import numpy as np
    >>> file = getfixture("tmp_path") / "cloud.npy"
    >>> xyz = np.random.default_rng(0).random((600, 3)) + np.repeat([[0], [5]], 300, axis=0)
    >>> np.save(file, np.hstack([xyz, np.repeat([[200, 30, 30], [30, 30, 200]], 300, axis=0)]))
    >>> result = segment_file(file, file.parent / "out", k=2, processes=1)
    >>> result.sizes, np.load(result.labels_file)[::300].tolist()
    ((300, 300), [0, 1])
    """
    question = Question(k, weight, preset_named(preset), cues, seed, detail)
    _check(question, processes)
    allowed = None if memory is None else parse_memory(memory)
    runner = JobRunner(processes_within(allowed, processes or cores()), scheduler, progress)
    folder, source = Path(out), open_chunks(Path(path).absolute())
    if not source.has_colors and cues != "geometry":
        raise broken(path, "has no colours; export the cloud with red, green and blue")
    targets = plan_targets(folder, source.n_points, source.is_double, formats)
    identity = _identity(source, question, formats)
    if resume and not has_state(folder):
        finished = _finished(folder, identity)
        if finished is not None:
            return finished
    check_result_folder(folder, IN_PIECES, overwrite=overwrite)
    with only_run(folder):
        state, clock = State(folder, identity, resume), StageClock()
        with clock.stage("measure"):
            moments = measure_all(source, state, question, runner)
        fitted, decision = decide(source, state, moments, question, clock, runner)
        with clock.stage("label"):
            regions = {} if isinstance(fitted, FittedCut) else plan_regions(state.folder)
            counts = label_all(source, state, fitted, targets | regions, runner)
        tree, others = None, state.fresh_folder()
        if isinstance(fitted, MergedRegions):
            with clock.stage("levels"):
                ((target, _),) = regions.values()
                sizes = np.array(counts[:-1])
                tree = write_levels(others / LEVELS, target, source.n_points, sizes, fitted.tree)
        name = preset if isinstance(preset, str) else "custom"
        result = _result(folder, source, question, name, fitted, decision, counts, tree, clock)
        if not lean:
            draw(others, state.sample(), fitted, result)
        labels = next(iter(targets))
        labels = part_of(labels) if part_of(labels).exists() else labels
        write_las_files(others, source, labels, formats)
        files = [file.name for file in (*targets, *others.iterdir())]
        content = result.summary() | {"numbering": numbering(files), "run": identity}
        (others / RESULT).write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
        publish(folder, targets, {file.name: file for file in others.iterdir()})
        state.end()
        return result


RESULT, LEVELS = "result.json", "levels.npz"


def _check(question: Question, processes: int | None) -> None:
    question.arguments()  # checks them
    if question.weight == "consensus":
        raise GeohueError(
            'weight="consensus" needs the whole cloud in memory, and this one goes through in '
            'pieces: choose weight="merge" or "agreement"'
        )
    if question.cues not in CUES:
        raise GeohueError(f"cues {question.cues!r}: choose one of {', '.join(CUES)}")
    if processes is not None and processes < 1:
        raise GeohueError(f"processes is {processes}: expected at least 1")


def _identity(source: Chunks, question: Question, formats: Sequence[str]) -> dict[str, Any]:
    """Return all that the labels depend on, as it reads back from JSON."""
    status = source.path.stat()
    identity = {
        "version": __version__,
        "input": source.path.name,
        "bytes": status.st_size,
        "modified_ns": status.st_mtime_ns,
        "n_points": source.n_points,
        "formats": sorted(formats),
        **asdict(question),
    }
    content: dict[str, Any] = json.loads(json.dumps(identity, default=float))
    return content


def _result(
    folder: Path,
    source: Chunks,
    question: Question,
    preset: str,
    fitted: Fitted,
    decision: Decision,
    counts: list[int],
    tree: MergeTree | None,
    clock: StageClock,
) -> FileSegmentation:
    # Bins of whole numbers below 2^53: exact as floats.
    points = np.bincount(fitted.order, weights=counts[:-1])
    sizes = tuple(int(size) for size in points)
    found = sum(size > 0 for size in sizes)
    notes = without_place(source.n_points - sum(sizes), source.n_points)
    return FileSegmentation(
        folder / "labels.npy",
        found,
        sizes,
        float(fitted.weight),
        decision.quality,
        decision.curve,
        preset,
        question.cues,
        question.seed,
        source.n_points,
        min(SAMPLE, source.n_points),
        clock.timings(),
        (*notes, *decision.notes, *shortfalls(found, decision.k, False)),
        question.detail if tree is not None and question.k == "auto" else None,
        None if tree is None else counted(tree),
    )


def _finished(folder: Path, identity: dict[str, Any]) -> FileSegmentation | None:
    """Return the result of the same run, if it has ended."""
    file = folder / RESULT
    if not file.exists() or not (folder / "labels.npy").exists():
        return None
    try:
        content = json.loads(read_bytes(file))
    except ValueError:  # no result of ours, and written anew at the end
        return None
    if not isinstance(content, dict) or content.get("run") != identity:
        return None
    return FileSegmentation(
        folder / "labels.npy",
        content["k"],
        tuple(content["sizes"]),
        math.inf if content["weight"] is None else content["weight"],
        content["quality"],
        [(weight, value) for weight, value in content["weight_curve"]],
        content["preset"],
        content["cues"],
        content["seed"],
        content["n_points"],
        content["n_sample"],
        content["timings_s"],
        tuple(content["warnings"]),
        content["detail"],
        content["levels"],
    )
