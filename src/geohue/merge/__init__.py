"""Beyond the paper: regions that belong together are merged on all the evidence.

A fine over-segmentation of the draft follows colour, geometry and the votes of many cuts; then the
pair of neighbouring regions that most likely belongs together is merged, again and again, and what
is known of the new region is computed anew. The merges form a tree of nested segmentations.
Clouds of thin branching parts, such as plants, fall into their limbs instead.
"""
