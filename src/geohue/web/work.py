"""What a worker process does: reads a scene, segments it, and writes what the page shows."""

from __future__ import annotations

import contextlib
import json
import pickle
from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib import import_module
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geohue.errors import GeohueError
from geohue.web.limits import Limits
from geohue.web.store import RUN, SCENE
from geohue.web.wishes import Wishes

if TYPE_CHECKING:
    from geohue.scene import Scene
    from geohue.segmentation.result import Segmentation

Tell = Callable[[str, float], None]
"""Called with a stage's words and the share of the work that is done before it."""

_MERGED = ("features", "limbs", "cuts", "merge", "borders", "quality", "fill")
_CUT = ("features", "k", "weight", "cut", "refine", "quality", "fill")
_READING, _SHOWING = "reading the files", "preparing the views"
_COMPILING = "compiling its loops, which only a first run does"
_MOST_MESSAGE = 500


def work(pipe: Connection, limits: Limits) -> None:
    """Do the tasks that come through a pipe, one after the other, until it is closed.

    Parameters
    ----------
    pipe : Connection
        Receives mappings (`geohue.web.store.as_task`); ``("stage", (words, share))``, then
        ``("done", "")`` or ``("failed", message)`` are sent back.
    limits : Limits
    """
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the server ends its workers itself
    _limit_memory(limits.memory_bytes)
    with contextlib.suppress(EOFError, OSError):
        import_module("geohue.segmentation.driver")  # while nobody waits

        while True:
            task = pipe.recv()
            pipe.send(attempt(task, limits, lambda *stage: pipe.send(("stage", stage))))


def attempt(task: Mapping[str, Any], limits: Limits, tell: Tell) -> tuple[str, str]:
    """Do a task; returns ``("done", "")``, or ``("failed", message)`` without any path in it."""
    folder: Path = task["folder"]
    try:
        run_task(task, limits, tell)
    except GeohueError as error:
        return "failed", without_paths(str(error), folder)
    except MemoryError:
        return "failed", "out of memory: give a smaller scene"
    except Exception as error:  # a fault of geohue must not end the worker
        import logging

        logging.getLogger("geohue.web").exception("a scene failed")
        return "failed", f"an internal error ({type(error).__name__}); the server's log has it"
    return "done", ""


def without_paths(message: str, folder: Path) -> str:
    """Return a message with the names of a job's files only, not where they are.

    Examples
    --------
    >>> without_paths("/tmp/x/depth.png: is empty", Path("/tmp/x"))
    'depth.png: is empty'
    """
    return message.replace(f"{folder}/", "").replace(str(folder), "")[:_MOST_MESSAGE]


def run_task(task: Mapping[str, Any], limits: Limits, tell: Tell) -> None:
    """Read a scene, segment it, and write the views.

    Raises
    ------
    GeohueError
        For input that cannot be used, or is beyond the limits.
    """
    from geohue.compute.first_run import on_compile
    from geohue.segmentation.arguments import SegmentArguments
    from geohue.segmentation.driver import segment
    from geohue.segmentation.stages import STAGES
    from geohue.web.intake import read_task_scene
    from geohue.web.views import write_views

    folder: Path = task["folder"]
    wishes: Wishes = task["wishes"]
    names = ("preset", "k", "weight", "detail", "cues", "method", "seed")
    asked = SegmentArguments(**{name: getattr(wishes, name) for name in names})
    tell(_READING, 0.0)
    scene = read_task_scene(folder, task["files"], task["sample"], wishes, limits)
    notes = tuple(without_paths(note, folder) for note in scene.warnings)
    scene = replace(scene, warnings=notes)
    _keep(folder / SCENE, scene)
    for name in task["files"].values():  # read, and large
        (folder / name).unlink()
    stages = _MERGED if asked.merges else _CUT

    def begin(stage: str) -> None:
        at = stages.index(stage) + 1 if stage in stages else 1
        tell(STAGES.get(stage, stage), at / (len(stages) + 2))

    with on_compile(lambda: tell(_COMPILING, 1 / (len(stages) + 2))):
        seg = segment(scene, **asked.as_dict(), progress=begin)
    tell(_SHOWING, (len(stages) + 1) / (len(stages) + 2))
    _keep(folder / RUN, replace(seg, scene=None))
    write_views(folder, scene, seg, limits.shown_points)
    summary = json.dumps(seg.summary(), indent=2) + "\n"
    (folder / "result.json").write_text(summary, encoding="utf-8")


def _keep(file: Path, content: Any) -> None:
    if not file.exists():
        file.write_bytes(pickle.dumps(content, protocol=5))


def kept_run(folder: Path) -> tuple[Scene, Segmentation]:
    """Return the scene and the segmentation of a job that is done."""
    scene: Scene = pickle.loads((folder / SCENE).read_bytes())
    seg: Segmentation = pickle.loads((folder / RUN).read_bytes())
    return scene, seg


def _limit_memory(most: int) -> None:
    """Let the system refuse this process more memory than that, where it can."""
    try:
        import resource
    except ImportError:  # Windows
        return
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    if hard == resource.RLIM_INFINITY or hard > most:
        resource.setrlimit(resource.RLIMIT_DATA, (most, hard))
