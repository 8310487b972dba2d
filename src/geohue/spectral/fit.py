"""Sec. III on any vectors: the normalized cut of rows that need not fit into memory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from geohue.compute.arrays import Rows
from geohue.compute.parallel import Workers
from geohue.ncut.labels import find_centers
from geohue.ncut.landmarks import choose_landmarks
from geohue.ncut.model import CutModel
from geohue.ncut.nystrom import nystrom_cut
from geohue.ncut.selectors import choose_k
from geohue.settings.cut import Labelling, LandmarkChoice
from geohue.spectral.model import Scaled, SpectralModel
from geohue.spectral.sketch import Sketch
from geohue.spectral.source import READ
from geohue.spectral.width import neighbour_width

SAMPLE = 20_000
"""Distinct vectors on which landmarks, width, K and centres are chosen: `Sketch`."""

CENTER_POINTS = 5_000
"""Of these, the ones that k-means on the eigenvectors looks at."""

SINGLE = 256.0
"""Half the extent of the data, in widths, up to which float32 holds the affinities to 1 %."""


@dataclass(frozen=True, slots=True)
class Settings:
    """What is asked for.

    Attributes
    ----------
    k : int or "auto"
        Number of clusters.
    k_max : int
        Most that "auto" answers.
    width : float or None
        The sigma of the affinity in the units of the vectors; None: `neighbour_width`.
    landmarks : int
        Vectors that stand for all others; at least two a cluster are taken.
    choice : {"random", "kmeans", "farthest"}
        How they are chosen (`choose_landmarks`).
    labelling : {"kmeans", "rotation", "qr"}
        From eigenvectors to labels (`find_centers`).
    restarts : int
        Random starts of k-means beside its own.
    """

    k: int | Literal["auto"]
    k_max: int
    width: float | None
    landmarks: int
    choice: LandmarkChoice
    labelling: Labelling
    restarts: int


def fit_spectral(
    source: Rows, weights: NDArray[np.float64] | None, settings: Settings, seed: int, team: Workers
) -> SpectralModel:
    """Fit the normalized cut of vectors.

    One pass draws the sample. Where it holds all distinct vectors, all that follows is computed
    on them in float64, and the order of the rows changes nothing. Else two more passes make the
    degrees and the eigenvectors from all rows.

    Parameters
    ----------
    source : (N, D) rows
        Finite real numbers, N >= 1.
    weights : (N,) float64, optional
        As how many rows each counts, not negative and not all 0; by default 1.
    settings : Settings
        What is asked for.
    seed : int
        The source of chance, not negative.
    team : Workers
        Threads to use.

    Returns
    -------
    SpectralModel
        Of at most as many clusters as the landmarks span directions.

    Examples
    --------
    >>> x = np.repeat([[0.0], [9.0]], 5, axis=0)
    >>> asked = Settings(2, 10, 1.0, 4, "kmeans", "kmeans", 4)
    >>> model = fit_spectral(x, None, asked, 0, Workers(None))
    >>> model.labels(np.array([[8.5], [0.5]]), Workers(None)).tolist()
    [1, 0]
    """
    vectors, counts, whole = _sample(source, weights, seed)
    center = (vectors / len(vectors)).sum(axis=0)  # the plain sum could overflow
    known = None if settings.k == "auto" else settings.k
    width = settings.width or neighbour_width(vectors, counts, known)
    rng = np.random.default_rng(seed)
    reach = float(np.abs(vectors - center).max()) / width
    dtype: np.dtype[np.floating] = np.dtype(np.float32)
    if whole or reach > SINGLE:
        dtype = np.dtype(np.float64)
    sample = Scaled(vectors, center, width, dtype)[:]
    m = known or settings.k_max + 1
    n = max(settings.landmarks, 2 * m)
    z = sample[choose_landmarks(sample, n, settings.choice, rng)]
    if whole:
        cut = nystrom_cut(sample, z, team, m, 1.0, counts)
    else:
        cut = nystrom_cut(Scaled(source, center, width, dtype), z, team, m, 1.0, weights)
    step = -(-len(sample) // CENTER_POINTS)
    some, counts = sample[::step], counts[::step]
    k = known or choose_k(cut, some, "eigengap", settings.k_max)
    k = min(k, cut.basis.shape[1])  # coinciding points span fewer directions
    rows = cut.rows(some, k)
    centers = find_centers(rows, k, settings.labelling, rng, settings.restarts, counts)
    return SpectralModel(CutModel(cut, centers), center, width, dtype)


def _sample(
    source: Rows, weights: NDArray[np.float64] | None, seed: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], bool]:
    """Return distinct vectors, their weights, and whether these are all."""
    sketch = Sketch(SAMPLE, seed)
    for start in range(0, len(source), READ):
        block = source[start : start + READ].astype(np.float64)
        part = np.ones(len(block)) if weights is None else weights[start : start + READ]
        sketch.add(block, part)
    return *sketch.sample(), sketch.whole
