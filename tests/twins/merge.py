"""Slow, readable twins of region merging: everything anew from the labels, at every step."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from geohue.merge.evidence import Evidence

Array = NDArray[np.float64]
Labels = NDArray[np.int32]
Pair = tuple[int, int]


def smoothed(values: Array, pairs: Iterable[Pair], rounds: int) -> Array:
    """Each row takes the mean of itself and its partners, again and again."""
    around: list[list[int]] = [[i] for i in range(len(values))]
    for a, b in pairs:
        around[a].append(b)
        around[b].append(a)
    for _ in range(rounds):
        values = np.array([values[group].mean(axis=0) for group in around])
    return values


class Facts:
    """What pairs of neighbours say in the over-segmentation that merging begins with."""

    def __init__(self, evidence: Evidence, labels: Labels, rounds: int = 6) -> None:
        self.evidence, self.start = evidence, labels
        pairs = list(zip(evidence.one.tolist(), evidence.other.tolist(), strict=True))
        inside = [(a, b) for a, b in pairs if labels[a] == labels[b]]
        lab = smoothed(evidence.lab, inside, rounds)
        points = smoothed(evidence.points, inside, rounds)
        normals = smoothed(evidence.normals, inside, rounds)
        normals = np.array([n / max(float(np.linalg.norm(n)), 1e-9) for n in normals])
        self.pairs = pairs
        self.color, self.convexity, self.gap = [], [], []
        for a, b in pairs:
            way = points[b] - points[a]
            unit = min(evidence.unit[a], evidence.unit[b])
            self.color.append(float(np.linalg.norm(lab[a] - lab[b])))
            turn = (normals[b] - normals[a]) @ way
            self.convexity.append(float(turn / max(float(np.linalg.norm(way)), 1e-12)))
            self.gap.append(float(abs(way @ (normals[a] + normals[b]) / 2) / unit))
        inner = [e for e, (a, b) in enumerate(pairs) if labels[a] == labels[b]]
        self.typical = float(evidence.step[inner].sum() / max(len(inner), 1))

    def border(self, labels: Labels, i: int, j: int) -> list[int]:
        """The pairs of neighbours between two regions."""
        return [e for e, (a, b) in enumerate(self.pairs) if {labels[a], labels[b]} == {i, j}]

    def inside(self, labels: Labels, i: int) -> list[int]:
        return [e for e, (a, b) in enumerate(self.pairs) if labels[a] == labels[b] == i]

    def perimeter(self, labels: Labels, i: int) -> int:
        return sum((labels[a] == i) != (labels[b] == i) for a, b in self.pairs)


def plane(points: Array) -> tuple[Array, float]:
    """Normal of the best plane and the mean squared distance from it."""
    if len(points) < 3:
        return np.zeros(3), 0.0
    values, vectors = np.linalg.eigh(np.cov(points.T, bias=True))
    return vectors[:, 0], max(float(values[0]), 0.0)


def cues(facts: Facts, labels: Labels, i: int, j: int) -> Array:
    """All cues of two regions that touch, from their points and pairs."""
    evidence, border = facts.evidence, facts.border(labels, i, j)
    here, there = np.flatnonzero(labels == i), np.flatnonzero(labels == j)
    n, m, length = len(here), len(there), len(border)
    unit = min(evidence.unit[here].mean(), evidence.unit[there].mean())
    p, q = evidence.points[here], evidence.points[there]
    (normal_p, rest_p), (normal_q, rest_q) = plane(p), plane(q)
    way = p.mean(axis=0) - q.mean(axis=0)
    both = np.concatenate([p, q])
    joint = np.sqrt(max(np.linalg.eigvalsh(np.cov(both.T, bias=True))[0], 0)) / unit
    apart = np.sqrt((n * rest_p + m * rest_q) / (n + m)) / unit
    perimeter = min(facts.perimeter(labels, i), facts.perimeter(labels, j))
    mean_p, mean_q = evidence.normals[here].sum(axis=0), evidence.normals[there].sum(axis=0)
    turn = mean_p / (np.linalg.norm(mean_p) + 1e-9) - mean_q / (np.linalg.norm(mean_q) + 1e-9)
    calm = min(_calm(facts, labels, i), _calm(facts, labels, j))
    return np.array(
        [
            np.log(max(abs(way @ normal_p), abs(way @ normal_q)) / unit / 0.004 + 0.5),
            np.log(np.mean([facts.color[e] for e in border]) + 0.5),
            np.log(evidence.depth_step[border].mean() / 0.004 + 0.5),
            _chi_squared(evidence.texture[here], evidence.texture[there]),
            np.mean([facts.convexity[e] for e in border]),
            np.log(joint / (apart + 0.002) + 0.1),
            _parted(evidence, here, there),
            length / np.sqrt(min(n, m)),
            np.log(np.mean([facts.gap[e] for e in border]) / 0.004 + 0.5),
            np.log(evidence.step[border].mean() / max(calm, 1e-6) + 0.05),
            _straightness(evidence, border),
            length / max(perimeter, 1),
            np.log(min(n, m) / len(labels)),
            np.log(max(n, m) / len(labels)),
            turn @ way / np.linalg.norm(way),
        ]
    )


def _calm(facts: Facts, labels: Labels, i: int) -> float:
    inside = facts.inside(labels, i)
    total = facts.evidence.step[inside].sum() + 20 * facts.typical
    return float(total / (len(inside) + 20))


def _chi_squared(one: NDArray[np.int64], other: NDArray[np.int64]) -> float:
    a, b = (np.bincount(part, minlength=8) / len(part) for part in (one, other))
    some = a + b > 0
    return float((((a - b) ** 2)[some] / (a + b)[some]).sum() / 2)


def _parted(evidence: Evidence, here: NDArray[np.int64], there: NDArray[np.int64]) -> float:
    if not evidence.cuts:
        return 0.0
    return float(np.mean([cut[here][:, None] != cut[there] for cut in evidence.cuts]))


def _straightness(evidence: Evidence, border: list[int]) -> float:
    if len(border) < 3:
        return 0.3
    one, other = evidence.one[border], evidence.other[border]
    middle = (evidence.points[one] + evidence.points[other]) / 2
    _, across, along = np.linalg.eigvalsh(np.cov(middle.T, bias=True))
    return float(np.sqrt(max(across, 0.0) / along)) if along > 0 else 0.3


def merge(
    evidence: Evidence, labels: Labels, weights: Array, apart: float = 1000.0
) -> tuple[list[frozenset[frozenset[int]]], list[float]]:
    """Merge the two regions with the lowest score until no two touch or are linked.

    Returns the two sets of first regions of each merge, and the scores.
    """
    facts, now = Facts(evidence, labels), labels.copy()
    merges: list[frozenset[frozenset[int]]] = []
    scores: list[float] = []
    while True:
        found = _best(facts, now, weights, apart)
        if found is None:
            return merges, scores
        score, i, j = found
        sides = (frozenset(labels[now == side].tolist()) for side in (i, j))
        merges.append(frozenset(sides))
        scores.append(score)
        now[now == j] = i


def _best(
    facts: Facts, labels: Labels, weights: Array, apart: float
) -> tuple[float, int, int] | None:
    touching = {tuple(sorted((labels[a], labels[b]))) for a, b in facts.pairs}
    scored = [
        (float(weights[:-1] @ cues(facts, labels, i, j) + weights[-1]), i, j)
        for i, j in touching
        if i != j
    ]
    for a, b in facts.evidence.distant.tolist():  # the nearest first
        if labels[a] != labels[b] and tuple(sorted((labels[a], labels[b]))) not in touching:
            scored.append((apart, int(labels[a]), int(labels[b])))
            break
    return min(scored, default=None)


def drawn(
    regions: Labels,
    segments: Labels,
    rows: NDArray[np.int64],
    columns: NDArray[np.int64],
    values: NDArray[np.float32],
) -> Labels:
    """A region for each pixel: of the likeliest segment within reach the likeliest region."""
    height, width = values.shape[:2]
    step = rows[1] - rows[0] if len(rows) > 1 else columns[1] - columns[0]
    out = np.empty((height, width), np.int32)
    for y in range(height):
        for x in range(width):
            near = _upper(rows, y), _upper(columns, x)
            out[y, x] = _pixel(regions, segments, rows, columns, values, (y, x), near, int(step))
    return out


def _upper(kept: NDArray[np.int64], at: int) -> int:
    """The place of the nearest value; of two, the higher one."""
    away = np.abs(kept - at)
    return int(np.flatnonzero(away == away.min())[-1])


def _pixel(
    regions: Labels,
    segments: Labels,
    rows: NDArray[np.int64],
    columns: NDArray[np.int64],
    values: NDArray[np.float32],
    at: Pair,
    near: Pair,
    step: int,
) -> int:
    def window(reach: int) -> list[Pair]:
        return [
            (i, j)
            for i in range(near[0] - reach, near[0] + reach + 1)
            for j in range(near[1] - reach, near[1] + reach + 1)
            if 0 <= i < len(rows) and 0 <= j < len(columns)
        ]

    def away(i: int, j: int) -> int:
        return int((rows[i] - at[0]) ** 2 + (columns[j] - at[1]) ** 2)

    def likeliest(parts: Labels, inside: list[Pair], around: int) -> int:
        """Of the parts of the points within reach the one that explains the pixel best."""
        names = list(dict.fromkeys(int(parts[place]) for place in [near, *inside]))
        names = [name for name in names if any(parts[place] == name for place in inside)]
        if len(names) == 1:
            return names[0]
        fits = []
        for name in names:
            members = [place for place in window(around) if parts[place] == name]
            w = np.array([np.exp(-away(i, j) / step**2 / (2 * 1.5**2)) for i, j in members])
            data = np.array([values[rows[i], columns[j]] for i, j in members], np.float64)
            fits.append(_fit(w, data, values[at].astype(np.float64)))
        return names[int(np.argmax(fits))]

    best = likeliest(segments[regions], window(1), 3)
    inside = [place for place in window(1) if segments[regions[place]] == best]
    return likeliest(regions, inside, 2)


def _fit(w: Array, data: Array, pixel: Array) -> float:
    fit = float(np.log(w.sum()))
    for c, noise in enumerate((2.0, 2.0, 2.0, 0.01)):
        known = ~np.isnan(data[:, c])
        if not known.any() or np.isnan(pixel[c]):
            continue
        mean = np.average(data[known, c], weights=w[known])
        spread = np.average((data[known, c] - mean) ** 2, weights=w[known]) + noise**2
        fit -= ((pixel[c] - mean) ** 2 / spread + np.log(spread)) / 2
    return fit
