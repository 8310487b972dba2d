"""The affinities of many points to a few landmarks, used where they are made."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.arrays import Floats
from geohue.ncut.affinity import FAINTEST


@dataclass(frozen=True, slots=True, eq=False)
class Kernel:
    """The Gaussian of `geohue.ncut.affinity.affinity` to fixed landmarks, in compiled loops.

    Each method takes the points of one block and gives the same answer whatever block they come
    in, but for `column_sums` and `gram`, which are sums over it. They hold no lock: threads run
    them side by side.

    Attributes
    ----------
    gain : float
        ``sqrt(log2(e)) / scale``: what turns the squared distance into a power of two.
    z : (D', n) float
        The landmarks times `gain`, a column each; D' is D rounded up to a multiple of three.
    half : (n,) float
        ``-|z|^2 / 2``.

    Examples
    --------
    >>> x = np.array([[0.0, 0.0], [0.6, 0.0]], np.float32)
    >>> Kernel.of(x, scale=0.6)(x).round(4).tolist()
    [[1.0, 0.6065...], [0.6065..., 1.0]]
    """

    gain: np.floating[Any]
    z: Floats
    half: Floats

    @classmethod
    def of(cls, landmarks: Floats, scale: float) -> Kernel:
        """Prepare the landmarks, (n, D); points must come in the same type."""
        gain = landmarks.dtype.type(math.sqrt(math.log2(math.e)) / scale)
        z = np.ascontiguousarray(_in_multiples(landmarks * gain, 3, axis=1).T)
        return cls(gain, z, np.asarray(-0.5 * np.einsum("ij,ij->j", z, z), z.dtype))

    def __len__(self) -> int:
        return len(self.half)

    def __call__(self, vectors: Floats) -> Floats:
        """Return the affinities, (N, n)."""
        from geohue.ncut import loops

        out = np.empty((len(vectors), len(self)), vectors.dtype)
        self._run(loops.affinities, vectors, out)
        return out

    def column_sums(self, vectors: Floats) -> Floats:
        """Return the sum of each landmark's affinities over the points, (n,)."""
        from geohue.ncut import loops

        out = np.empty(len(self), vectors.dtype)
        self._run(loops.add_columns, vectors, self._row(), out)
        return out

    def gram(self, vectors: Floats, to_degree: Floats) -> Floats:
        """Return ``C^T D^-1 C``, (n, n), with the degrees ``max(C @ to_degree, 1)``."""
        from geohue.ncut import loops

        c = np.empty((len(vectors), len(self)), vectors.dtype)
        self._run(loops.normalized, vectors, to_degree, c)
        return np.asarray(c.T @ c)

    def project(self, vectors: Floats, basis: Floats) -> Floats:
        """Return the affinities times `basis` (n, k), (N, k)."""
        from geohue.ncut import loops

        rows = _in_multiples(basis.T, 4, axis=0)
        out = np.empty((len(vectors), len(rows)), vectors.dtype)
        self._run(loops.project, vectors, rows, self._row(), out)
        return out[:, : basis.shape[1]]

    def nearest(self, vectors: Floats, basis: Floats, centers: Floats) -> NDArray[np.int32]:
        """Return the nearest of `centers` (K, k) to each projection brought to length 1, (N,)."""
        from geohue.ncut import loops

        out = np.empty(len(vectors), np.int32)
        rows = _in_multiples(basis.T, 4, axis=0)
        entry = np.empty((1, len(rows)), vectors.dtype)
        wanted = _in_multiples(centers.astype(vectors.dtype), 4, axis=1)
        offsets = 0.5 * np.einsum("ij,ij->i", wanted, wanted)
        self._run(loops.nearest, vectors, rows, wanted, offsets, self._row(), entry, out)
        return out

    def _row(self) -> Floats:
        """Room for the affinities of one point."""
        return np.empty((1, len(self)), self.z.dtype)

    def _run(self, loop: Callable[..., np.floating[Any]], vectors: Floats, *arrays: Any) -> None:
        """Run a loop, and once more with lifted points if some are faint.

        A loop returns the least sum of a point's affinities, which tells that at no cost.
        """
        from geohue.ncut.loops import lifts

        x = _in_multiples(vectors, 3, axis=1)
        lift = np.zeros(len(x), x.dtype)
        mine = (self.gain, self.z, self.half)
        if loop(x, lift, *mine, *arrays) < len(self) * math.exp(FAINTEST):
            lifts(x, FAINTEST / math.log(2), *mine, self._row(), lift)
            loop(x, lift, *mine, *arrays)


def _in_multiples(values: Floats, number: int, axis: int) -> Floats:
    """Add zeros, which change no product, up to a multiple of `number` along an axis."""
    missing = -values.shape[axis] % number
    if missing:
        width = [(0, 0), (0, 0)]
        width[axis] = (0, missing)
        values = np.pad(values, width)
    return np.ascontiguousarray(values)
