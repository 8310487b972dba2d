"""How close the Nystrom cut comes to the exact one, by number and choice of landmarks.

    python benchmarks/landmarks.py

The motorcycle sample, thinned to 2,500 points so that the exact cut is affordable; lambda = 1,
five eigenvectors. The overlap is the mean squared cosine of the angles between the two subspaces
(1 = the same), the agreement the adjusted Rand index of the labels; medians over five seeds.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg
from sklearn.metrics import adjusted_rand_score

from geohue.compute.lloyd import nearest_center
from geohue.compute.parallel import Workers
from geohue.datasets import load_sample
from geohue.features import extract_features
from geohue.ncut.affinity import affinity
from geohue.ncut.labels import find_centers
from geohue.ncut.landmarks import choose_landmarks
from geohue.ncut.nystrom import nystrom_cut
from geohue.settings.cut import LANDMARK_CHOICES, SCALE

K, SEEDS = 5, 5


def main() -> None:
    """Print the table."""
    scene = load_sample("motorcycle")
    positions = scene.thinning(2500, np.random.default_rng(0))
    x = extract_features(scene).at(positions).mixed(1.0).astype(np.float64)
    w = affinity(x, x)
    root = np.sqrt(w.sum(axis=1))
    _, vectors = scipy.linalg.eigh(
        w / np.outer(root, root), subset_by_index=(len(x) - K, len(x) - 1)
    )
    rows = vectors[:, ::-1] / np.linalg.norm(vectors, axis=1, keepdims=True)
    exact = nearest_center(rows, find_centers(rows, K, "kmeans", np.random.default_rng(0)))
    print(f"{len(x)} points, scale {SCALE}, K = {K}\n")
    print("| landmarks | choice | overlap with the exact cut | agreement of labels |")
    print("| ---: | --- | ---: | ---: |")
    for n in (50, 100, 200, 400):
        for choice in LANDMARK_CHOICES:
            found = []
            for seed in range(SEEDS):
                rng = np.random.default_rng(seed)
                landmarks = x[choose_landmarks(x, n, choice, rng)]
                cut = nystrom_cut(x, landmarks, Workers(None), K)
                angles = scipy.linalg.subspace_angles(cut.entries(x, K), vectors)
                mine = cut.rows(x, K).astype(np.float64)
                labels = nearest_center(mine, find_centers(mine, K, "kmeans", rng))
                found.append(((np.cos(angles) ** 2).mean(), adjusted_rand_score(exact, labels)))
            overlap, agreement = np.median(found, axis=0)
            print(f"| {n} | {choice} | {overlap:.2f} | {agreement:.2f} |")


if __name__ == "__main__":
    main()
