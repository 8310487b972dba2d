"""Sec. II for a part of a cloud: its vectors, normalised by the moments of the whole (eq. 1-5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.features import FLOOR, SAME_COLOR, SAME_PLACE, Block, Features, lab_of
from geohue.large.moments import Moments

_COLOR, _GEOMETRY = slice(0, 3), slice(3, 6)


def raw_values(
    xyz: NDArray[np.float64], rgb: NDArray[np.uint8], cues: str
) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """Return which points take part, and L, a, b, x, y, z of those.

    Parameters
    ----------
    xyz : (M, 3) float64
        Coordinates, NaN where missing.
    rgb : (M, 3) uint8
        sRGB.
    cues : {"fusion", "color", "geometry"}
        A cue that is not used is zero.

    Returns
    -------
    known : (M,) bool
        Points with coordinates; all of them where colour alone counts.
    values : (U, 6) float64
        A row for each of those, stored column by column.
    """
    known = np.full(len(xyz), True)
    if cues != "color":
        known = np.asarray(np.isfinite(xyz).all(axis=1))
    values = np.zeros((6, int(known.sum()))).T
    if cues != "geometry":
        values[:, _COLOR] = lab_of(rgb[known])
    if cues != "color":
        values[:, _GEOMETRY] = xyz[known]
    return known, values


@dataclass(frozen=True, slots=True, eq=False)
class Standard:
    """What the values of a cloud are normalised by (eq. 3, 4).

    Attributes
    ----------
    mean : (6,) float64
        Of L, a, b, x, y, z.
    sigma : (2,) float64
        Mean of the three deviations of colour and of geometry; 0 for a cue that does not vary.
    cues : {"fusion", "color", "geometry"}
        The cues in use.
    """

    mean: NDArray[np.float64]
    sigma: NDArray[np.float64]
    cues: str

    @classmethod
    def of(cls, moments: Moments, cues: str) -> Standard:
        """Return the standard of a cloud with these moments of its `raw_values`."""
        sigma = np.zeros(2)
        for i, part in enumerate((_COLOR, _GEOMETRY)):
            spread = float(moments.deviation[part].mean())
            if spread > FLOOR * _size(moments.low[part], moments.high[part]):
                sigma[i] = spread
        return cls(moments.mean, sigma, cues)

    def features(self, values: NDArray[np.float64], known: NDArray[np.bool_]) -> Features:
        """Normalise the `raw_values` of a part.

        Parameters
        ----------
        values : (U, 6) float64
            The values.
        known : (M,) bool
            Whose they are.

        Returns
        -------
        Features
            Of the U points among M.
        """
        parts = []
        for part, sigma in zip((_COLOR, _GEOMETRY), self.sigma, strict=True):
            centred = values[:, part] - self.mean[part]
            scaled = centred / sigma if sigma > 0 else np.zeros_like(centred)
            parts.append(np.ascontiguousarray(scaled, np.float32))
        blocks = (
            Block("color", "color", parts[0], used=self.cues != "geometry"),
            Block("geometry", "geometry", parts[1], used=self.cues != "color"),
        )
        index = np.flatnonzero(known)
        return Features(blocks, index, known.shape, self.cues, self.notes)

    @property
    def notes(self) -> tuple[str, ...]:
        """What the user should know: a cue in use that does not vary."""
        used = (self.cues != "geometry", self.cues != "color")
        return tuple(
            note
            for note, use, sigma in zip((SAME_COLOR, SAME_PLACE), used, self.sigma, strict=True)
            if use and sigma == 0
        )


def _size(low: NDArray[np.float64], high: NDArray[np.float64]) -> float:
    """Return the largest number of a cue, less the offset of map coordinates (`centered`)."""
    farthest, extent = float(np.abs([low, high]).max()), float((high - low).max())
    return extent if farthest > 1e3 * max(extent, 1e-300) else farthest
