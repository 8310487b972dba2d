"""Depth pictures and raw disparities of the depth camera of a rig."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from geohue.read.images.depth_units import DepthUnit, depth_unit
from geohue.read.images.pictures import DepthImage, decode_picture, read_depth
from geohue.sensors.rig import Rig


def read_range(path: str | Path, rig: Rig, depth_scale: float | str | None = None) -> DepthImage:
    """Read a depth picture or raw disparities of a rig's depth camera."""
    given: float | str | DepthUnit | None = depth_scale
    if given is None and rig.depth_unit is not None:
        given = rig.depth_unit
    model = rig.disparity
    named = isinstance(given, str) and given.strip().lower() == "kinect"
    if model is not None and (named or (given is None and looks_raw(path))):
        return read_depth(path, DepthUnit(1.0, model.depth))
    return read_depth(path, None if given is None else depth_unit(given))


def looks_raw(path: str | Path) -> bool:
    """Whether a picture holds 11-bit disparities: all at most 2047, and 2047 the mark for none."""
    raw = decode_picture(path)
    return raw.ndim == 2 and raw.dtype == np.uint16 and int(raw.max()) == 2047
