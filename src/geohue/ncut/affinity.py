"""The affinity of points to landmarks: a Gaussian on the vectors of eq. 5."""

from __future__ import annotations

import numpy as np

from geohue.compute.arrays import Floats
from geohue.settings.cut import SCALE

FAINTEST = -40.0
"""Log-affinity below which a point counts as seen by no landmark, see `affinity`."""


def affinity(vectors: Floats, landmarks: Floats, scale: float = SCALE) -> Floats:
    r"""Affinity of each point to each landmark.

    .. math:: w_{ij} = \exp\left(-\frac{\|x_i - z_j\|^2}{2 s^2}\right)

    on the vectors of `Features.mixed`, whose spread does not depend on the weight; on those of
    eq. 5 this is an affinity with :math:`\sigma = s \sqrt{1 + \lambda^2}`, on those of eq. 19 with
    :math:`\sigma = s \sqrt{2 + \lambda^2}`.

    A point so far from all landmarks that its affinities would underflow keeps their ratios: its
    row is raised until the largest is ``exp(FAINTEST)``. Such a point still
    goes to its nearest landmarks, but adds nothing to the sums.

    Parameters
    ----------
    vectors : (N, D) float
        Points.
    landmarks : (n, D) float
        Landmarks.
    scale : float
        The width s, positive.

    Returns
    -------
    (N, n) float, the type of `vectors`
        Affinities in (0, 1].

    Examples
    --------
    >>> x = np.array([[0.0, 0.0], [0.6, 0.0]])
    >>> affinity(x, x, scale=0.6).round(4).tolist()
    [[1.0, 0.6065], [0.6065, 1.0]]
    """
    gain = vectors.dtype.type(1 / scale)
    x, z = vectors * gain, landmarks * gain
    # exp(x.z - |x|^2/2 - |z|^2/2), with the norms as two further columns: one product does it all.
    one = np.ones((len(x), 1), x.dtype)
    x_ext = np.hstack([x, -0.5 * np.einsum("ij,ij->i", x, x)[:, None], one])
    z_ext = np.hstack([z, one[:1].repeat(len(z), 0), -0.5 * np.einsum("ij,ij->i", z, z)[:, None]])
    log_w = x_ext @ z_ext.T
    faint = log_w.max(axis=1) < FAINTEST
    if faint.any():
        log_w[faint] += (FAINTEST - log_w[faint].max(axis=1))[:, None]
    # Rounding may pass 0 by a hair; below -80 the numbers would be denormal, hence slow.
    np.clip(log_w, -80, 0, out=log_w)
    return np.asarray(np.exp(log_w, out=log_w))
