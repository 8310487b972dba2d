"""How good a segmentation is, measured against true labels."""
