"""Threads, compiled loops, k-means and arrays: what knows nothing of scenes."""
