"""Sec. IV: the weight between colour and geometry."""
