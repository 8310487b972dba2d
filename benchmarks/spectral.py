"""Spectral clustering of vectors: time, memory and agreement with scikit-learn.

    env -u OPENBLAS_CORETYPE -u OPENBLAS_L2_SIZE python benchmarks/spectral.py [--large 1000000]

Three kinds of vectors: 8 overlapping Gaussian groups in ten dimensions, 3 rings of noise in the
plane, and the 6-D vectors of colour and place of the motorcycle sample (drawn with a jitter of 1 %,
so that no two coincide; there are no true groups). Each method runs in a process of its own, with
the gamma that `NystromNormalizedCut` chose (20 for the rings), on two sizes of table:

- small ones, where `SpectralClustering` (rbf) runs: seconds, memory beyond the data, and the
  adjusted Rand index with its labels and with the true groups; medians over `--seeds`;
- a large one, with a limit on the memory and on the time of each process.

A last table says where disagreement comes from: from the landmarks (300 against all, which is the
exact cut) or from how labels are made of the same eigenvectors (scikit-learn's own three ways).
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LANDMARKS = 300
CLUSTERS = {"groups": 8, "rings": 3, "scene": 5}
GAMMAS = {"rings": 20.0}  # thin shapes want a narrower affinity than the automatic one


def groups(n: int) -> tuple[Array, NDArray[np.int64] | None]:
    """Make overlapping Gaussian groups."""
    from sklearn.datasets import make_blobs

    x, truth = make_blobs(n, 10, centers=8, cluster_std=3.5, random_state=3)
    return x, truth


def rings(n: int) -> tuple[Array, NDArray[np.int64] | None]:
    """Make rings around each other."""
    rng = np.random.default_rng(0)
    truth = rng.integers(3, size=n)
    angle = rng.uniform(0, 2 * np.pi, n)
    radius = 1.0 + truth + rng.normal(0, 0.13, n)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1), truth


def scene(n: int) -> tuple[Array, NDArray[np.int64] | None]:
    """Draw from the vectors of a scene."""
    from geohue.datasets import load_sample
    from geohue.features import extract_features

    vectors = extract_features(load_sample("motorcycle")).mixed(1.0).astype(np.float64)
    rng = np.random.default_rng(0)
    drawn = vectors[rng.integers(len(vectors), size=n)]
    return drawn + rng.normal(0, 0.01, drawn.shape), None


DATA = {"groups": groups, "rings": rings, "scene": scene}


def ours(file: Path, k: int, gamma: float | None, seed: int) -> tuple[Any, float | None]:
    """Run geohue's."""
    from geohue import NystromNormalizedCut

    model = NystromNormalizedCut(
        k, gamma=gamma or "auto", n_landmarks=LANDMARKS, random_state=seed, n_jobs=-1
    )
    if file.suffix == ".mapped":
        model.fit_large(np.load(file, mmap_mode="r"))
    else:
        model.fit(np.load(file))
    return model.labels_, model.gamma_


def spectral(file: Path, k: int, gamma: float | None, seed: int) -> tuple[Any, float | None]:
    """Run scikit-learn's on all affinities."""
    from sklearn.cluster import SpectralClustering

    model = SpectralClustering(k, gamma=gamma, random_state=seed, n_jobs=-1)
    return model.fit(np.load(file)).labels_, gamma


def neighbours(file: Path, k: int, gamma: float | None, seed: int) -> tuple[Any, float | None]:
    """Run scikit-learn's on a graph of neighbours."""
    from sklearn.cluster import SpectralClustering

    model = SpectralClustering(k, affinity="nearest_neighbors", random_state=seed, n_jobs=-1)
    return model.fit(np.load(file)).labels_, gamma


def features(file: Path, k: int, gamma: float | None, seed: int) -> tuple[Any, float | None]:
    """Run k-means on scikit-learn's Nystrom features."""
    from sklearn.cluster import KMeans
    from sklearn.kernel_approximation import Nystroem

    made = Nystroem(gamma=gamma, n_components=LANDMARKS, random_state=seed)
    rows = made.fit_transform(np.load(file))
    return KMeans(k, n_init=5, random_state=seed).fit(rows).labels_, gamma


METHODS: dict[str, Callable[..., tuple[Any, float | None]]] = {
    "NystromNormalizedCut": ours,
    "SpectralClustering": spectral,
    "SpectralClustering, nearest neighbours": neighbours,
    "Nystroem + KMeans": features,
}


@dataclass(frozen=True, slots=True)
class Run:
    """What a process said, or why it said nothing."""

    seconds: float = np.nan
    megabytes: float = np.nan
    gamma: float | None = None
    labels: NDArray[np.int32] | None = None
    failure: str = ""


def work(method: str, file: Path, k: int, gamma: float | None, seed: int, out: Path) -> None:
    """Run one method once, in this process, and print what it took."""
    METHODS[method](out / "warm.npy", 2, 1.0, 0)  # imports, compiled loops
    data = np.load(file, mmap_mode="r").nbytes if file.suffix == ".npy" else 0
    before, begin = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.perf_counter()
    labels, used = METHODS[method](file, k, gamma, seed)
    seconds = time.perf_counter() - begin
    peak = 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) - data
    np.save(out / "labels.npy", labels)
    print(json.dumps({"seconds": seconds, "megabytes": max(peak, 0) / 1e6, "gamma": used}))


def run(
    method: str,
    file: Path,
    k: int,
    gamma: float | None = None,
    seed: int = 0,
    memory: float = np.inf,
    patience: float | None = None,
) -> Run:
    """Run one method in a process with a limit on its memory (bytes) and time (s)."""
    given = ["--worker", method, str(file), str(k), json.dumps(gamma), str(seed)]

    def limit() -> None:
        if memory < np.inf:
            resource.setrlimit(resource.RLIMIT_AS, (int(memory), int(memory)))

    try:
        done = subprocess.run(
            [sys.executable, __file__, *given],
            capture_output=True,
            text=True,
            timeout=patience,
            preexec_fn=limit,
        )
    except subprocess.TimeoutExpired:
        return Run(failure=f"no result in {patience:.0f} s")
    if done.returncode:
        last = done.stderr.strip().splitlines()[-1:] or [f"exit {done.returncode}"]
        return Run(
            failure=last[0].split(" for an array")[0].replace("numpy._core._exceptions.", "")
        )
    said = json.loads(done.stdout.splitlines()[-1])
    return Run(**said, labels=np.load(file.parent / "labels.npy"))


def rand(a: Any, b: Any) -> str:
    """Return the adjusted Rand index for a table."""
    from sklearn.metrics import adjusted_rand_score

    return "" if a is None or b is None else f"{adjusted_rand_score(a, b):.3f}"


def row(name: str, n: int, method: str, runs: list[Run], exact: Run | None, truth: Any) -> None:
    """Print a row of a table: medians over the runs."""
    if runs[0].failure:
        print(f"| {name} | {n:,} | {method} | {runs[0].failure} | | | |", flush=True)
        return
    seconds = np.median([r.seconds for r in runs])
    megabytes = np.median([r.megabytes for r in runs])
    with_exact = sorted(rand(r.labels, exact.labels if exact else None) for r in runs)
    with_truth = sorted(rand(r.labels, truth) for r in runs)
    middle = len(runs) // 2
    print(f"| {name} | {n:,} | {method} | {seconds:.2f} | {megabytes:.0f} ", end="")
    print(f"| {with_exact[middle]} | {with_truth[middle]} |", flush=True)


def head() -> None:
    """Print the head of a table."""
    print("| vectors | N | method | s | MB | ARI with SpectralClustering | ARI with truth |")
    print("| --- | ---: | --- | ---: | ---: | ---: | ---: |")


def small(folder: Path, names: list[str], sizes: list[int], seeds: int) -> None:
    """Print the table of the sizes where all run."""
    head()
    for name in names:
        k = CLUSTERS[name]
        for n in sizes:
            x, truth = DATA[name](n)
            np.save(folder / "x.npy", x)
            gamma = GAMMAS.get(name)
            mine = [
                run("NystromNormalizedCut", folder / "x.npy", k, gamma, s) for s in range(seeds)
            ]
            gamma = mine[0].gamma
            exact = run("SpectralClustering", folder / "x.npy", k, gamma)
            other = [run("Nystroem + KMeans", folder / "x.npy", k, gamma, s) for s in range(seeds)]
            row(name, n, "SpectralClustering", [exact], None, truth)
            row(name, n, "NystromNormalizedCut", mine, exact, truth)
            row(name, n, "Nystroem + KMeans", other, exact, truth)


def large(folder: Path, names: list[str], n: int, memory: float, patience: float) -> None:
    """Print the table of a size where few run."""
    print(f"\nat most {memory / 1e9:.0f} GB of address space and {patience:.0f} s each\n")
    head()
    for name in names:
        k, gamma = CLUSTERS[name], GAMMAS.get(name)
        x, truth = DATA[name](n)
        np.save(folder / "x.npy", x)
        with (folder / "x.mapped").open("wb") as file:
            np.save(file, x.astype(np.float32))
        del x
        mine = run("NystromNormalizedCut", folder / "x.npy", k, gamma, 0, memory, patience)
        row(name, n, "NystromNormalizedCut", [mine], None, truth)
        mapped = run("NystromNormalizedCut", folder / "x.mapped", k, gamma, 0, memory, patience)
        row(name, n, "the same, fit_large, float32 file", [mapped], None, truth)
        for method in list(METHODS)[1:]:
            found = run(method, folder / "x.npy", k, mine.gamma, 0, memory, patience)
            row(name, n, method, [found], None, truth)


def sources(names: list[str], n: int = 2000) -> None:
    """Print where disagreement comes from."""
    from sklearn.cluster import SpectralClustering

    from geohue import NystromNormalizedCut

    print(f"\n{n:,} vectors; SpectralClustering labels by k-means unless said\n")
    print("| vectors | ours: 300 landmarks, all | SpectralClustering: k-means, discretize ", end="")
    print("| k-means, cluster_qr | ours, theirs: k-means | discretize | cluster_qr |")
    print("| --- |" + " ---: |" * 6)
    for name in names:
        k, (x, _) = CLUSTERS[name], DATA[name](n)
        first = NystromNormalizedCut(k, gamma=GAMMAS.get(name, "auto"), random_state=0).fit(x)
        mine, theirs = {}, {}
        for way in ("kmeans", "discretize", "cluster_qr"):
            same: dict[str, Any] = {"gamma": first.gamma_, "random_state": 0, "assign_labels": way}
            mine[way] = NystromNormalizedCut(k, **same).fit(x).labels_
            theirs[way] = SpectralClustering(k, **same).fit(x).labels_
        whole = NystromNormalizedCut(k, gamma=first.gamma_, n_landmarks=n, random_state=0).fit(x)
        print(f"| {name} | {rand(first.labels_, whole.labels_)} ", end="")
        print(f"| {rand(theirs['kmeans'], theirs['discretize'])} ", end="")
        print(f"| {rand(theirs['kmeans'], theirs['cluster_qr'])} ", end="")
        print("".join(f"| {rand(mine[way], theirs[way])} " for way in mine) + "|", flush=True)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", type=int, nargs="*", default=[1_000, 5_000, 10_000])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--large", type=int, default=1_000_000, help="0: none")
    parser.add_argument("--vectors", nargs="*", choices=list(DATA), default=list(DATA))
    parser.add_argument("--memory", type=float, default=8e9, help="bytes")
    parser.add_argument("--patience", type=float, default=300, help="seconds")
    parser.add_argument("--worker", nargs=5, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.worker:
        method, file, k, gamma, seed = given.worker
        work(method, Path(file), int(k), json.loads(gamma), int(seed), Path(file).parent)
        return
    for name in ("OPENBLAS_CORETYPE", "OPENBLAS_L2_SIZE"):
        os.environ.pop(name, None)
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        np.save(folder / "warm.npy", np.random.default_rng(0).normal(size=(200, 3)))
        if given.sizes:
            small(folder, given.vectors, given.sizes, given.seeds)
            sources(given.vectors)
        if given.large:
            large(folder, given.vectors, given.large, given.memory, given.patience)


if __name__ == "__main__":
    main()
