"""How far the passes of the cut are from what this machine can do.

    python benchmarks/limits.py [--points 307200] [--landmarks 100] [--rounds 9]

Measured in one run, turn by turn, on one thread and on all: the exponential (numpy's, and a
polynomial that the compiler turns into vector code in a bare loop), products of matrices, the
memory, and geohue's own passes over all points and landmarks, float32. Nanoseconds an element are
wall time over (points x landmarks). The bound of a pass is the sum of what it cannot do without:
an exponential, a product with 6 columns, and for the Gram pass a symmetric product of the block
with itself, for the label pass a product with the K = 5 columns of the basis; the ratio is that of
the pass to its bound.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import sgemm, ssyrk

from geohue.compute.compiled import vectorized
from geohue.compute.parallel import BLOCK, Workers, cores, workers
from geohue.jobs.machine import describe_machine
from geohue.ncut.kernel import Kernel
from geohue.ncut.loops import SMALLEST, exp2
from geohue.settings import PRESETS

K, DIMENSIONS = 5, 6
FLOATS = 16_384
"""Numbers that a bare loop works on: 64 KB, near to the core."""

Array = NDArray[np.float32]


@vectorized
def power_of_two(values: Array, out: Array) -> None:
    """Do nothing but the exponential."""
    for i in range(len(values)):
        out[i] = exp2(values[i])


@dataclass(slots=True)
class Measure:
    """Something timed: what one call does, and how often a turn calls it."""

    name: str
    work: Callable[[Any], object]
    elements: float
    calls: int

    def rate(self, team: Workers) -> float:
        """Return nanoseconds an element, all threads together."""
        begin = perf_counter()
        for _ in team.map(self.work, range(self.calls)):
            pass
        return 1e9 * (perf_counter() - begin) / (self.calls * self.elements)


def repeated(action: Callable[[], object], times: int) -> Callable[[Any], object]:
    """Return what does a short thing so often that starting it costs nothing."""

    def work(_: Any) -> None:
        for _ in range(times):
            action()

    return work


def machine(n: int, rng: np.random.Generator) -> list[Measure]:
    """Return the measures of the machine; each call has arrays of its own threads' size."""
    powers = (SMALLEST * rng.random(FLOATS)).astype(np.float32)
    logs = powers * np.float32(np.log(2))
    points = rng.random((BLOCK, DIMENSIONS), np.float32)
    columns = rng.random((DIMENSIONS, n), np.float32)
    block = rng.random((BLOCK, n), np.float32)
    basis = rng.random((n, K), np.float32)
    square = np.asfortranarray(rng.random((768, 768), np.float32))
    large = rng.random(2**24, np.float32)

    def with_room(shape: tuple[int, ...], call: Callable[[Array], object]) -> Callable[[], object]:
        return lambda: call(np.empty(shape, np.float32))

    room = (FLOATS,)
    return [
        Measure(
            "numpy exp",
            repeated(with_room(room, lambda o: np.exp(logs, out=o)), 20),
            20 * FLOATS,
            8,
        ),
        Measure(
            "polynomial exp, bare loop",
            repeated(with_room(room, lambda o: power_of_two(powers, o)), 50),
            50 * FLOATS,
            8,
        ),
        Measure(
            "product with 6 columns",
            repeated(with_room((BLOCK, n), lambda o: np.dot(points, columns, out=o)), 4),
            4 * BLOCK * n,
            8,
        ),
        Measure(
            f"product with K = {K} columns",
            repeated(with_room((BLOCK, K), lambda o: np.dot(block, basis, out=o)), 8),
            8 * BLOCK * n,
            8,
        ),
        Measure(
            "symmetric product of a block (ssyrk)",
            repeated(lambda: ssyrk(1.0, block.T), 4),
            4 * BLOCK * n,
            8,
        ),
        Measure(
            "sgemm, 768 x 768", repeated(lambda: sgemm(1.0, square, square), 1), 2 * 768.0**3, 8
        ),
        Measure(
            "memory, read one and write one",
            repeated(with_room(large.shape, lambda o: np.copyto(o, large)), 1),
            8 * len(large),
            4,
        ),
    ]


def passes(count: int, n: int, rng: np.random.Generator) -> dict[str, Callable[[Workers], object]]:
    """Return geohue's passes over all points."""
    x = rng.normal(0, 0.6, (count, DIMENSIONS)).astype(np.float32)
    kernel = Kernel.of(x[rng.choice(count, n, replace=False)], PRESETS["paper"].cut.scale)
    ones, basis = np.ones(n, np.float32), rng.normal(size=(n, K)).astype(np.float32)
    centers = rng.normal(size=(K, K)).astype(np.float32)

    def over_blocks(call: Callable[[Array], object]) -> Callable[[Workers], object]:
        return lambda team: [None for _ in team.map_blocks(lambda rows: call(x[rows]), count)]

    return {
        "affinity pass (column sums)": over_blocks(kernel.column_sums),
        "Gram pass": over_blocks(lambda part: kernel.gram(part, ones)),
        "label pass": over_blocks(lambda part: kernel.nearest(part, basis, centers)),
    }


BOUNDS = {
    "affinity pass (column sums)": (),
    "Gram pass": ("symmetric product of a block (ssyrk)",),
    "label pass": (f"product with K = {K} columns",),
}
NEEDED = ("polynomial exp, bare loop", "product with 6 columns")


def measure(points: int, n: int, rounds: int, threads: int) -> dict[str, float]:
    """Return the median nanoseconds an element of everything, with so many threads."""
    rng = np.random.default_rng(0)
    basics, own = machine(n, rng), passes(points, n, rng)
    found: dict[str, list[float]] = {name: [] for name in [m.name for m in basics] + list(own)}
    with workers(threads) as team:
        for turn in range(rounds + 1):
            rates = {m.name: m.rate(team) for m in basics}
            for name, run in own.items():
                begin = perf_counter()
                run(team)
                rates[name] = 1e9 * (perf_counter() - begin) / (points * n)
            if turn:
                for name, rate in rates.items():
                    found[name].append(rate)
    return {name: median(rates) for name, rates in found.items()}


def accuracy() -> float:
    """Return the largest relative error of the polynomial over its whole range."""
    powers = np.linspace(SMALLEST, 0, 4_000_001).astype(np.float32)
    out = np.empty_like(powers)
    power_of_two(powers, out)
    exact = np.exp2(powers.astype(np.float64))
    return float(np.abs(out / exact - 1).max())


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=307_200)
    parser.add_argument("--landmarks", type=int, default=100)
    parser.add_argument("--rounds", type=int, default=9)
    given = parser.parse_args()
    print("; ".join(f"{key} {value}" for key, value in describe_machine().items()))
    print(f"{given.points:,} points x {given.landmarks} landmarks, {DIMENSIONS}-D, float32\n")
    counts = sorted({1, cores()})
    found = [measure(given.points, given.landmarks, given.rounds, count) for count in counts]
    print("| | " + " | ".join(f"{count} thread(s)" for count in counts) + " |")
    print("| --- |" + " --: |" * len(counts))
    for name in found[0]:
        if name not in BOUNDS:
            print(f"| {name} | " + " | ".join(_written(name, f[name]) for f in found) + " |")
    for name, further in BOUNDS.items():
        cells = []
        for rates in found:
            bound = sum(rates[part] for part in (*NEEDED, *further))
            cells.append(f"{rates[name]:.2f} ns = {rates[name] / bound:.2f} x {bound:.2f} ns")
        print(f"| {name} | " + " | ".join(cells) + " |")
    print(f"\nLargest relative error of the polynomial exp: {accuracy():.1e}")


def _written(name: str, rate: float) -> str:
    """Write nanoseconds, or what of them is better known by another unit."""
    if name.startswith("sgemm"):
        return f"{1 / rate:.0f} GFLOP/s"
    return f"{1 / rate:.1f} GB/s" if name.startswith("memory") else f"{rate:.2f} ns"


if __name__ == "__main__":
    main()
