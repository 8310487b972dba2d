"""Slow, readable twins of the normalized cut."""

from __future__ import annotations

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

Array = NDArray[np.float64]


def dense_affinity(x: Array, z: Array, scale: float) -> Array:
    """The Gaussian, pair by pair."""
    w = np.empty((len(x), len(z)))
    for i, p in enumerate(x):
        for j, q in enumerate(z):
            w[i, j] = np.exp(-float(((p - q) ** 2).sum()) / (2 * scale**2))
    return w


def exact_cut(w: Array, m: int) -> tuple[Array, Array]:
    """Leading eigenpairs of D^-1/2 W D^-1/2 (Shi and Malik 2000)."""
    d = w.sum(axis=1)
    values, vectors = scipy.linalg.eigh(w / np.sqrt(np.outer(d, d)))
    return values[::-1][:m], vectors[:, ::-1][:, :m]


def two_step_nystrom(a: Array, b: Array, m: int) -> tuple[Array, Array]:
    """The two-step Nystrom method of Fowlkes et al., with W = [A B; B' C].

    First the eigenvectors of the approximation [A; B'] A^-1 [A B], then those are made
    orthogonal; the normalization comes before both.
    """
    n, rest = a.shape[0], b.shape[1]
    d1 = a.sum(axis=1) + b.sum(axis=1)
    d2 = b.sum(axis=0) + b.T @ np.linalg.solve(a, b.sum(axis=1))
    d = np.sqrt(1 / np.concatenate([d1, d2]))
    a, b = a * np.outer(d[:n], d[:n]), b * np.outer(d[:n], d[n:])
    values, u = scipy.linalg.eigh(a)
    extended = np.vstack([u, b.T @ u / values])  # step 1: extend the eigenvectors of A
    # Step 2: Z Z' = E L E', with Z = E sqrt(L), has the eigenvectors of Z'Z.
    z = extended * np.sqrt(values)
    sizes, f = scipy.linalg.eigh(z.T @ z)
    vectors = z @ f / np.sqrt(sizes)
    assert vectors.shape[0] == n + rest
    return sizes[::-1][:m], vectors[:, ::-1][:, :m]


def one_shot_nystrom(a: Array, b: Array, m: int) -> tuple[Array, Array]:
    """The one-shot Nystrom method of Fowlkes et al. for a positive definite A, as printed."""
    n = a.shape[0]
    d1 = a.sum(axis=1) + b.sum(axis=1)
    d2 = b.sum(axis=0) + b.T @ np.linalg.solve(a, b.sum(axis=1))
    d = np.sqrt(1 / np.concatenate([d1, d2]))
    a, b = a * np.outer(d[:n], d[:n]), b * np.outer(d[:n], d[n:])
    root = np.linalg.inv(np.real(scipy.linalg.sqrtm(a)))
    r = a + root @ b @ b.T @ root
    values, u = scipy.linalg.eigh(r)
    vectors = np.vstack([a, b.T]) @ root @ u / np.sqrt(values)
    return values[::-1][:m], vectors[:, ::-1][:, :m]


def aligned(vectors: Array, reference: Array) -> Array:
    """Flip each column so that it points the way of the reference's."""
    return np.asarray(vectors * np.sign((vectors * reference).sum(axis=0)))
