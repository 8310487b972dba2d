"""Segmentation of scenes from colour and geometry together."""
