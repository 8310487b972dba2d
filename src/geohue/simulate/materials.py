"""Colours of surfaces: a base colour with grain, a pattern, or neither, fixed to the surface.

The texture is a function of the place in the world, so that two cameras see the same one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geohue.simulate.shapes import Floats, Vector

_PRIMES = np.array([73856093, 19349663, 83492791], np.int64)
_VALUES = np.random.default_rng(2012).uniform(-1, 1, 1 << 14)
"""What the hashed lattice points (Teschner et al. 2003) are given."""


@dataclass(frozen=True, slots=True)
class Material:
    """How a surface looks.

    Attributes
    ----------
    color : tuple of float
        sRGB, 0..255.
    grain : float
        Strength of the irregular texture, 0..1.
    cell : float
        Size of its coarsest structure in metres; the two finer ones are half and a quarter.
    stripes : float
        Width of stripes in metres; 0 for none.
    second : tuple of float
        Colour of every other stripe.
    """

    color: Vector
    grain: float = 0.25
    cell: float = 0.04
    stripes: float = 0.0
    second: Vector = (230.0, 230.0, 230.0)

    def colors(self, points: Floats) -> Floats:
        """Return the colour at each point, (M, 3), before light."""
        base = np.broadcast_to(np.array(self.color, np.float64), points.shape)
        if self.stripes > 0:
            odd = np.floor((points @ np.array([1.0, 0.35, 0.6])) / self.stripes) % 2 > 0
            base = np.where(odd[:, None], np.array(self.second), base)
        if self.grain == 0:
            return base
        return np.asarray(base * (1 + self.grain * grain(points, self.cell))[:, None])


def grain(points: Floats, cell: float) -> Floats:
    """Value noise of three octaves, -1..1 (Perlin 1985 calls it solid texture).

    Examples
    --------
    >>> float(np.abs(grain(np.random.default_rng(0).random((100, 3)), 0.1)).max()) <= 1
    True
    """
    total = np.zeros(len(points))
    for octave, share in enumerate((0.5, 0.3, 0.2)):
        total += share * _value_noise(points * (2**octave / cell), octave)
    return total


def _value_noise(points: Floats, octave: int) -> Floats:
    """Random values at whole coordinates, smoothly interpolated between."""
    corner = np.floor(points)
    rest = points - corner
    smooth = rest * rest * (3 - 2 * rest)
    keys = corner.astype(np.int64) * _PRIMES + octave
    total = np.zeros(len(points))
    for step in np.ndindex(2, 2, 2):
        place = np.bitwise_xor.reduce(keys + np.array(step) * _PRIMES, axis=1)
        share = [smooth[:, i] if step[i] else 1 - smooth[:, i] for i in range(3)]
        total += share[0] * share[1] * share[2] * _VALUES[place & (len(_VALUES) - 1)]
    return total
