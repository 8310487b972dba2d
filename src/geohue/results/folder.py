"""A folder of results as one thing: all files of a run appear together, or none of them."""

from __future__ import annotations

import glob
import json
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from secrets import token_hex

from geohue.errors import GeohueError
from geohue.read.files import broken, reason
from geohue.results.atomic import check_folder
from geohue.results.exchange import exchange

INCOMPLETE = ".geohue-incomplete"
"""Is in a folder while its files are replaced one by one, and names them: without it and with the
mark of its kind a result is whole."""

_STAGING = "geohue-part-"
_RUNNING = ".running"
_NAMED = 3  # files that an error names


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of result folder.

    Attributes
    ----------
    mark : str
        The JSON file that says that a folder holds such a result: an object with a ``version``.
    names : frozenset of str
        The files and folders that it may have, in this version or an earlier one.
    working : frozenset of str
        Those of a run that is under way or was killed: never taken for a stranger's.
    """

    mark: str
    names: frozenset[str]
    working: frozenset[str] = frozenset(["running.lock"])


_CLOUDS = {f"segmented.{ending}" for ending in ("ply", "pcd", "las", "laz")}
_PICTURES = {"overlay.png", "borders.png", "weight_curve.png", "segments.png"}
_OBJECTS = {"objects.csv", "objects.json"}

SEGMENTATION = Kind(
    "result.json",
    frozenset({"result.json", "labels.png", "labels.npy", "levels.npz", "coco.json"})
    | _OBJECTS
    | {"disparity.png", "rectified_left.png", "rectified_right.png", "labels_original.png"}
    | {"rectification.npz"}
    | _PICTURES
    | _CLOUDS,
)
"""What ``geohue segment`` writes."""

IN_PIECES = Kind(
    SEGMENTATION.mark,
    SEGMENTATION.names,
    frozenset(["running.lock", "state", "labels.npy.part", "segmented.ply.part"]),
)
"""The same of a cloud that is read in pieces, in whose folder a killed run leaves its state."""

COMPARISON = Kind(
    "compare.json",
    frozenset({"compare.json", "compare.html", "compare.csv", "plate.png", "labels"}),
)
"""What ``geohue compare`` writes."""

SUPERPOINTS = Kind(
    "superpoints.json",
    frozenset({"superpoints.json", "levels.npz", "graph.npz"})
    | {f"superpoints.{ending}" for ending in ("npy", "pth", "png", "ply", "las", "laz")},
)
"""What ``geohue superpoints`` writes for a scene."""

TILED_SUPERPOINTS = Kind(SUPERPOINTS.mark, SUPERPOINTS.names, frozenset(["running.lock", "tiles"]))
"""The same of a cloud in tiles, in whose folder a killed run leaves them."""


def check_result_folder(
    folder: str | Path, kind: Kind = SEGMENTATION, *, overwrite: bool = False
) -> None:
    """Raise an error, before the work is done, if results could not go into a folder.

    Parameters
    ----------
    folder : path-like
        Need not exist, nor its parents; nothing is made.
    kind : Kind
        What is to be written.
    overwrite : bool
        Whether they may go into a folder that has other files, too.

    Raises
    ------
    GeohueError
        If it has files that are no earlier result of this kind and `overwrite` is not set, is a
        file, lies under one, or may not be written to.
    """
    check_folder(folder)
    others = [] if overwrite else _others(Path(folder), kind)
    if others:
        shown = ", ".join(others[:_NAMED]) + (", ..." if len(others) > _NAMED else "")
        cause = f"has other files in it ({shown}); give a new or empty folder, or keep them there"
        raise broken(folder, f"{cause} and write beside them with overwrite=True")


@contextmanager
def whole_folder(
    folder: str | Path, kind: Kind = SEGMENTATION, *, overwrite: bool = False
) -> Iterator[Path]:
    """Give a new folder whose files are those of `folder` when the block ends without an exception.

    The two folders are exchanged in one step, and what was there before is removed. Where that
    cannot be done (no such system call, the root of a disk, the working folder, other files that
    stay), the files are moved one by one, the mark of the kind last.

    Parameters
    ----------
    folder : path-like
        Made if it does not exist, with its parents; an earlier result in it is replaced whole.
    kind : Kind
        What is written.
    overwrite : bool
        Whether results may go into a folder that has other files, too. Those stay, except for any
        with the name of a result.

    Yields
    ------
    Path
        An empty folder on the same disk.

    Raises
    ------
    GeohueError
        As of `check_result_folder`, or if the disk is full. Whatever happens inside the block, what
        was in the folder stays, and nothing half-written appears.

    Examples
    --------
    >>> out = getfixture("tmp_path") / "out"
    >>> with whole_folder(out) as new:
    ...     _ = (new / "result.json").write_text('{"version": "1"}')
    >>> [file.name for file in out.iterdir()]
    ['result.json']
    """
    check_result_folder(folder, kind, overwrite=overwrite)
    staging: Path | None = None
    try:
        target = Path(folder).resolve()
        target.parent.mkdir(parents=True, exist_ok=True)
        _remove_abandoned(target)
        staging = _make_staging(target)
        with _held(staging):
            yield staging
        if not _in_one_step(staging, target, kind):
            move_results({file.name: file for file in staging.iterdir()}, target, kind)
    except OSError as error:
        cause = f"cannot be written ({reason(error)}); choose a folder with space and permission"
        raise broken(folder, cause) from error
    except GeohueError as error:
        if staging is None or str(staging) not in str(error):
            raise
        raise GeohueError(str(error).replace(str(staging), str(folder))) from error
    finally:
        if staging is not None:  # now it is the earlier result, if the two were exchanged
            shutil.rmtree(staging, ignore_errors=True)


def move_results(new: Mapping[str, Path], target: Path, kind: Kind = SEGMENTATION) -> None:
    """Replace the result in a folder by new files, one by one, the mark last.

    Parameters
    ----------
    new : dict of str to Path
        The names that files on the same disk are to have.
    target : Path
        Made if it does not exist. Other files of `kind` in it go; all others stay.
    kind : Kind
        What the result is.

    Raises
    ------
    OSError
        If a file cannot be moved. The folder then lacks the mark, and has `INCOMPLETE`.
    """
    target.mkdir(parents=True, exist_ok=True)
    own = _own(target, kind)
    ours = sorted((own & kind.names) | new.keys())
    (target / INCOMPLETE).write_text("\n".join(ours), encoding="utf-8")
    _remove(target / kind.mark)
    for name in own & kind.names - new.keys():
        _remove(target / name)
    for name in sorted(new, key=lambda name: name == kind.mark):
        if new[name].is_dir():
            _remove(target / name)
        new[name].replace(target / name)
    (target / INCOMPLETE).unlink()


def _in_one_step(staging: Path, target: Path, kind: Kind) -> bool:
    """Put a new folder into the place of another; returns whether it could be done at once."""
    if staging.parent == target or Path.cwd().is_relative_to(target):
        return False
    if not target.exists():
        staging.rename(target)
        return True
    if _others(target, kind):
        return False
    shutil.copymode(target, staging)
    return exchange(staging, target)


def _others(folder: Path, kind: Kind) -> list[str]:
    """Return what is in a folder beside an earlier result of geohue."""
    if not folder.is_dir():
        return []
    return sorted({entry.name for entry in folder.iterdir()} - _own(folder, kind))


def _own(folder: Path, kind: Kind) -> set[str]:
    """Return the names in a folder that belong to a result: by its mark, not by the names alone."""
    present = {entry.name for entry in folder.iterdir()}
    hidden = {name for name in present if name.startswith(f".{_STAGING}")}
    hidden |= present & {*kind.working, INCOMPLETE}
    if _is_mark(folder / kind.mark):
        return hidden | (present & kind.names)
    with suppress(OSError, ValueError):  # there is none, or it is no text
        named = (folder / INCOMPLETE).read_text(encoding="utf-8").splitlines()
        return hidden | (present & kind.names).intersection(named)
    return hidden


def _is_mark(file: Path) -> bool:
    with suppress(OSError, ValueError):
        content = json.loads(file.read_bytes())
        return isinstance(content, dict) and "version" in content
    return False


def _make_staging(target: Path) -> Path:
    """Make an empty folder beside another one, or inside where there is no room beside it."""
    if not os.path.ismount(target):
        with suppress(OSError):
            beside = target.with_name(f".{target.name[:40]}.{_STAGING}{token_hex(8)}")
            beside.mkdir()
            return beside
    target.mkdir(parents=True, exist_ok=True)
    inside = target / f".{_STAGING}{token_hex(8)}"
    inside.mkdir()
    return inside


@contextmanager
def _held(staging: Path) -> Iterator[None]:
    """Keep others from taking a folder for one that a killed run left behind."""
    from filelock import FileLock

    with FileLock(staging / _RUNNING, timeout=0):
        yield
    (staging / _RUNNING).unlink(missing_ok=True)


def _remove_abandoned(target: Path) -> None:
    """Remove what killed runs have left of results for this folder."""
    from filelock import FileLock, Timeout

    left = list(target.parent.glob(f".{glob.escape(target.name[:40])}.{_STAGING}*"))
    left += target.glob(f".{_STAGING}*")
    for folder in left:
        with suppress(OSError, Timeout):
            if (folder / _RUNNING).exists():
                with FileLock(folder / _RUNNING, timeout=0):
                    shutil.rmtree(folder, ignore_errors=True)


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)
