"""The part of a frame that is compared."""

from __future__ import annotations

from typing import TypeAlias

from geohue.errors import GeohueError

Crop: TypeAlias = tuple[int, int, int, int]
"""(top, bottom, left, right), ends excluded."""

PROTOCOLS: dict[str, Crop] = {"nyu": (44, 471, 40, 601)}
"""Named crops. ``nyu``: the valid part of NYU Depth V2, outside of which the undistorted pictures
have a border and made-up depth."""


def window(crop: Crop, shape: tuple[int, ...]) -> tuple[slice, slice]:
    """Return a crop as slices, or refuse one that does not fit.

    Examples
    --------
    >>> window((1, 3, 0, 4), (5, 6))
    (slice(1, 3, None), slice(0, 4, None))
    """
    top, bottom, left, right = crop
    if len(shape) != 2 or not (0 <= top < bottom <= shape[0] and 0 <= left < right <= shape[1]):
        raise GeohueError(
            f"crop {tuple(crop)} does not fit labels of shape {shape}: give "
            "(top, bottom, left, right) inside an (H, W) label map, ends excluded"
        )
    return slice(top, bottom), slice(left, right)
