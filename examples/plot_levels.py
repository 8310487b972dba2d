"""
Coarse, default and fine from one run
=====================================

The default finds nested segmentations. ``detail`` chooses one of them, before or after the run.
"""

import matplotlib.pyplot as plt

import geohue
from geohue.datasets import load_sample
from geohue.results.picture import overlay

scene = load_sample("motorcycle")
seg = geohue.segment(scene)
image = scene.colors

# %%
# ``seg.levels.at`` answers at once: nothing is computed anew.

figure, axes = plt.subplots(1, 3, figsize=(12, 3), layout="constrained")
for axis, detail in zip(axes, ("coarse", "auto", "fine"), strict=True):
    axis.imshow(overlay(image, seg.levels.at(detail)))
    axis.set_title(f"{detail}: {seg.levels.count(detail)} segments")
    axis.set_axis_off()

# %%
# All borders at once. A border is as dark as it is likely to part two things.

from geohue.results.borders import paint_borders

figure, axis = plt.subplots(figsize=(8, 5), layout="constrained")
axis.imshow(paint_borders(image, seg.levels))
axis.set_axis_off()
