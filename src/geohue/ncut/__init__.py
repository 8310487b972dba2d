"""Sec. III: normalized cuts."""
