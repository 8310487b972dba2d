"""What may stand in place of arrays and cameras: paths, matrices, numbers, mappings."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from importlib import import_module
from os import PathLike
from pathlib import Path
from typing import Any, TypeGuard, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geohue.camera import Intrinsics
from geohue.compute.checks import check_disparity, check_image
from geohue.errors import GeohueError, SceneWarning
from geohue.sensors.rig import Rig
from geohue.stereo.formats import rig_from_content
from geohue.stereo.rig import StereoRig

Notes = tuple[str, ...]
FilePath = str | PathLike[str]
Picture = ArrayLike | FilePath
Camera = Intrinsics | ArrayLike | Mapping[str, Any] | FilePath
StereoCalibration = StereoRig | Mapping[str, Any] | Sequence[Any] | FilePath
RigCalibration = Rig | Mapping[str, Any] | Sequence[FilePath] | FilePath

_NUMBERS = ("f", "baseline", "doffs", "cx", "cy")
_MATRICES = ("k1", "d1", "k2", "d2", "r", "t")


def is_path(value: object) -> TypeGuard[FilePath]:
    """Whether a value names a file."""
    return isinstance(value, str | PathLike)


def read(what: str, *arguments: Any) -> Any:
    """Call a reader of `geohue.read.given` by its name.

    The rooms of files lie above this one, which works without them until a path comes in.
    """
    return getattr(import_module("geohue.read.given"), what)(*arguments)


def tell(notes: Sequence[str], stacklevel: int = 3) -> None:
    """Warn of what a scene has in its `warnings`, on behalf of the caller's caller."""
    for note in notes:
        warnings.warn(note, SceneWarning, stacklevel=stacklevel)


def picture_given(given: Picture) -> tuple[NDArray[np.uint8], int]:
    """Return an image, (H, W, 3), and EXIF's mark of how it is turned."""
    if is_path(given):
        found: tuple[NDArray[np.uint8], int] = read("picture", Path(given))
        return found
    return check_image(cast(ArrayLike, given)), 1


def values_given(given: Picture) -> NDArray[Any]:
    """Return a map of numbers as it is."""
    return np.asarray(read("values", Path(given)) if is_path(given) else given)


def camera_given(given: Camera | None) -> tuple[Intrinsics | None, Notes]:
    """Return a camera, and what is to be said of its file.

    Examples
    --------
    >>> camera_given((500, 500, 320, 240))[0].cx
    320.0
    >>> camera_given([1, 2])
    Traceback (most recent call last):
    geohue.errors.GeohueError: intrinsics: a camera of shape (2,): expected K (3, 3) or fx, fy, ...
    """
    if given is None or isinstance(given, Intrinsics):
        return given, ()
    if is_path(given) or isinstance(given, Mapping):
        found: tuple[Intrinsics, Notes] = read("camera", given)
        return found
    try:
        return Intrinsics.from_numbers(cast(ArrayLike, given)), ()
    except GeohueError as error:
        raise GeohueError(f"intrinsics: {error}, or a dict, a file, geohue.Intrinsics") from error


def stereo_rig_given(given: StereoCalibration | None) -> tuple[StereoRig | None, Notes]:
    """Return the calibration of a pair, and what is to be said of its file.

    Examples
    --------
    >>> stereo_rig_given((700.0, 0.12))[0].baseline
    0.12
    >>> stereo_rig_given({"f": 700, "base": 1})
    Traceback (most recent call last):
    geohue.errors.GeohueError: rig: expected f and baseline[, doffs, cx, cy], K1 D1 K2 D2 R T, ...
    """
    if given is None or isinstance(given, StereoRig):
        return given, ()
    if is_path(given):
        found: tuple[StereoRig, Notes] = read("stereo_rig", given)
        return found
    try:
        rig = rig_from_content(_stereo_content(given))
    except GeohueError:
        raise
    except (TypeError, ValueError, IndexError, OverflowError):
        rig = None
    if rig is None:
        raise GeohueError(
            "rig: expected f and baseline[, doffs, cx, cy], K1 D1 K2 D2 R T, a dict of either, a "
            "file or geohue.stereo.StereoRig"
        )
    return rig, ()


def _stereo_content(given: object) -> dict[str, Any]:
    """Return a mapping or a row of values under the names of `rig_from_content`."""
    if isinstance(given, Mapping):
        content = {str(key).lower(): value for key, value in given.items()}
    else:
        row = list(given)  # type: ignore[call-overload]
        names = _MATRICES if len(row) == 6 else _NUMBERS
        if len(row) not in (2, 3, 5, 6):
            return {}
        content = dict(zip(names, row, strict=False))
    return {key: _listed(value) for key, value in content.items()}


def _listed(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key).lower(): _listed(inner) for key, inner in value.items()}
    numbers = isinstance(value, np.ndarray | list | tuple)
    return np.asarray(value, np.float64).ravel().tolist() if numbers else value


def rig_given(given: RigCalibration) -> Rig:
    """Return the calibration of a range sensor and its cameras."""
    if isinstance(given, Rig):
        return given
    found: Rig = read("rig", given)
    return found


def disparity_given(
    given: Picture | None, scale: float | str | None
) -> tuple[NDArray[np.floating[Any]] | None, Notes]:
    """Return a disparity map in pixels, and what is to be said of its file."""
    if given is None:
        if scale is not None:
            raise GeohueError("disparity_scale has no disparity to scale: give the map too")
        return None, ()
    if is_path(given):
        found: tuple[NDArray[np.float32], Notes] = read("disparity", Path(given), scale)
        return found
    if isinstance(scale, str):
        raise GeohueError(f"disparity_scale is {scale!r}: expected a number of pixels per unit")
    return check_disparity(cast(ArrayLike, given)) * (1.0 if scale is None else scale), ()
