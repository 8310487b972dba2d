"""The affinities of many points to a few landmarks, used where they are made."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geohue.compute.arrays import Floats
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
        self._run(loops.affinities, vectors, (), out)
        return out

    def column_sums(self, vectors: Floats, weights: Floats | None = None) -> Floats:
        """Return the sum of each landmark's affinities over the points, (n,).

        A point of weight w counts as w points (`weights`, (N,), positive; None: all 1).
        Faint points are not raised here, nor in `gram`: either way they add nothing.
        """
        from geohue.ncut import loops

        out = np.zeros(len(self), vectors.dtype)
        x, w = _in_multiples(vectors, 3, axis=1), _weights(weights, vectors)
        loops.add_columns(x, w, *self._parts(), self._row(), out)
        return out

    def gram(self, vectors: Floats, to_degree: Floats, weights: Floats | None = None) -> Floats:
        """Return ``C^T W D^-1 C``, (n, n), with the degrees ``max(C @ to_degree, weights)``."""
        from geohue.ncut import loops

        c = np.empty((len(vectors), len(self)), vectors.dtype)
        x, w = _in_multiples(vectors, 3, axis=1), _weights(weights, vectors)
        loops.normalized(x, w, *self._parts(), to_degree, c)
        return np.asarray(c.T @ c)

    def project(self, vectors: Floats, basis: Floats) -> Floats:
        """Return the affinities times `basis` (n, k), (N, k)."""
        from geohue.ncut import loops

        rows = _in_multiples(basis.T, 4, axis=0)
        out = np.empty((len(vectors), len(rows)), vectors.dtype)
        self._run(loops.project, vectors, (rows, self._row()), out)
        return out[:, : basis.shape[1]]

    def nearest(self, vectors: Floats, basis: Floats, centers: Floats) -> NDArray[np.int32]:
        """Return the nearest of `centers` (K, k) to each projection brought to length 1, (N,)."""
        from geohue.ncut import loops

        out = np.empty(len(vectors), np.int32)
        rows = _in_multiples(basis.T, 4, axis=0)
        wanted = _in_multiples(centers.astype(vectors.dtype), 4, axis=1)
        offsets = 0.5 * np.einsum("ij,ij->i", wanted, wanted)
        entry = np.empty((1, len(rows)), vectors.dtype)
        self._run(loops.nearest, vectors, (rows, wanted, offsets, self._row(), entry), out)
        return out

    def _parts(self) -> tuple[np.floating[Any], Floats, Floats]:
        return self.gain, self.z, self.half

    def _row(self) -> Floats:
        """Room for the affinities of one point."""
        return np.empty((1, len(self)), self.z.dtype)

    def _run(
        self,
        loop: Callable[..., None],
        vectors: Floats,
        arrays: tuple[Floats, ...],
        out: NDArray[Any],
    ) -> None:
        """Run a loop over all points, then once more, raised, over the faint ones."""
        from geohue.ncut.loops import lifts

        x = _in_multiples(vectors, 3, axis=1)
        totals, lift = np.empty(len(x), x.dtype), np.zeros(len(x), x.dtype)
        loop(x, lift, *self._parts(), *arrays, totals, out)
        faint = np.flatnonzero(totals < len(self) * math.exp(FAINTEST))
        if len(faint):
            x, lift, totals, raised = x[faint], lift[faint], totals[faint], out[faint]
            lifts(x, FAINTEST / math.log(2), *self._parts(), self._row(), lift)
            loop(x, lift, *self._parts(), *arrays, totals, raised)
            out[faint] = raised


def _weights(weights: Floats | None, vectors: Floats) -> Floats:
    """Return the weights in the type of the points, ones where there are none."""
    if weights is None:
        return np.ones(len(vectors), vectors.dtype)
    return np.ascontiguousarray(weights, vectors.dtype)


def _in_multiples(values: Floats, number: int, axis: int) -> Floats:
    """Add zeros, which change no product, up to a multiple of `number` along an axis."""
    missing = -values.shape[axis] % number
    if missing:
        shape = list(values.shape)
        shape[axis] = missing
        values = np.concatenate([values, np.zeros(shape, values.dtype)], axis)
    return np.ascontiguousarray(values)
