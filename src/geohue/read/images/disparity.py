"""Disparity maps as files."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.read.arrays import read_npy, read_npz, read_pfm
from geohue.read.files import broken
from geohue.read.images.pictures import decode_picture

_KITTI = 1 / 256
_FIXED_POINT = 1 / 16  # OpenCV's matchers
_SATURATED = 65535
_MARK_SHARE = 0.002  # of the pixels must have a negative value for it to be a mark


@dataclass(frozen=True, slots=True, eq=False)
class DisparityImage:
    """A disparity map in pixels.

    Parameters
    ----------
    disparity : (H, W) float32
        Pixels; NaN where missing.
    scale : float
        Pixels per unit of the file that were used.
    warnings : tuple of str
        Guesses that the user should know of.
    """

    disparity: NDArray[np.float32]
    scale: float
    warnings: tuple[str, ...] = ()


def read_disparity(path: str | Path, scale: float | None = None) -> DisparityImage:
    """Read a disparity map.

    Parameters
    ----------
    path : path-like
        PNG, PGM or TIFF with one channel, PFM, NPY, or NPZ with one array.
    scale : float, optional
        Pixels per unit of the file: ``disparity = value * scale`` (1/3 for Middlebury's third
        size, 1/256 for KITTI). By default 1 for floats. For integers the scale is a guess, with a
        warning: 1/256 for 16-bit pictures with values beyond the image's width (KITTI), 1/16 for
        signed 16-bit arrays (OpenCV's matchers), 1 for all others.

    Returns
    -------
    DisparityImage
        0, NaN, infinite values and the format's own mark are NaN: 65535 in 16-bit pictures;
        negative values of signed integers, unless most are negative; the lowest value of floats
        if it is negative, whole and frequent (a matcher's "none").

    Raises
    ------
    GeohueError
        If the file is missing, damaged or has several channels, or the scale is not positive.

    Examples
    --------
    >>> from geohue.results import write_png
    >>> file = getfixture("tmp_path") / "disp1.png"
    >>> write_png(file, np.array([[0, 60]], np.uint8))
    >>> read_disparity(file, 1 / 3).disparity
    array([[nan, 20.]], dtype=float32)
    """
    if scale is not None and not 0 < scale < np.inf:
        raise GeohueError(
            f"disparity scale {scale}: must be a positive number of pixels per unit (1/3 where "
            "the file has thirds of a pixel)"
        )
    raw = _read(path)
    used, notes = (scale, ()) if scale is not None else _guessed(raw, path)
    with np.errstate(all="ignore"):
        disparity = (raw.astype(np.float64) * used).astype(np.float32)
    disparity[_missing(raw) | ~np.isfinite(disparity)] = np.nan
    if not np.isfinite(disparity).any():
        notes = (*notes, f"{path}: no pixel has a disparity")
    return DisparityImage(disparity, used, notes)


def parse_disparity_scale(text: str) -> float:
    """Return the pixels per unit that a number or a fraction names.

    Raises
    ------
    GeohueError
        If it is neither, or not positive.

    Examples
    --------
    >>> parse_disparity_scale("1/256"), parse_disparity_scale("0.5")
    (0.00390625, 0.5)
    """
    try:
        scale = float(Fraction(text.replace(" ", "")))
    except (ValueError, ZeroDivisionError, OverflowError):
        scale = 0.0
    if not 0 < scale < np.inf:
        raise GeohueError(
            f"disparity scale {text!r}: expected a positive number of pixels per unit, such as "
            "0.25 or 1/256"
        )
    return scale


def _read(path: str | Path) -> NDArray[Any]:
    readers = {".npy": read_npy, ".npz": read_npz, ".pfm": read_pfm}
    raw = readers.get(Path(path).suffix.lower(), decode_picture)(path)
    if raw.ndim == 3 and raw.shape[2] == 1:
        raw = raw[..., 0]
    if raw.ndim == 3 and raw.shape[2] == 3 and (raw == raw[..., :1]).all():
        raw = raw[..., 0]  # grey, saved with three equal channels
    if raw.ndim != 2:
        cause = f"has the shape {raw.shape}, which is a colour picture; a disparity has one channel"
        raise broken(path, f"{cause}: give the raw disparity, not its coloured rendering")
    if raw.dtype.kind not in "iuf" or raw.size == 0:
        raise broken(path, f"has no disparities ({raw.dtype}, {raw.shape}); export it again")
    return raw


def _guessed(raw: NDArray[Any], path: str | Path) -> tuple[float, tuple[str, ...]]:
    if raw.dtype.kind == "f":
        return 1.0, ()
    if raw.dtype == np.int16:
        scale, why = _FIXED_POINT, "as OpenCV's matchers write it"
    elif raw.dtype.itemsize > 1 and int(raw[raw != _SATURATED].max(initial=0)) > raw.shape[1]:
        scale, why = _KITTI, "as KITTI writes it: the values exceed the image's width"
    else:
        scale, why = 1.0, "whole pixels"
    note = f"{path}: taken as {Fraction(scale)} pixels per unit ({why})"
    return scale, (f"{note}; give disparity_scale if that is wrong",)


def _missing(raw: NDArray[Any]) -> NDArray[np.bool_]:
    if raw.dtype.kind == "f":
        with np.errstate(invalid="ignore"):
            missing: NDArray[np.bool_] = ~np.isfinite(raw) | (raw == 0)
        mark = float(raw[~missing].min(initial=0))
        if mark < 0 and mark == round(mark) and (raw == mark).mean() > _MARK_SHARE:
            missing |= raw == mark
        return missing
    missing = np.asarray(raw == 0)
    if raw.dtype.kind == "i" and (raw < 0).mean() < 0.5:
        missing |= raw < 0
    if raw.dtype == np.uint16:
        missing |= raw == _SATURATED
    return missing
