"""A fitted cut of vectors in their own units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import DTypeLike, NDArray

from geohue.compute.arrays import Floats, Rows
from geohue.compute.parallel import Workers
from geohue.ncut.model import CutModel
from geohue.ncut.nystrom import NystromCut

_FARTHEST = {np.dtype(np.float32): 4096.0, np.dtype(np.float64): 1e8}
"""Coordinates beyond are moved here: all affinities are 0 long before, and squares must be exact
to about 1 for the nearest landmark to be known."""


@dataclass(frozen=True, slots=True, eq=False)
class Scaled:
    """Vectors around 0 in units of the width, made block by block.

    Attributes
    ----------
    source : Rows
        The vectors as they are, real numbers of any type.
    center : (D,) float64
        What is taken off: large offsets cost precision.
    width : float
        What is divided by.
    dtype : numpy.dtype
        float32 or float64.
    """

    source: Rows
    center: NDArray[np.float64]
    width: float
    dtype: np.dtype[np.floating]

    def __len__(self) -> int:
        return len(self.source)

    def __getitem__(self, rows: slice) -> Floats:
        far = _FARTHEST[self.dtype]
        with np.errstate(over="ignore"):
            moved = (self.source[rows].astype(np.float64) - self.center) / self.width
        return np.clip(moved, -far, far).astype(self.dtype)


@dataclass(frozen=True, slots=True, eq=False)
class SpectralModel:
    """A fitted cut of vectors, which labels these and others.

    Attributes
    ----------
    model : CutModel
        The cut of the scaled vectors.
    center, width, dtype
        Of `Scaled`.
    """

    model: CutModel
    center: NDArray[np.float64]
    width: float
    dtype: np.dtype[np.floating]

    @property
    def cut(self) -> NystromCut:
        """The eigenvectors."""
        return self.model.cut

    def labels(self, source: Rows, team: Workers) -> NDArray[np.int32]:
        """Return the label of each vector, (M,)."""
        return self.model.labels(self._scaled(source), team)

    def embedding(self, source: Rows, team: Workers, dtype: DTypeLike) -> Floats:
        """Return the direction of each vector's eigenvector entries, (M, k) rows of length 1."""
        x, k = self._scaled(source), self.model.centers.shape[1]
        out = np.empty((len(x), k), dtype)

        def fill(rows: slice) -> None:
            out[rows] = self.cut.rows(x[rows], k)

        for _ in team.map_blocks(fill, len(x)):
            pass
        return out

    def renumbered(self, order: NDArray[np.intp]) -> SpectralModel:
        """Return the model whose label i is this one's label ``order[i]``."""
        model = CutModel(self.cut, self.model.centers[order])
        return SpectralModel(model, self.center, self.width, self.dtype)

    def _scaled(self, source: Rows) -> Scaled:
        return Scaled(source, self.center, self.width, self.dtype)
