"""
The paper's weight and its quality Q
====================================

The preset ``paper`` chooses the weight of geometry against colour by the quality Q of the
segments, without labels (Sec. IV of the paper).
"""

import matplotlib.pyplot as plt
import numpy as np

import geohue
from geohue.measures import variation_of_information
from geohue.simulate import scene

frame, truth = scene("boxes", sensor="tof")
seg = geohue.segment(frame, k=int(truth.max()) + 1, preset="paper")
weights, quality = np.array(seg.weight_curve).T

# %%
# The error against the truth is known here, because the scene is simulated. Q does not know it.

errors = [
    variation_of_information(
        geohue.segment(frame, k=seg.k, weight=float(w), preset="paper").labels, truth, ignore=None
    ).total
    for w in weights[::2]
]

figure, axis = plt.subplots(figsize=(7, 4), layout="constrained")
axis.semilogx(weights, quality, "o-", base=2, color="#0072B2")
axis.axvline(seg.weight, color="#0072B2", linestyle=":")
axis.set_xlabel("weight of geometry, lambda")
axis.set_ylabel("quality Q", color="#0072B2")
other = axis.twinx()
other.semilogx(weights[::2], errors, "s--", base=2, color="#D55E00")
other.set_ylabel("error, bits", color="#D55E00")
