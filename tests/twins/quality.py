"""Eq. 6-17, segment by segment and pixel by pixel."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def literal_quality(
    rgb: NDArray[np.uint8],
    depth: NDArray[np.float64],
    labels: NDArray[np.int32],
    texture: bool,
    norm: str,
) -> float | None:
    """Q of a depth-map scene; pixels without depth or label take no part."""
    image = rgb / 255.0
    valid = np.isfinite(depth)
    span = np.nanmax(depth) - np.nanmin(depth) if valid.any() else 1.0
    unit = (depth - (np.nanmin(depth) if valid.any() else 0)) / (span or 1.0)
    used = valid & (labels >= 0)
    segments = [used & (labels == s) for s in np.unique(labels[used])]
    k, n = len(segments), int(used.sum())
    if k < 2:
        return None

    def one_number(values: NDArray[np.float64]) -> float:
        return float(values.sum() if norm == "sum" else np.sqrt((values**2).sum()))

    def texture_of(segment: NDArray[np.bool_]) -> float:
        found = []
        for y in range(1, labels.shape[0] - 1):
            for x in range(1, labels.shape[1] - 1):
                if segment[y - 1 : y + 2, x - 1 : x + 2].all():
                    window = image[y - 1 : y + 2, x - 1 : x + 2].reshape(9, 3)
                    found.append(one_number(window.std(axis=0)))
        return float(np.mean(found)) if found and texture else 0.0  # eq. 6

    color_intra = sum(
        max(one_number(image[s].std(axis=0)) - texture_of(s), 0) * s.sum() / n for s in segments
    )  # eq. 7, 8
    depth_intra = sum(unit[s].std() * s.sum() / n for s in segments)  # eq. 12, 13
    color_inter = depth_inter = 0.0
    for i in segments:
        for j in segments:
            color_inter += one_number(np.abs(image[i].mean(axis=0) - image[j].mean(axis=0)))
            depth_inter += abs(unit[i].mean() - unit[j].mean())
    color_inter /= k * (k - 1)  # eq. 9, 10
    depth_inter /= k * (k - 1)  # eq. 14, 15
    q_color = (color_inter - color_intra) / 2  # eq. 11
    q_depth = (depth_inter - depth_intra) / 2  # eq. 16
    return float(q_color + 3 * q_depth)  # eq. 17


def window_deviation(rgb: NDArray[np.uint8], norm: str) -> NDArray[np.float64]:
    """The deviation of the colours in each 3 x 3 window that lies in the image."""
    local = np.zeros(rgb.shape[:2])
    for y in range(1, rgb.shape[0] - 1):
        for x in range(1, rgb.shape[1] - 1):
            channels = (rgb[y - 1 : y + 2, x - 1 : x + 2].reshape(9, 3) / 255).std(axis=0)
            local[y, x] = channels.sum() if norm == "sum" else np.linalg.norm(channels)
    return local


def window_interior(labels: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Whether each 3 x 3 window lies in the image and in one segment."""
    inside = np.zeros(labels.shape, bool)
    for y in range(1, labels.shape[0] - 1):
        for x in range(1, labels.shape[1] - 1):
            window = labels[y - 1 : y + 2, x - 1 : x + 2]
            inside[y, x] = labels[y, x] >= 0 and bool((window == labels[y, x]).all())
    return inside
