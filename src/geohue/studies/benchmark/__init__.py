"""Segmentations of whole folders, measured against their true labels."""
