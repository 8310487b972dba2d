"""The peers themselves: runs in their own environment, and so imports nothing of geohue.

Reads an order a line (JSON) on standard input and answers with a line. All get the same vectors,
the same Gaussian ``exp(-d^2 / (2 s^2))`` where it can be set, and the same number of landmarks.
"""

from __future__ import annotations

import json
import os
import sys
import types
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np

Result = tuple[Any, float]
"""Labels, and the moment at which the embedding was ready."""


def ncut_pytorch(x: Any, _: Any, k: int, scale: float, seed: int, samples: int = 0) -> Result:
    """As in its quick start; without `samples` its own, 10,240 of them."""
    import torch  # type: ignore[import-not-found,unused-ignore]
    from ncut_pytorch import Ncut, kway_ncut  # type: ignore[import-not-found,unused-ignore]

    torch.manual_seed(seed)
    own = {"n_sample": samples} if samples else {}
    vectors = Ncut(n_eig=k, sigma=scale, device="cpu", **own).fit_transform(torch.from_numpy(x))
    ready = perf_counter()
    return kway_ncut(vectors).argmax(1).numpy(), ready


def nystrom_ncut(x: Any, rows: Any, k: int, scale: float, seed: int) -> Result:
    """With the landmarks given, which saves it the choice of its own."""
    import torch

    # Only farthest-point sampling uses pytorch3d, which no package index has.
    sys.modules.setdefault("pytorch3d", types.ModuleType("pytorch3d"))
    ops = sys.modules.setdefault("pytorch3d.ops", types.ModuleType("pytorch3d.ops"))
    ops.sample_farthest_points = None  # type: ignore[attr-defined]
    from nystrom_ncut import (  # type: ignore[import-not-found,unused-ignore]
        AxisAlign,
        NystromNCut,
        SampleConfig,
    )
    from nystrom_ncut.distance_utils import (  # type: ignore[import-not-found,unused-ignore]
        get_normalization_factor,
    )

    torch.manual_seed(seed)
    points, chosen = torch.from_numpy(x), torch.from_numpy(rows)
    cut = NystromNCut(
        n_components=k,
        affinity_type="rbf",
        affinity_focal_gamma=float((scale / get_normalization_factor(points[chosen])) ** 2),
        sample_config=SampleConfig(method="random", num_sample=len(rows)),
    )
    vectors = cut.fit_transform(points, precomputed_sampled_indices=chosen)
    ready = perf_counter()
    return AxisAlign().fit_transform(vectors, hard=True).numpy(), ready


def nystroem(x: Any, rows: Any, k: int, scale: float, seed: int, minibatch: int = 0) -> Result:
    """Nystroem features and k-means, or k-means on batches."""
    from sklearn.cluster import KMeans, MiniBatchKMeans
    from sklearn.kernel_approximation import Nystroem

    gamma = 1 / (2 * scale**2)
    features = Nystroem(gamma=gamma, n_components=len(rows), random_state=seed).fit_transform(x)
    ready = perf_counter()
    means = (MiniBatchKMeans if minibatch else KMeans)(k, random_state=seed, n_init="auto")
    return means.fit_predict(features), ready


def spectral(x: Any, _: Any, k: int, scale: float, seed: int) -> Result:
    """The exact cut, with all affinities in memory."""
    from sklearn.cluster import SpectralClustering

    cut = SpectralClustering(k, gamma=1 / (2 * scale**2), random_state=seed, n_jobs=-1)
    return cut.fit_predict(x), perf_counter()


def felzenszwalb(picture: Any, _: Any, smallest: int) -> Result:
    """The graph-based segmentation of a picture, with usual settings."""
    from skimage.segmentation import felzenszwalb as split

    return split(picture, scale=300, sigma=0.8, min_size=smallest), perf_counter()


METHODS: dict[str, Callable[..., Result]] = {
    f.__name__: f for f in (ncut_pytorch, nystrom_ncut, nystroem, spectral, felzenszwalb)
}


def answer(order: dict[str, Any]) -> dict[str, Any]:
    """Carry out one order."""
    import torch

    folder = Path(order["folder"])
    points, rows = np.load(folder / "points.npy"), np.load(folder / "landmarks.npy")
    with torch.no_grad():
        begin, busy = perf_counter(), process_time()
        labels, ready = METHODS[order["method"]](points, rows, **order["settings"])
        end, busy = perf_counter(), process_time() - busy
    np.save(folder / "labels.npy", np.asarray(labels, np.int32))
    return {"seconds": end - begin, "embedding": ready - begin, "processor": busy}


def main() -> None:
    """Answer orders until the input ends."""
    # Libraries print what they like; the answers keep the real standard output for themselves.
    channel = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    import torch

    torch.set_num_threads(int(sys.argv[1]))
    torch.set_flush_denormal(True)  # tiny affinities would slow the peers down
    names = ("torch", "ncut_pytorch", "nystrom_ncut", "scikit-learn", "scikit-image", "numpy")
    print(json.dumps({name: version(name) for name in names}), file=channel, flush=True)
    for line in sys.stdin:
        try:
            found = answer(json.loads(line))
        except Exception as error:
            found = {"error": f"{type(error).__name__}: {error}"}
        print(json.dumps(found), file=channel, flush=True)


if __name__ == "__main__":
    main()
