"""A cut that is ready to label points: those it was made from, or any others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.compute.arrays import Rows
from geohue.compute.parallel import Workers
from geohue.ncut.nystrom import NystromCut


@dataclass(frozen=True, slots=True, eq=False)
class CutModel:
    """Eigenvectors known everywhere, and the direction of each segment among them.

    Attributes
    ----------
    cut : NystromCut
        The eigenvectors.
    centers : (k, m) float64
        The directions (`find_centers`).
    """

    cut: NystromCut
    centers: NDArray[np.float64]

    @property
    def k(self) -> int:
        """Number of segments, some of which may stay empty."""
        return len(self.centers)

    def labels(self, vectors: Rows, workers: Workers) -> NDArray[np.int32]:
        """Label points by the Nystrom extension.

        Parameters
        ----------
        vectors : (M, D) float
            Points, as mixed and normalised as those of the fit.
        workers : Workers
            Threads to use.

        Returns
        -------
        (M,) int32
            0 to k - 1.
        """
        if self.k == 1:
            return np.zeros(len(vectors), np.int32)
        kernel, basis = self.cut.kernel, self.cut.basis[:, : self.centers.shape[1]]
        parts = workers.map_blocks(
            lambda rows: kernel.nearest(vectors[rows], basis, self.centers), len(vectors)
        )
        return np.concatenate(list(parts))
