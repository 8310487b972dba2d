"""The blur is that of SciPy, to the last bit."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from geohue.compute.blur import gaussian_blur


@pytest.mark.parametrize(("sigma", "truncate"), [(0.5, 4.0), (1.0, 3.0), (2.3, 4.0)])
@pytest.mark.parametrize("shape", [(1, 1), (3, 5), (40, 31, 3)])
@pytest.mark.parametrize("axis", [0, 1])
def test_the_blur_is_that_of_scipy(
    sigma: float, truncate: float, shape: tuple[int, ...], axis: int
) -> None:
    values = np.random.default_rng(0).normal(size=shape)
    wanted = gaussian_filter1d(values, sigma, axis=axis, truncate=truncate)
    assert gaussian_blur(values, sigma, axis, truncate).tolist() == wanted.tolist()
