"""How surely a pixel lies on an edge: gradient rank and confidence in one map.

The edge detector with embedded confidence (Meer and Georgescu 2001) and its mixture for the mean
shift (Christoudias, Georgescu and Meer 2002). Of every pixel's window

- the rank rho of its gradient is the share of pixels with a smaller gradient magnitude, and
- the confidence eta is the correlation of the window with an ideal step edge in the direction of
  the gradient: 1 for a perfect edge, however weak, and low in texture.

The strength is ``beta rho + (1 - beta) eta``, and 0 for the pixels of the lowest ranks.

Unclear: the smoothing and differentiation sequences for a window (binomial ones are used), and
how the ideal edge is drawn on pixels (by the share of each pixel on either side, here).

References
----------
P. Meer, B. Georgescu, "Edge detection with embedded confidence", IEEE Trans. PAMI 23(12), 2001.
C. Christoudias, B. Georgescu, P. Meer, "Synergism in low level vision", ICPR 2002.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.baselines.kernels import compiled

LOWEST_RANK = 0.02
"""Up to this rank a gradient is no edge at all, as in EDISON."""


def edge_strength(
    image: NDArray[np.float32], mask: NDArray[np.bool_], window: int = 2, mixture: float = 0.3
) -> NDArray[np.float32]:
    """Rate how surely each pixel lies on an edge.

    Parameters
    ----------
    image : (H, W) float32
        Grey values or depth in any unit; finite everywhere.
    mask : (H, W) bool
        The pixels among which gradients are ranked; the others get 0.
    window : int
        Half the size of the window less one: 2 means 5 x 5.
    mixture : float
        Share beta of the rank against the confidence.

    Returns
    -------
    (H, W) float32
        0 to 1.

    Examples
    --------
    >>> step = np.repeat(np.float32([0, 0, 0, 0, 1, 1, 1, 1]), 8).reshape(8, 8).T.copy()
    >>> edge_strength(step, np.ones((8, 8), bool))[4].astype(float).round(1).tolist()
    [0.0, 0.0, 0.5, 0.9, 0.9, 0.5, 0.0, 0.0]
    """
    across, down = gradient(image, window)
    rank = gradient_rank(np.hypot(across, down), mask, float(np.abs(image).max(initial=0)))
    confidence = np.zeros(image.shape, np.float32)
    padded = np.pad(image.astype(np.float64), window, mode="edge")
    _correlate(padded, across, down, rank > LOWEST_RANK, window, confidence)
    strength = mixture * rank + (1 - mixture) * confidence
    return np.where(rank > LOWEST_RANK, strength, 0.0).astype(np.float32)


def gradient(
    image: NDArray[np.float32], window: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the derivatives across and down, smoothed binomially over the window."""
    from scipy.ndimage import correlate1d

    smooth = np.array([1.0])
    for _ in range(2 * window):
        smooth = np.convolve(smooth, [0.5, 0.5])
    inner = np.array([1.0])
    for _ in range(2 * window - 2):
        inner = np.convolve(inner, [0.5, 0.5])
    differ = np.convolve(inner, [-0.5, 0.0, 0.5])
    values = image.astype(np.float64)
    across, down = (
        correlate1d(
            correlate1d(values, differ, axis=along, mode="nearest"),
            smooth,
            axis=1 - along,
            mode="nearest",
        )
        for along in (1, 0)
    )
    return across, down


def gradient_rank(
    magnitude: NDArray[np.float64], mask: NDArray[np.bool_], scale: float
) -> NDArray[np.float64]:
    """Return the share of the pixels of the mask with a smaller gradient; 0 outside it."""
    flat = np.where(magnitude > 1e-6 * scale, magnitude, 0.0)  # below: rounding, no gradient
    ordered = np.sort(flat[mask])
    rank = np.searchsorted(ordered, flat) / max(len(ordered), 1)
    return np.where(mask, rank, 0.0)


@compiled
def _correlate(
    padded: NDArray[np.float64],
    across: NDArray[np.float64],
    down: NDArray[np.float64],
    wanted: NDArray[np.bool_],
    window: int,
    confidence: NDArray[np.float32],
) -> None:
    """Correlate the window of each wanted pixel with the ideal edge in its gradient direction."""
    side = 2 * window + 1
    for i in range(wanted.shape[0]):
        for j in range(wanted.shape[1]):
            if not wanted[i, j]:
                continue
            norm = np.hypot(across[i, j], down[i, j])
            dx, dy = across[i, j] / norm, down[i, j] / norm
            total = square = product = ideal = 0.0
            for v in range(side):
                for u in range(side):
                    value = padded[i + v, j + u] - padded[i + window, j + window]
                    template = min(max((u - window) * dx + (v - window) * dy, -0.5), 0.5)
                    total += value
                    square += value * value
                    product += value * template
                    ideal += template * template
            spread = square - total * total / (side * side)
            if spread > 0.0:
                confidence[i, j] = min(abs(product) / np.sqrt(spread * ideal), 1.0)
