"""Scores of a segmentation that use no labels: Q of Sec. IV, its variants, and other criteria.

All are computed from a few statistics of the segments, so that a hundred cost little more than
one. Higher is better for each.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geohue.features import lab_of
from geohue.scene import Scene
from geohue.weight.quality import _window_deviation, _window_interior

Floats = NDArray[np.float64]

INTERS = ("pairs", "size", "adjacent", "border")
"""How the distances between segments are averaged: all pairs alike (eq. 10), by the product of
the sizes, adjacent pairs alike, by the length of the common border."""

NORMS = ("sum", "euclidean")
"""How three channels become one number."""


@dataclass(frozen=True, slots=True, eq=False)
class Cue:
    """One cue of a scene: its values, and its local deviation where texture is taken out."""

    values: Floats
    texture: dict[str, Floats] | None = None


class Data:
    """What all criteria need of a scene, whatever its labels."""

    def __init__(self, scene: Scene) -> None:
        assert scene.depth is not None
        self.valid = scene.valid
        rgb = scene.colors[self.valid] / 255.0
        local = {n: _window_deviation(scene.colors, n)[self.valid] for n in NORMS}  # type: ignore[arg-type]
        depth = scene.depth[self.valid].astype(np.float64)[:, None]
        xyz = scene.points[self.valid].astype(np.float64)
        self.cues = {
            "rgb": Cue(rgb, {n: v.astype(np.float64) for n, v in local.items()}),
            "lab": Cue(_unit_spread(lab_of(scene.colors[self.valid]).astype(np.float64))),
            "depth": Cue((depth - depth.min()) / (np.ptp(depth) or 1.0)),
            "xyz": Cue(_unit_spread(xyz)),
        }
        height, width = scene.shape
        v, u = np.nonzero(self.valid)
        inverse = 1 / np.maximum(depth[:, 0], 1e-6)
        # A plane is linear in the inverse depth of its pixels.
        self.plane = np.stack([u / width - 0.5, v / height - 0.5, np.ones(len(u))], axis=1)
        self.inverse = inverse / (inverse.std() or 1.0)
        self.steps = {
            name: _steps(_image(self.cues[name].values, self.valid)) for name in ("lab", "xyz")
        }


def _unit_spread(values: Floats) -> Floats:
    centred = values - values.mean(axis=0)
    return np.asarray(centred / (centred.std(axis=0).mean() or 1.0))


def _image(values: Floats, valid: NDArray[np.bool_]) -> Floats:
    image = np.full((*valid.shape, values.shape[1]), np.nan)
    image[valid] = values
    return image


def _steps(image: Floats) -> tuple[Floats, Floats]:
    """Distance of each pixel to the one on its right and to the one below."""
    right = np.linalg.norm(image[:, 1:] - image[:, :-1], axis=2)
    below = np.linalg.norm(image[1:] - image[:-1], axis=2)
    return right, below


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """Sizes, borders and, for each cue, means and deviations of the segments."""

    sizes: Floats
    borders: Floats
    means: dict[str, Floats]
    deviations: dict[str, Floats]
    textures: dict[str, Floats]
    plane_misfit: Floats
    contrast: dict[str, float]


def parts_of(data: Data, labels: NDArray[np.integer]) -> Parts | None:
    """Gather the statistics of the segments of a label map; None if there are fewer than two."""
    used = labels[data.valid]
    seen = used >= 0
    counts = np.bincount(used[seen])
    present = np.flatnonzero(counts)
    k = len(present)
    if k < 2:
        return None
    segment = (np.cumsum(counts > 0) - 1)[used[seen]]
    sizes = counts[present].astype(np.float64)
    means, deviations = {}, {}
    for name, cue in data.cues.items():
        means[name], deviations[name] = _moments(cue.values[seen], segment, sizes)
    interior = _window_interior(np.where(data.valid, labels, -1).astype(np.int32))
    inside = interior[data.valid][seen]
    count = np.maximum(np.bincount(segment[inside], minlength=k), 1)
    textures = {
        norm: np.bincount(segment[inside], local[seen][inside], k) / count
        for norm, local in (data.cues["rgb"].texture or {}).items()
    }
    rank = np.full(labels.shape, -1)
    rank.reshape(-1)[np.flatnonzero(data.valid)[seen]] = segment
    misfit = _plane_misfit(data.plane[seen], data.inverse[seen], segment, sizes)
    borders, contrast = _borders(data, rank, k)
    return Parts(sizes, borders, means, deviations, textures, misfit, contrast)


def _moments(values: Floats, segment: NDArray[np.int64], sizes: Floats) -> tuple[Floats, Floats]:
    k = len(sizes)
    mean, deviation = np.empty((k, values.shape[1])), np.empty((k, values.shape[1]))
    for c, channel in enumerate(values.T):
        mean[:, c] = np.bincount(segment, channel, k) / sizes
        deviation[:, c] = np.sqrt(
            np.bincount(segment, (channel - mean[segment, c]) ** 2, k) / sizes
        )
    return mean, deviation


def _plane_misfit(
    plane: Floats, inverse: Floats, segment: NDArray[np.int64], sizes: Floats
) -> Floats:
    """Root mean square distance of each segment's inverse depth from its best plane."""
    k = len(sizes)
    normal, right = np.empty((k, 3, 3)), np.empty((k, 3))
    for i in range(3):
        right[:, i] = np.bincount(segment, plane[:, i] * inverse, k)
        for j in range(3):
            normal[:, i, j] = np.bincount(segment, plane[:, i] * plane[:, j], k)
    fit = np.linalg.solve(normal + 1e-9 * sizes[:, None, None] * np.eye(3), right[..., None])
    rest = inverse - np.einsum("ij,ij->i", plane, fit[segment, :, 0])
    return np.sqrt(np.bincount(segment, rest * rest, k) / sizes)


def _borders(data: Data, rank: NDArray[np.int64], k: int) -> tuple[Floats, dict[str, float]]:
    """Length of the border of each two segments, and the mean step across all borders.

    The steps are relative to the mean step of the picture.
    """
    pairs = ((rank[:, 1:], rank[:, :-1]), (rank[1:], rank[:-1]))
    both = [(a >= 0) & (b >= 0) for a, b in pairs]
    cut = [(a != b) & ok for (a, b), ok in zip(pairs, both, strict=True)]
    borders = np.zeros((k, k))
    for (a, b), c in zip(pairs, cut, strict=True):
        np.add.at(borders, (a[c], b[c]), 1.0)
    contrast = {}
    for name, steps in data.steps.items():
        across = np.concatenate([s[c] for s, c in zip(steps, cut, strict=True)])
        everywhere = np.concatenate([s[ok] for s, ok in zip(steps, both, strict=True)])
        contrast[name] = float(across.mean() / (everywhere.mean() or 1.0)) if across.size else 0.0
    return borders + borders.T, contrast


def criteria(data: Data, labels: NDArray[np.integer]) -> dict[str, float] | None:
    """Score a label map by every criterion; None if there are fewer than two segments."""
    parts = parts_of(data, labels)
    if parts is None:
        return None
    scores = {}
    for inter in INTERS:
        for norm in NORMS:
            scores[f"Q {inter} {norm}"] = _paper_q(parts, inter, norm)
    scores["Q without inter"] = -_intra(parts, "rgb", "sum") - 3 * _intra(parts, "depth", "sum")
    scores["Q without intra"] = _inter(parts, "rgb", "pairs", "sum") + 3 * _inter(
        parts, "depth", "pairs", "sum"
    )
    color, geometry = (_explained(parts, name) for name in ("lab", "xyz"))
    scores["explained sum"] = color + geometry
    scores["explained least"] = min(color, geometry)
    scores["explained product"] = color * geometry
    flat = float((parts.plane_misfit * parts.sizes).sum() / parts.sizes.sum())
    scores["planes"] = -flat
    scores["explained color, planes"] = color - flat
    scores["contrast color"] = parts.contrast["lab"]
    scores["contrast geometry"] = parts.contrast["xyz"]
    scores["contrast sum"] = parts.contrast["lab"] + parts.contrast["xyz"]
    scores["contrast product"] = parts.contrast["lab"] * parts.contrast["xyz"]
    share = parts.sizes / parts.sizes.sum()
    scores["unequal sizes"] = float((share * np.log2(share)).sum())
    scores["short borders"] = -float(parts.borders.sum())
    return scores


def _paper_q(parts: Parts, inter: str, norm: str) -> float:
    color = _inter(parts, "rgb", inter, norm) - _intra(parts, "rgb", norm)
    depth = _inter(parts, "depth", inter, norm) - _intra(parts, "depth", norm)
    return (color + 3 * depth) / 2


def _norm(channels: Floats, norm: str) -> Floats:
    if norm == "sum":
        return np.asarray(channels.sum(axis=-1))
    return np.asarray(np.sqrt((channels**2).sum(axis=-1)))


def _intra(parts: Parts, cue: str, norm: str) -> float:
    sigma = _norm(parts.deviations[cue], norm)
    if cue == "rgb":
        sigma = np.maximum(sigma - parts.textures[norm], 0)
    return float((sigma * parts.sizes).sum() / parts.sizes.sum())


def _inter(parts: Parts, cue: str, inter: str, norm: str) -> float:
    means = parts.means[cue]
    distance = _norm(np.abs(means[:, None] - means[None]), norm)
    weight = {
        "pairs": np.ones_like(distance),
        "size": np.outer(parts.sizes, parts.sizes),
        "adjacent": (parts.borders > 0).astype(np.float64),
        "border": parts.borders.copy(),
    }[inter]
    np.fill_diagonal(weight, 0)
    return float((distance * weight).sum() / (weight.sum() or 1.0))


def _explained(parts: Parts, cue: str) -> float:
    """Share of the variance of a cue that lies between the segments."""
    means, sizes = parts.means[cue], parts.sizes
    inside = float(((parts.deviations[cue] ** 2).sum(axis=1) * sizes).sum())
    centre = (means * sizes[:, None]).sum(axis=0) / sizes.sum()
    between = float((((means - centre) ** 2).sum(axis=1) * sizes).sum())
    return between / ((inside + between) or 1.0)
