"""Graph-based segmentation of Felzenszwalb and Huttenlocher [1] (row 4 of Fig. 9).

Colour on a grid is scikit-image's implementation, on the 8-bit RGB image as its authors have it.
Geometry and fusion are our own merging of the same graph: the weight of an edge is the distance
of the normalised xyz (eq. 3) or of the vectors p^f (eq. 5) of the two pixels, smoothed like the
colours. A cloud without a grid is a graph of nearest neighbours, as the authors propose in their
Sec. 6, unsmoothed.

Parameters
----------
SIGMA, SCALE and MIN_SIZE are those of the authors' paper and code for images of 320 x 240 and
more: sigma 0.8, k 300 for colours in 0..255; minimum sizes there are 20 to 100. Vectors that are
divided by their deviation take k divided by the typical deviation of a colour channel, `SPREAD`,
so that k means the same in the scale of the data.

Unclear: the paper gives no parameters, nor how [1] was applied to geometry (METHOD.md: distance
of the normalised xyz). Fusion is not in the paper: its natural completion.

References
----------
P. Felzenszwalb, D. Huttenlocher, "Efficient graph-based image segmentation", Int. J. Computer
Vision 59(2), 2004.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.baselines.graph import cloud_edges, edge_lengths, grid_edges, merge_graph
from geohue.baselines.registry import Job
from geohue.baselines.sampling import mixed_vectors
from geohue.features import Features
from geohue.scene import Scene

SIGMA = 0.8
"""Deviation of the smoothing, pixels."""

SCALE = 300.0
"""The k of the paper, for colours in 0..255."""

MIN_SIZE = 100
"""Pixels; smaller components join a neighbour."""

SPREAD = 55.0
"""Mean deviation of the channels of an 8-bit image: 26-86 in 19 test scenes, 54 on average."""


def run(job: Job) -> NDArray[np.int32]:
    """Segment a scene; the number of segments is found."""
    if job.features.cues == "color" and job.scene.is_grid:
        return _color_image(job.scene)
    if job.scene.is_grid:
        return segment_grid(job.features, mixed_vectors(job.features, job.weight))
    return _cloud(job)


def segment_grid(
    features: Features,
    vectors: NDArray[np.float32],
    scale: float = SCALE / SPREAD,
    sigma: float = SIGMA,
    min_size: int = MIN_SIZE,
) -> NDArray[np.int32]:
    """Merge the grid of pixels by the distance of their vectors.

    Parameters
    ----------
    features : Features
        Says which pixels take part.
    vectors : (M, D) float32
        One for each of these pixels.
    scale : float
        k, in the unit of the vectors.
    sigma : float
        Deviation of the smoothing, pixels; over the pixels that take part.
    min_size : int
        Pixels.

    Returns
    -------
    (H, W) int32
        -1 where a pixel takes no part.
    """
    rows = np.full(features.shape, -1, np.int32)
    rows.reshape(-1)[features.index] = np.arange(len(features))
    edges = grid_edges(rows)
    smooth = smoothed(features, vectors, sigma)
    labels = merge_graph(len(features), edges, edge_lengths(smooth, edges), scale, min_size)
    return features.to_scene(labels)


def smoothed(features: Features, vectors: NDArray[np.float32], sigma: float) -> NDArray[np.float32]:
    """Smooth vectors on the grid with a Gaussian over the pixels that have one."""
    if sigma <= 0:
        return vectors
    from scipy.ndimage import gaussian_filter

    def spread(values: NDArray[np.float32]) -> NDArray[np.float32]:
        full = np.zeros(features.shape, np.float32)
        full.reshape(-1)[features.index] = values
        blurred = gaussian_filter(full, sigma)
        return np.asarray(blurred.reshape(-1)[features.index], np.float32)

    share = spread(np.ones(len(features), np.float32))
    return np.stack([spread(channel) / share for channel in vectors.T], axis=1)


def _color_image(scene: Scene) -> NDArray[np.int32]:
    from skimage.segmentation import felzenszwalb

    labels = felzenszwalb(scene.colors, scale=SCALE, sigma=SIGMA, min_size=MIN_SIZE)
    return np.asarray(labels, np.int32)


def _cloud(job: Job) -> NDArray[np.int32]:
    features = job.features
    vectors = mixed_vectors(features, job.weight)
    points = job.scene.points.reshape(-1, 3)[features.index]
    placed = np.flatnonzero(np.isfinite(points[:, 2]))  # a colour without a place has no neighbour
    edges = cloud_edges(points[placed])
    lengths = edge_lengths(vectors[placed], edges)
    labels = np.full(len(features), -1, np.int32)
    labels[placed] = merge_graph(len(placed), edges, lengths, SCALE / SPREAD, MIN_SIZE)
    return features.to_scene(labels)
