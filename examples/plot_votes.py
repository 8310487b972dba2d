"""
Cuts that vote
==============

The default does not choose a weight of geometry against colour. Cuts of several weights into
several numbers of segments vote on where the borders are.
"""

import matplotlib.pyplot as plt

import geohue
from geohue.datasets import load_sample
from geohue.results.picture import overlay

scene = load_sample("motorcycle")
image = scene.colors

# %%
# Four of the cuts. Each puts some borders right and others anywhere.

figure, axes = plt.subplots(2, 2, figsize=(9, 6.4), layout="constrained")
cuts = [(0.0, 4), (1.0, 4), (1.0, 9), (float("inf"), 9)]
for axis, (weight, k) in zip(axes.flat, cuts, strict=True):
    cut = geohue.segment(scene, preset="paper", weight=weight, k=k)
    axis.imshow(overlay(image, cut.labels))
    name = {0.0: "colour alone", 1.0: "both", float("inf"): "geometry alone"}[weight]
    axis.set_title(f"{name}, into {k}")
    axis.set_axis_off()

# %%
# Where many cuts agree there is a border. The votes are one of fifteen cues of the merging.

figure, axis = plt.subplots(figsize=(8, 5), layout="constrained")
seg = geohue.segment(scene)
axis.imshow(overlay(image, seg.labels))
axis.set_title(f"the default: {seg.k} segments")
axis.set_axis_off()
