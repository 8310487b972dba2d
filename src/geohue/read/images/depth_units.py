"""Units of depth pictures by name: what ``--depth-scale`` takes beside a number."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.errors import GeohueError
from geohue.plugins import Registry

Decoder = Callable[[NDArray[np.uint16]], NDArray[np.floating[Any]]]


@dataclass(frozen=True, slots=True)
class DepthUnit:
    """How the values of a depth picture become metres.

    Parameters
    ----------
    scale : float
        Metres per unit (of the decoded value).
    decode : callable, optional
        Turns 16-bit values into units first: rotated bits, raw disparities.
    """

    scale: float
    decode: Decoder | None = None


def _sun(values: NDArray[np.uint16]) -> NDArray[np.floating[Any]]:
    """SUN RGB-D keeps millimetres rotated by three bits."""
    return ((values >> 3) | (values << 13)).astype(np.float64)


def _nyu_raw(values: NDArray[np.uint16]) -> NDArray[np.floating[Any]]:
    """NYU v2 raw keeps Kinect disparities with their two bytes exchanged."""
    from geohue.sensors.kinect import DisparityModel

    swapped = values.byteswap()
    # The toolbox: Z = 351.3 / (1092.5 - d), at most 10 m.
    model = DisparityModel(1092.5 / 351.3, -1 / 351.3)
    depth = model.depth(np.minimum(swapped, 2047))
    return np.where(depth <= 10, depth, np.nan)


def _kinect(values: NDArray[np.uint16]) -> NDArray[np.floating[Any]]:
    from geohue.sensors.kinect import DisparityModel

    return DisparityModel().depth(values)


_OWN = {
    "m": DepthUnit(1.0),
    "mm": DepthUnit(0.001),
    "cm": DepthUnit(0.01),
    "tum": DepthUnit(1 / 5000),
    "icl": DepthUnit(1 / 5000),
    "redwood": DepthUnit(0.001),
    "open3d": DepthUnit(0.001),
    "scannet": DepthUnit(0.001),
    "7scenes": DepthUnit(0.001),
    "realsense": DepthUnit(0.001),
    "l515": DepthUnit(0.00025),
    "azure": DepthUnit(0.001),
    "bop": DepthUnit(0.001),
    "bop-0.1": DepthUnit(0.0001),
    "kitti": DepthUnit(1 / 256),
    "sun": DepthUnit(0.001, _sun),
    "nyu-raw": DepthUnit(1.0, _nyu_raw),
    "kinect": DepthUnit(1.0, _kinect),
}

DEPTH_UNITS: Registry[DepthUnit] = Registry(
    "sensors", _OWN, lambda value: isinstance(value, DepthUnit), "a DepthUnit"
)
"""The units by name, those of plugins included. "bop" is BOP's depth_scale 1.0; a BOP folder's own
file is read as a data set. "kinect" is 11-bit raw disparity, by the values of a typical Kinect."""


def register_sensor(name: str, unit: DepthUnit) -> DepthUnit:
    """Let ``depth_scale=`` and ``--depth-scale`` take a sensor by its name.

    Parameters
    ----------
    name : str
        A new name, in lower case.
    unit : DepthUnit
        How the values of its depth pictures become metres.

    Returns
    -------
    DepthUnit
        The unit itself.

    Raises
    ------
    GeohueError
        For a name that is taken.

    Examples
    --------
    >>> tof = register_sensor("tof", DepthUnit(0.001, lambda values: values & 0x1FFF))
    >>> depth_unit("tof").decode(np.array([8193], np.uint16)).tolist()
    [1]
    >>> DEPTH_UNITS.remove("tof")
    """
    DEPTH_UNITS.add(name, unit)
    return unit


def depth_unit(given: float | str | DepthUnit) -> DepthUnit:
    """Return the unit for a number of metres, or a name.

    Raises
    ------
    GeohueError
        For an unknown name or a number that is not positive.

    Examples
    --------
    >>> depth_unit("tum").scale, depth_unit("0.001").scale
    (0.0002, 0.001)
    >>> depth_unit("foot")
    Traceback (most recent call last):
    geohue.errors.GeohueError: depth scale 'foot': expected metres per unit or one of m, mm, ...
    """
    if isinstance(given, DepthUnit):
        return given
    if isinstance(given, str) and given.strip().lower() in DEPTH_UNITS:
        return DEPTH_UNITS[given.strip().lower()]
    try:
        scale = float(given)
    except (TypeError, ValueError):
        names = ", ".join(DEPTH_UNITS)
        raise GeohueError(
            f"depth scale {given!r}: expected metres per unit or one of {names}"
        ) from None
    if not 0 < scale < np.inf:
        raise GeohueError(f"depth scale {scale}: must be a positive number of metres per unit")
    return DepthUnit(scale)
