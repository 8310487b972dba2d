"""Sec. III: the normalized cut of all points from their affinities to a few landmarks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from geohue.arrays import Floats
from geohue.ncut.affinity import SCALE, affinity
from geohue.parallel import Workers

MEMORY = 256 * 2**20
"""Bytes of affinities kept between the passes; beyond it they are computed again."""


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
    landmarks : (n, D) float
        The landmarks' vectors.
    to_degree : (n,) float
        ``c @ to_degree`` is the degree of a point.
    scale : float
        The width of the affinity.
    """

    eigenvalues: NDArray[np.float64]
    basis: Floats
    landmarks: Floats
    to_degree: Floats
    scale: float

    def entries(self, vectors: Floats, k: int) -> Floats:
        """Return each point's entries in the first `k` eigenvectors, (M, k)."""
        c = affinity(vectors, self.landmarks, self.scale)
        return np.asarray(c @ self.basis[:, :k] / np.sqrt(_degrees(c, self.to_degree))[:, None])

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
        entries = affinity(vectors, self.landmarks, self.scale) @ self.basis[:, :k]
        length = np.sqrt(np.einsum("ij,ij->i", entries, entries))
        tiny = np.finfo(entries.dtype).tiny
        return np.asarray(entries / np.maximum(length, tiny)[:, None])


def nystrom_cut(
    vectors: Floats,
    landmarks: Floats,
    workers: Workers,
    m: int,
    scale: float = SCALE,
    memory: int = MEMORY,
) -> NystromCut:
    r"""Find the leading eigenvectors of the normalized cut by the Nystrom method.

    With A the affinities among the landmarks and C those of all points to them, the whole
    affinity matrix is taken as :math:`C A^{-1} C^T`, whose rows for the landmarks are exact. This
    is the one-shot method of Fowlkes et al.; written with C it needs the N x n affinities only
    block by block:

    1. degrees :math:`d = C A^{-1} (C^T 1)`,
    2. :math:`G = A^{-1/2} (C^T D^{-1} C) A^{-1/2} = U \Lambda U^T`, n x n,
    3. eigenvectors :math:`V = D^{-1/2} C A^{-1/2} U \Lambda^{-1/2}`.

    A is singular when landmarks coincide: directions in which it is numerically zero are left
    out. The approximation can bring a degree near or below zero: degrees are kept at 1 or more,
    since every point has the affinity 1 to itself.

    Parameters
    ----------
    vectors : (N, D) float32 or float64
        All points.
    landmarks : (n, D) float, the same type
        The landmarks, usually some of the points.
    workers : Workers
        Threads to use.
    m : int
        Number of eigenvectors wanted; fewer are returned if the landmarks span fewer.
    scale : float
        Width of the affinity.
    memory : int
        Bytes of affinities that may be kept between the passes.

    Returns
    -------
    NystromCut

    References
    ----------
    C. Fowlkes, S. Belongie, F. Chung, J. Malik, "Spectral grouping using the Nystrom method",
    PAMI 26(2), 2004.

    Examples
    --------
    >>> from geohue.parallel import workers
    >>> x = np.repeat([[0.0], [9.0]], 5, axis=0)
    >>> with workers(1) as team:
    ...     cut = nystrom_cut(x, x[[0, 5]], team, m=2)
    >>> cut.eigenvalues.round(6).tolist()
    [1.0, 1.0]
    """
    factor = _inverse_root(
        affinity(landmarks.astype(np.float64), landmarks.astype(np.float64), scale), vectors.dtype
    )
    block_of = _affinity_blocks(vectors, landmarks, scale, memory)
    total = np.zeros(len(landmarks))
    for part in workers.map_blocks(lambda rows: block_of(rows).sum(axis=0), len(vectors)):
        total += part
    to_degree = (factor @ (factor.T @ total)).astype(vectors.dtype)

    def gram(rows: slice) -> Floats:
        c = block_of(rows)
        weighted = c / np.sqrt(_degrees(c, to_degree))[:, None]
        return np.asarray(weighted.T @ weighted)

    middle = np.zeros((len(landmarks), len(landmarks)))
    for part in workers.map_blocks(gram, len(vectors)):
        middle += part
    values, directions = scipy.linalg.eigh(factor.T @ middle @ factor)
    values, directions = values[::-1][:m], directions[:, ::-1][:, :m]
    used = values > 1e-6 * max(values[0], 1e-300)
    values, directions = values[used], directions[:, used]
    basis = factor @ (directions / np.sqrt(values))
    basis = _signed(basis).astype(vectors.dtype)
    return NystromCut(values, basis, landmarks, to_degree, scale)


def _degrees(c: Floats, to_degree: Floats) -> Floats:
    return np.maximum(c @ to_degree, 1)


def _inverse_root(a: Floats, dtype: np.dtype[np.floating]) -> NDArray[np.float64]:
    """Return F with ``F F^T`` the pseudo-inverse of `a`, without its numerically empty part.

    The cut-off follows the precision of the affinities that F will be applied to.
    """
    values, vectors = scipy.linalg.eigh(a)
    keep = values > values[-1] * 10 * np.finfo(dtype).eps * len(a)
    return np.asarray(vectors[:, keep] / np.sqrt(values[keep]))


def _affinity_blocks(
    vectors: Floats, landmarks: Floats, scale: float, memory: int
) -> Callable[[slice], Floats]:
    """Return a function from rows to their affinities, which remembers them if memory allows."""
    kept: dict[int, Floats] = {}
    remember = len(vectors) * len(landmarks) * vectors.itemsize <= memory

    def block_of(rows: slice) -> Floats:
        block = kept.get(rows.start)
        if block is None:
            block = affinity(vectors[rows], landmarks, scale)
            if remember:
                kept[rows.start] = block
        return block

    return block_of


def _signed(basis: Floats) -> Floats:
    """Fix the sign of each eigenvector, which the solver leaves open: largest entry positive."""
    largest = basis[np.abs(basis).argmax(axis=0), np.arange(basis.shape[1])]
    return np.asarray(basis * np.where(largest < 0, -1.0, 1.0))
