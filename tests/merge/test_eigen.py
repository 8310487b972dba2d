"""Eigenvalues in closed form against LAPACK."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from geohue.merge.eigen import covariance, eigenvalue, eigenvector
from geohue.merge.table import PRODUCTS

Floats = NDArray[np.float64]
law = settings(deadline=None, max_examples=150)
scales = st.sampled_from([1e-60, 1e-24, 1e-12, 1e-3, 1.0, 1e12, 1e60])
spectra = st.lists(
    st.one_of(st.integers(-(10**6), 10**6).map(lambda n: n / 1e5), st.sampled_from([0.0, 1.0])),
    min_size=3,
    max_size=3,
)


def packed(matrix: Floats) -> Floats:
    return np.array([matrix[i, j] for i, j in PRODUCTS])


def turned(spectrum: list[float], seed: int) -> Floats:
    axes = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    matrix = axes @ np.diag(spectrum) @ axes.T
    return np.asarray((matrix + matrix.T) / 2)


def vector(matrix: Floats, value: float) -> Floats:
    out = np.full((2, 5), 7.0)
    eigenvector(packed(matrix), value, out, 1, 2)
    assert (out[0] == 7).all()  # writes nothing else
    assert (out[1, :2] == 7).all()
    return out[1, 2:]


@given(spectra, st.integers(0, 99), scales)
@law
def test_eigenvalues(spectrum: list[float], seed: int, scale: float) -> None:
    matrix = turned(spectrum, seed) * scale
    found = [eigenvalue(packed(matrix), which) for which in range(3)]
    # A double root of the characteristic polynomial is known to the root of the precision.
    np.testing.assert_allclose(
        found, np.linalg.eigvalsh(matrix), rtol=0, atol=3e-7 * np.abs(matrix).max()
    )


@given(
    st.lists(st.integers(-5, 5), min_size=3, max_size=3, unique=True), st.integers(0, 99), scales
)
@law
def test_eigenvectors_of_simple_eigenvalues(spectrum: list[int], seed: int, scale: float) -> None:
    matrix = turned([float(v) for v in spectrum], seed) * scale
    values, vectors = np.linalg.eigh(matrix)
    for which in range(3):
        value = eigenvalue(packed(matrix), which)
        assert value == pytest.approx(values[which], abs=1e-13 * np.abs(values).max())
        found = vector(matrix, value)
        assert abs(found @ vectors[:, which]) == pytest.approx(1, abs=1e-10)


@given(st.floats(0.1, 10), st.integers(0, 99), scales)
@law
def test_a_double_eigenvalue_has_no_direction(other: float, seed: int, scale: float) -> None:
    """A line has no plane: noise must not choose one that the line pierces."""
    for spectrum in ([0.0, 0.0, other], [other, other, other], [0.0, 0.0, 0.0]):
        matrix = turned(spectrum, seed) * scale
        least = eigenvalue(packed(matrix), 0)
        assert vector(matrix, least).tolist() == [0, 0, 0]


@pytest.mark.parametrize("width", [1e-5, 1e-6])
def test_a_narrow_strip_still_has_a_plane(width: float) -> None:
    matrix = turned([0, width, 1], 3)
    _, vectors = np.linalg.eigh(matrix)
    found = vector(matrix, eigenvalue(packed(matrix), 0))
    assert abs(found @ vectors[:, 0]) == pytest.approx(1, abs=1e-4)


@pytest.mark.parametrize("exponent", range(-300, 1, 10))
def test_tiny_matrices_do_not_divide_by_zero(exponent: int) -> None:
    """The cube of their size is below the smallest number."""
    matrix = turned([1, 2, 4], 0) * 10.0**exponent
    for which in range(3):
        assert eigenvalue(packed(matrix), which) == pytest.approx(
            [1, 2, 4][which] * 10.0**exponent, rel=2
        )
        assert np.isfinite(vector(matrix, eigenvalue(packed(matrix), which))).all()


def test_covariance_from_sums() -> None:
    points = np.random.default_rng(0).normal(size=(9, 3)) * [1, 2, 3] + [4, 5, 6]
    row = np.concatenate([points.sum(axis=0), [-1], packed(points.T @ points)])
    out = np.empty(6)
    covariance(np.stack([0 * row, row]), 1, 0, 4, 9.0, out)
    np.testing.assert_allclose(out, packed(np.cov(points.T, bias=True)), atol=1e-12)
