"""What Q and the contrast add up over the points, in compiled passes that hold no lock.

Segments come in runs: a pass adds up a run in registers, and then adds the run to its segment.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geohue.compute.compiled import compiled, compiled_part


@compiled_part
def run_end(labels: NDArray[np.int32], first: int) -> int:
    """The position after the last point of the run of equal labels that begins at `first`."""
    p = first + 1
    while p < labels.size and labels[p] == labels[first]:
        p += 1
    return p


@compiled
def add_colors(
    labels: NDArray[np.int32],
    colors: NDArray[np.uint8],
    sizes: NDArray[np.int64],
    sums: NDArray[np.int64],
    squares: NDArray[np.int64],
) -> None:
    """Count the points of each segment; add up their colours and the squares of these."""
    p = 0
    while p < labels.size:
        s, end = labels[p], run_end(labels, p)
        if s >= 0:
            sizes[s] += end - p
            for c in range(3):
                total, square = np.int64(0), np.int64(0)
                for q in range(p, end):
                    value = np.int64(colors[q, c])
                    total += value
                    square += value * value
                sums[s, c] += total
                squares[s, c] += square
        p = end


@compiled
def add_distances(
    labels: NDArray[np.int32],
    values: NDArray[np.float32],
    center: NDArray[np.float64],
    squared: bool,
    sums: NDArray[np.float64],
) -> None:
    """Add up, for each segment, its points' values less the centre, or the squares of that."""
    p = 0
    while p < labels.size:
        s, end = labels[p], run_end(labels, p)
        if s >= 0:
            for c in range(values.shape[1]):
                total = 0.0
                for q in range(p, end):
                    distance = np.float64(values[q, c]) - center[s, c]
                    total += distance * distance if squared else distance
                sums[s, c] += total
        p = end


@compiled
def add_texture(
    labels: NDArray[np.int32],
    interior: NDArray[np.bool_],
    local: NDArray[np.float32],
    counts: NDArray[np.int64],
    sums: NDArray[np.float64],
) -> None:
    """Count the interior points of each segment and add up their local deviations."""
    p = 0
    while p < labels.size:
        s, end = labels[p], run_end(labels, p)
        if s >= 0:
            count, total = 0, 0.0
            for q in range(p, end):
                if interior[q]:
                    count += 1
                    total += np.float64(local[q])
            counts[s] += count
            sums[s] += total
        p = end


@compiled
def add_steps(
    labels: NDArray[np.int32],
    one: NDArray[np.int64],
    other: NDArray[np.int64],
    step: NDArray[np.float64],
    counts: NDArray[np.int64],
    sums: NDArray[np.float64],
) -> None:
    """Count the pairs of labelled points and add up their steps: all (0), across borders (1)."""
    for i in range(one.size):
        a, b = labels[one[i]], labels[other[i]]
        if a >= 0 and b >= 0:
            counts[0] += 1
            sums[0] += step[i]
            if a != b:
                counts[1] += 1
                sums[1] += step[i]


@compiled
def shared_information(
    order: NDArray[np.int64],
    one: NDArray[np.int32],
    other: NDArray[np.int32],
    weight: NDArray[np.int64],
    log: NDArray[np.float64],
    cell: NDArray[np.int64],
    in_other: NDArray[np.int64],
) -> float:
    """Variation of information between two segmentations, in the unit of the logarithm.

    ``weight`` counts the points behind each entry. ``order`` lists the entries with a label in
    the first one, segment by segment, so that a row of the table of overlaps is all that is ever
    held: ``cell``, and ``in_other`` for the sizes in the other one, come in and go out as zeros.
    ``log[n]`` is n log n.
    """
    joint, in_one, n = 0.0, 0.0, 0
    first = 0
    while first < order.size:
        end, size = first, 0
        while end < order.size and one[order[end]] == one[order[first]]:
            label = other[order[end]]
            if label >= 0:
                cell[label] += weight[order[end]]
                size += weight[order[end]]
            end += 1
        for i in range(first, end):
            label = other[order[i]]
            if label >= 0 and cell[label] > 0:
                joint += log[cell[label]]
                in_other[label] += cell[label]
                cell[label] = 0
        in_one += log[size]
        n += size
        first = end
    total = in_one - 2 * joint
    for i in range(order.size):
        label = other[order[i]]
        if label >= 0 and in_other[label] > 0:
            total += log[in_other[label]]
            in_other[label] = 0
    return total / n if n > 0 else 0.0


@compiled
def window_interior(labels: NDArray[np.int32], out: NDArray[np.bool_]) -> None:
    """Whether the 3 x 3 window of a pixel lies in one segment; ``out`` comes in as all False."""
    height, width = labels.shape
    for y in range(1, height - 1):
        for x in range(1, width - 1):
            here = labels[y, x]
            other = np.int32(0)
            for dy in range(-1, 2):
                for dx in range(-1, 2):
                    other |= labels[y + dy, x + dx] ^ here
            out[y, x] = (other == 0) & (here >= 0)


@compiled
def window_deviation(
    colors: NDArray[np.uint8],
    euclidean: bool,
    sums: NDArray[np.int32],
    squares: NDArray[np.int32],
    channels: NDArray[np.float32],
    out: NDArray[np.float32],
) -> None:
    """Deviation in the 3 x 3 window around each pixel, its three channels as one number.

    ``colors`` is (H, 3 W) and ``out`` (H, W), whose frame stays as it is; ``sums`` and ``squares``
    have room for a row of colours, ``channels`` for one without the first and the last pixel.
    """
    for y in range(1, out.shape[0] - 1):
        _add_rows(colors[y - 1], colors[y], colors[y + 1], sums, squares)
        _deviate(sums, squares, euclidean, channels)
        _combine(channels, euclidean, out[y, 1:-1])


@compiled_part
def _add_rows(
    up: NDArray[np.uint8],
    here: NDArray[np.uint8],
    down: NDArray[np.uint8],
    sums: NDArray[np.int32],
    squares: NDArray[np.int32],
) -> None:
    for i in range(here.size):
        a, b, c = np.int32(up[i]), np.int32(here[i]), np.int32(down[i])
        sums[i] = a + b + c
        squares[i] = a * a + b * b + c * c


@compiled_part
def _deviate(
    sums: NDArray[np.int32],
    squares: NDArray[np.int32],
    euclidean: bool,
    channels: NDArray[np.float32],
) -> None:
    """Deviation of each channel in 0..1, or its square; whole numbers keep the difference exact."""
    n = channels.size
    one, two, three = sums[:n], sums[3 : n + 3], sums[6:]
    square_one, square_two, square_three = squares[:n], squares[3 : n + 3], squares[6:]
    for i in range(n):
        total = one[i] + two[i] + three[i]
        square = square_one[i] + square_two[i] + square_three[i]
        variance = np.float32(9 * square - total * total) / np.float32(81 * 255**2)
        channels[i] = variance if euclidean else np.sqrt(variance)


@compiled_part
def _combine(channels: NDArray[np.float32], euclidean: bool, out: NDArray[np.float32]) -> None:
    for x in range(out.size):
        total = channels[3 * x] + channels[3 * x + 1] + channels[3 * x + 2]
        out[x] = np.sqrt(total) if euclidean else total
