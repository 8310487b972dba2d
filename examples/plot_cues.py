"""
Colour, geometry, and both
==========================

A poster on a wall differs from it in colour alone. A white box before a white wall differs from it
in depth alone. Only both cues together find everything.
"""

import matplotlib.pyplot as plt

import geohue
from geohue.measures import variation_of_information
from geohue.results.picture import overlay
from geohue.simulate import scene

frame, truth = scene("posters", sensor="kinect")
image = frame.colors

figure, axes = plt.subplots(2, 2, figsize=(8, 6), layout="constrained")
axes[0, 0].imshow(overlay(image, truth))
axes[0, 0].set_title(f"truth: {truth.max() + 1} parts")
for axis, cues in zip(axes.flat[1:], ("color", "geometry", "fusion"), strict=True):
    seg = geohue.segment(frame, cues=cues)
    error = variation_of_information(seg.labels, truth, ignore=None).total
    axis.imshow(overlay(image, seg.labels))
    axis.set_title(f"{cues}: {seg.k} segments, {error:.2f} bits from the truth")
for axis in axes.flat:
    axis.set_axis_off()
