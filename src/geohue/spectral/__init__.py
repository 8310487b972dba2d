"""Sec. III on any vectors, in memory or not: what `geohue.NystromNormalizedCut` computes."""
