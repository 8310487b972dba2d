"""Sec. III: the normalized cut of all points from their affinities to a few landmarks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.compute.arrays import Floats, Rows
from geohue.compute.parallel import Workers
from geohue.ncut.affinity import affinity
from geohue.ncut.kernel import Kernel
from geohue.settings.cut import SCALE


@dataclass(frozen=True, slots=True, eq=False)
class NystromCut:
    """The leading eigenvectors of a normalized affinity matrix, ready to be read off anywhere.

    Attributes
    ----------
    eigenvalues : (m,) float64
        Of the normalized affinity, in decreasing order; 1 is the largest of an exact one.
    basis : (n, m) float
        A point with affinities c to the landmarks and degree d has the eigenvector entries
        ``c @ basis / sqrt(d)``.
    to_degree : (n,) float
        ``c @ to_degree`` is the degree of a point.
    kernel : Kernel
        The affinities c.
    """

    eigenvalues: NDArray[np.float64]
    basis: Floats
    to_degree: Floats
    kernel: Kernel

    def entries(self, vectors: Floats, k: int) -> Floats:
        """Return each point's entries in the first `k` eigenvectors, (M, k)."""
        both = self.kernel.project(vectors, np.c_[self.basis[:, :k], self.to_degree])
        return np.asarray(both[:, :k] / np.sqrt(np.maximum(both[:, k:], 1)))

    def rows(self, vectors: Floats, k: int) -> Floats:
        """Return the direction of each point's first `k` eigenvector entries.

        The degree scales a point's entries alike and so does not change the direction.

        Parameters
        ----------
        vectors : (M, D) float
            Points: those of the fit or any others.
        k : int
            Number of eigenvectors, at most m.

        Returns
        -------
        (M, k) float
            Rows of length 1 (Ng, Jordan and Weiss 2002).
        """
        return unit_rows(self.kernel.project(vectors, self.basis[:, :k]))


def unit_rows(entries: Floats) -> Floats:
    """Bring each row to length 1."""
    length = np.sqrt(np.einsum("ij,ij->i", entries, entries))
    tiny = np.finfo(entries.dtype).tiny
    return np.asarray(entries / np.maximum(length, tiny)[:, None])


def nystrom_cut(
    vectors: Rows,
    landmarks: Floats,
    workers: Workers,
    m: int,
    scale: float = SCALE,
    weights: Floats | None = None,
) -> NystromCut:
    r"""Find the leading eigenvectors of the normalized cut by the Nystrom method.

    With A the affinities among the landmarks and C those of all points to them, the whole
    affinity matrix is taken as :math:`C A^{-1} C^T`, whose rows for the landmarks are exact. This
    is the one-shot method of Fowlkes et al.; written with C it needs the N x n affinities only
    block by block, and they are never stored:

    1. degrees :math:`d = C A^{-1} (C^T 1)`,
    2. :math:`G = A^{-1/2} (C^T D^{-1} C) A^{-1/2} = U \Lambda U^T`, n x n,
    3. eigenvectors :math:`V = D^{-1/2} C A^{-1/2} U \Lambda^{-1/2}`.

    A is singular when landmarks coincide: directions in which it is numerically zero are left
    out. The approximation can bring a degree near or below zero: degrees are kept at 1 or more,
    since every point has the affinity 1 to itself.

    Parameters
    ----------
    vectors : (N, D) float32 or float64
        All points: an array, or what reads them block by block.
    landmarks : (n, D) float, the same type
        The landmarks, usually some of the points.
    workers : Workers
        Threads to use.
    m : int
        Number of eigenvectors wanted; fewer are returned if the landmarks span fewer.
    scale : float
        Width of the affinity.
    weights : (N,) float, optional
        As how many coinciding points each counts, positive; by default 1. With the diagonal
        matrix W of them, the degrees are :math:`C A^{-1} (C^T W 1)`, at least the point's own
        weight, and D^-1 in the sum becomes W D^-1.

    Returns
    -------
    NystromCut

    References
    ----------
    C. Fowlkes, S. Belongie, F. Chung, J. Malik, "Spectral grouping using the Nystrom method",
    PAMI 26(2), 2004.

    Examples
    --------
    >>> from geohue.compute.parallel import workers
    >>> x = np.repeat([[0.0], [9.0]], 5, axis=0)
    >>> with workers(1) as team:
    ...     cut = nystrom_cut(x, x[[0, 5]], team, m=2)
    >>> cut.eigenvalues.round(6).tolist()
    [1.0, 1.0]
    """
    exact = landmarks.astype(np.float64)
    factor = _inverse_root(affinity(exact, exact, scale), vectors.dtype)
    kernel = Kernel.of(landmarks, scale)
    total = np.zeros(len(landmarks))
    for part in workers.map_blocks(
        lambda rows: kernel.column_sums(vectors[rows], _part(weights, rows)), len(vectors)
    ):
        total += part
    to_degree = (factor @ (factor.T @ total)).astype(vectors.dtype)
    middle = np.zeros((len(landmarks), len(landmarks)))
    for part in workers.map_blocks(
        lambda rows: kernel.gram(vectors[rows], to_degree, _part(weights, rows)), len(vectors)
    ):
        middle += part
    # NumPy's eigh lets other threads run meanwhile, SciPy's does not.
    values, directions = np.linalg.eigh(factor.T @ middle @ factor)
    values, directions = values[::-1][:m], directions[:, ::-1][:, :m]
    used = values > 1e-6 * max(values[0], 1e-300)
    values, directions = values[used], directions[:, used]
    basis = factor @ (directions / np.sqrt(values))
    return NystromCut(values, _signed(basis).astype(vectors.dtype), to_degree, kernel)


def _part(weights: Floats | None, rows: slice) -> Floats | None:
    return None if weights is None else weights[rows]


def _inverse_root(a: Floats, dtype: np.dtype[np.floating]) -> NDArray[np.float64]:
    """Return F with ``F F^T`` the pseudo-inverse of `a`, without its numerically empty part.

    The cut-off follows the precision of the affinities that F will be applied to.
    """
    values, vectors = np.linalg.eigh(a)
    keep = values > values[-1] * 10 * np.finfo(dtype).eps * len(a)
    return np.asarray(vectors[:, keep] / np.sqrt(values[keep]))


def _signed(basis: Floats) -> Floats:
    """Fix the sign of each eigenvector, which the solver leaves open: largest entry positive."""
    largest = basis[np.abs(basis).argmax(axis=0), np.arange(basis.shape[1])]
    return np.asarray(basis * np.where(largest < 0, -1.0, 1.0))
