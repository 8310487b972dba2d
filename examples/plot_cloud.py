"""
A cloud without colour falls into limbs
=======================================

Thin branching clouds, such as plants, trees or cables, are split into their limbs. No colour is
needed.
"""

import matplotlib.pyplot as plt
import numpy as np

import geohue
from geohue.measures import evaluate
from geohue.results.picture import paint
from geohue.simulate.branching import branching_cloud

points, truth = branching_cloud("maize", seed=3)
scene = geohue.Scene.from_cloud(points, np.full((len(points), 3), 128, np.uint8))
seg = geohue.segment(scene)
scores = evaluate(seg.labels, truth, ignore=None)

figure = plt.figure(figsize=(9, 5), layout="constrained")
for at, (labels, title) in enumerate(
    ((truth, "truth"), (seg.labels, f"{seg.k} limbs, {scores['voi_bits']:.2f} bits off"))
):
    axis = figure.add_subplot(1, 2, at + 1, projection="3d")
    axis.scatter(*points.T, c=paint(labels.astype(np.int32)) / 255, s=1)
    axis.set_title(title)
    axis.set_aspect("equal")
    axis.set_axis_off()
